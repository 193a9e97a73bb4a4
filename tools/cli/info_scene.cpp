// info: scenes.
#include "info_report.h"
#include "text_table.h"

#include <volcaustic/options.h>
#include <volcaustic/scene.h>
#include <volcaustic/shape_fields.h>

#include <algorithm>
#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

using enum TextTable::Align;

std::string triple(const std::array<double, 3>& v) { return fmt::format("{:g} {:g} {:g}", v[0], v[1], v[2]); }

void printVolume(const SceneVolume& v) {
  if (!v.file.empty()) {
    fmt::print("  medium    {}\n", v.file.string());
    return;
  }
  const std::string fineness = v.voxelSize > 0 ? fmt::format("voxels of {:g} world units", v.voxelSize)
                                               : fmt::format("{} voxels along its longest side", v.resolution);
  if (v.automatic)
    fmt::print("  box       around the objects, {:g} of their longest side wider all round; {}\n", v.margin, fineness);
  else
    fmt::print("  box       {} to {} world units; {}\n", triple(v.bounds.min), triple(v.bounds.max), fineness);
  fmt::print("  outside   index {:g}, attenuation {}, scattering {} per world unit, asymmetry {:g}\n", v.ambient.index,
             triple(v.ambient.attenuation), triple(v.ambient.scattering), v.ambient.asymmetry);
}

std::string groupsText(const SceneObject& o) {
  std::string text;
  for (const SceneGroup& g : o.groups) text += (text.empty() ? "" : ", ") + g.name + ": " + g.material;
  return text.empty() ? "-" : plain(text);
}

/// What the grids of a volume are: "attenuation: density".
std::string gridsText(const SceneObject& o) {
  std::string text;
  for (const PropertyGrid& p : o.grids)
    text += (text.empty() ? "" : ", ") + std::string(enumNames(p.property)[static_cast<std::size_t>(p.property)]) +
            ": " + p.mapping.grid;
  return plain(text);
}

void printObjects(const Scene& scene) {
  TextTable objects({{"object", Left},
                     {"mesh, volume or shape", Left},
                     {"material", Left},
                     {"priority"},
                     {"visible", Left},
                     {"groups", Left}});
  for (const SceneObject& o : scene.objects) {
    const bool isVolume = !o.volumeFile.empty();
    const std::string what =
        o.shape.empty() ? (isVolume ? o.volumeFile : o.meshFile).string() : kShapeTypes[o.shape.node().kind.index()];
    objects.add({plain(o.name), plain(what, 80), isVolume ? gridsText(o) : plain(o.material),
                 fmt::format("{}", o.priority), o.visible ? "yes" : "no", groupsText(o)});
  }
  if (!scene.objects.empty()) fmt::print("{}", objects.text("  "));
  TextTable materials(
      {{"material", Left}, {"index"}, {"attenuation [1/world]"}, {"scattering [1/world]"}, {"asymmetry"}});
  for (const Material& m : scene.materials)
    materials.add({plain(m.name), fmt::format("{:g}", m.index), triple(m.attenuation), triple(m.scattering),
                   fmt::format("{:g}", m.asymmetry)});
  if (!scene.materials.empty()) fmt::print("{}", materials.text("  "));
}

void printLights(const std::vector<Light>& lights) {
  if (lights.empty()) return;
  TextTable table({{"light", Left}, {"type", Left}, {"direction or position", Left}, {"RGB"}, {"unit", Left}});
  for (const Light& l : lights) {
    const std::string name = plain(l.name), type = enumNames(l.type)[static_cast<std::size_t>(l.type)];
    if (l.type == LightType::Environment)
      table.add({name, type, "all", triple(l.scale), "background"});
    else if (l.type == LightType::Directional)
      table.add({name, type, triple(l.direction), triple(l.irradiance), "W/m2"});
    else
      table.add({name, type, triple(l.position), triple(l.intensity), "W/sr"});
  }
  fmt::print("{}", table.text("  "));
}

void printReceivers(const std::vector<SceneReceiver>& receivers) {
  if (receivers.empty()) return;
  TextTable table({{"receiver", Left}, {"mesh", Left}, {"at"}, {"albedo"}, {"map [texels]"}});
  for (const SceneReceiver& r : receivers)
    table.add({plain(r.name), r.meshFile.empty() ? "square" : plain(r.meshFile.string(), 80),
               triple(r.placement.translate), triple(r.albedo), fmt::format("{}", r.resolution)});
  fmt::print("{}", table.text("  "));
}

} // namespace

Json sceneInfo(const std::string& path, Job& job) {
  const Scene scene = readScene(path, {}, job.context());
  const std::string hash = sceneHash(scene);
  if (!job.json()) {
    fmt::print("{}: scene {}, {} objects, {} materials, {} lights\n", path, hash, scene.objects.size(),
               scene.materials.size(), scene.lights.size());
    printVolume(scene.volume);
    printObjects(scene);
    printLights(scene.lights);
    printReceivers(scene.receivers);
    fmt::print("  photons   {} x {} for each light, {}\n", scene.photons.grid[0], scene.photons.grid[1],
               enumNames(scene.photons.scheme)[static_cast<std::size_t>(scene.photons.scheme)]);
    fmt::print("  picture   {} x {} pixels, {:g} degrees high, {} rays a pixel\n", scene.camera.resolution[0],
               scene.camera.resolution[1], scene.camera.fieldOfView, scene.view.samples * scene.view.samples);
  }
  return {{"kind", "scene"}, {"sceneHash", hash}, {"scene", Json::parse(sceneToJson(scene))}};
}

} // namespace volcaustic::cli
