// info: what is in a volume, an image, a mesh or a scene.
#include "common.h"
#include "file_kind.h"

#include <volcaustic/image.h>
#include <volcaustic/mesh.h>
#include <volcaustic/scene.h>
#include <volcaustic/vdb.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

std::string vec(const Vec3d& v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v[0], v[1], v[2]); }
Json boxReport(const Box& box) { return {{"min", box.min}, {"max", box.max}}; }

void printMetadata(const std::map<std::string, std::string>& metadata, const char* indent) {
  for (const auto& [key, value] : metadata) fmt::print("{}{} = {}\n", indent, key, value);
}

Json gridReport(const GridInfo& g) {
  return {{"name", g.name},
          {"type", g.type},
          {"class", g.gridClass},
          {"vectorType", g.vectorType},
          {"activeVoxels", g.activeVoxels},
          {"leafNodes", g.leafNodes},
          {"activeTiles", g.activeTiles},
          {"memoryBytes", g.memoryBytes},
          {"indexMin", g.indexMin},
          {"indexMax", g.indexMax},
          {"world", boxReport(g.world)},
          {"voxelSize", g.voxelSize},
          {"minimum", g.minimum},
          {"maximum", g.maximum},
          {"mean", g.mean},
          {"metadata", g.metadata}};
}

Json volumeInfo(const std::string& path, Job& job) {
  const VdbInfo info = inspectVdb(path, job.context());
  Json grids = Json::array();
  for (const GridInfo& grid : info.grids) grids.push_back(gridReport(grid));
  if (!job.json()) {
    fmt::print("{}: volume, {} grids\n", path, info.grids.size());
    printMetadata(info.metadata, "  ");
    fmt::print("  {:<14} {:<8} {:<20} {:>12} {:>9} {:>13} {:>13} {:>13}\n", "grid", "type", "class", "active voxels",
               "MiB", "minimum", "maximum", "mean");
    for (const GridInfo& g : info.grids) {
      fmt::print("  {:<14} {:<8} {:<20} {:>12} {:>9.2f} {:>13.6g} {:>13.6g} {:>13.6g}\n", g.name, g.type, g.gridClass,
                 g.activeVoxels, static_cast<double>(g.memoryBytes) / (1 << 20), g.minimum, g.maximum, g.mean);
      fmt::print("      world {} to {}, voxel {}\n", vec(g.world.min), vec(g.world.max), vec(g.voxelSize));
      if (job.console().isVerbose()) printMetadata(g.metadata, "      ");
    }
  }
  return {{"kind", "volume"}, {"grids", std::move(grids)}, {"metadata", info.metadata}};
}

/// Least, greatest and mean finite value, and how many are not finite.
Json planeReport(const std::vector<float>& plane) {
  double least = INFINITY, greatest = -INFINITY, sum = 0;
  std::uint64_t finite = 0;
  for (const float value : plane) {
    if (!std::isfinite(value)) continue;
    least = std::min<double>(least, value);
    greatest = std::max<double>(greatest, value);
    sum += value;
    ++finite;
  }
  if (finite == 0) return {{"minimum", nullptr}, {"maximum", nullptr}, {"mean", nullptr}, {"notFinite", plane.size()}};
  return {{"minimum", least},
          {"maximum", greatest},
          {"mean", sum / static_cast<double>(finite)},
          {"notFinite", plane.size() - finite}};
}

Json imageInfo(const std::string& path, Job& job) {
  const Image image = readImage(path, job.context());
  Json channels = Json::array();
  for (std::size_t i = 0; i < image.channels.size(); ++i) {
    Json channel{{"name", image.channels[i]}};
    channel.update(planeReport(image.planes[i]));
    channels.push_back(std::move(channel));
  }
  if (!job.json()) {
    fmt::print("{}: image, {} x {} pixels, {} channels\n", path, image.width, image.height, image.channels.size());
    printMetadata(image.metadata, "  ");
    fmt::print("  {:<20} {:>13} {:>13} {:>13} {:>10}\n", "channel", "minimum", "maximum", "mean", "not finite");
    const auto number = [](const Json& v) {
      return v.is_null() ? std::string("-") : fmt::format("{:.6g}", v.get<double>());
    };
    for (const Json& c : channels)
      fmt::print("  {:<20} {:>13} {:>13} {:>13} {:>10}\n", c["name"].get<std::string>(), number(c["minimum"]),
                 number(c["maximum"]), number(c["mean"]), c["notFinite"].get<std::uint64_t>());
  }
  return {{"kind", "image"},
          {"width", image.width},
          {"height", image.height},
          {"channels", std::move(channels)},
          {"metadata", image.metadata}};
}

Json meshInfo(const std::string& path, Job& job) {
  const MeshReport r = checkMesh(readMesh(path, job.context()), job.context());
  if (!job.json()) {
    fmt::print("{}: mesh, {} vertices, {} triangles, {} components, {}\n", path, r.vertices, r.triangles, r.components,
               r.closedAndConsistent() ? "closed" : "not closed");
    fmt::print("  bounds {} to {}\n  signed volume {:.8g}, area {:.8g}\n", vec(r.bounds.min), vec(r.bounds.max),
               r.signedVolume, r.area);
    fmt::print("  edges: {} open, {} non-manifold, {} inconsistent; faces: {} duplicate, {} degenerate\n", r.openEdges,
               r.nonManifoldEdges, r.inconsistentEdges, r.duplicateFaces, r.degenerateFaces);
  }
  return {{"kind", "mesh"},
          {"vertices", r.vertices},
          {"triangles", r.triangles},
          {"components", r.components},
          {"closed", r.closedAndConsistent()},
          {"openEdges", r.openEdges},
          {"nonManifoldEdges", r.nonManifoldEdges},
          {"inconsistentEdges", r.inconsistentEdges},
          {"duplicateFaces", r.duplicateFaces},
          {"degenerateFaces", r.degenerateFaces},
          {"signedVolume", r.signedVolume},
          {"area", r.area},
          {"bounds", boxReport(r.bounds)}};
}

Json sceneInfo(const std::string& path, Job& job) {
  const Scene scene = readScene(path);
  const std::string hash = sceneHash(scene);
  if (!job.json()) {
    fmt::print("{}: scene {}\n", path, hash);
    for (const SceneObject& o : scene.objects)
      fmt::print("  object {}: {}, {}{}\n", o.name, o.meshFile.string(), o.material, o.visible ? "" : ", hidden");
    for (const Material& m : scene.materials) fmt::print("  material {}: index {:g}\n", m.name, m.index);
    for (const Light& l : scene.lights)
      fmt::print("  light {}: {}\n", l.name, l.type == LightType::Directional ? "directional" : "point");
    fmt::print("  photons {} x {} for each light, picture {} x {}\n", scene.photons.grid[0], scene.photons.grid[1],
               scene.camera.resolution[0], scene.camera.resolution[1]);
  }
  return {{"kind", "scene"}, {"sceneHash", hash}, {"scene", Json::parse(sceneToJson(scene))}};
}

struct Info {
  CommonOptions common;
  std::vector<std::string> files;
};

void declareInfo(CLI::App& command, Info& o) {
  command.add_option("FILE", o.files, "volumes, images, meshes or scenes")->required();
}

int runInfo(const Info& o) {
  Job job("info", o.common);
  for (const std::string& file : o.files) {
    job.addInput(file);
    Json entry{{"file", file}};
    switch (fileKind(file)) {
    case FileKind::Volume:
      entry.update(volumeInfo(file, job));
      break;
    case FileKind::Image:
      entry.update(imageInfo(file, job));
      break;
    case FileKind::Mesh:
      entry.update(meshInfo(file, job));
      break;
    case FileKind::Scene:
      entry.update(sceneInfo(file, job));
      break;
    }
    job.report()["files"].push_back(std::move(entry));
  }
  job.finish();
  return 0;
}

} // namespace

void addInfoCommand(CLI::App& app, Action& action) {
  addCommand<Info>(app, action, "info", "what is in volumes, images, meshes and scenes", declareInfo, runInfo);
}

} // namespace volcaustic::cli
