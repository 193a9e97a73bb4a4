#include "volcaustic/session.h"

#include "core/field_hash.h"
#include "scene/scene_meshes.h"
#include "transport/passes.h"
#include "transport/picture.h"
#include "volcaustic/error.h"
#include "volcaustic/options.h"
#include "volcaustic/shape_fields.h"
#include "volcaustic/vdb.h"
#include "volume/flatten.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <utility>

namespace volcaustic {

namespace {

std::uint64_t meshKey(const Mesh& mesh) {
  Hash h;
  h.value(mesh.positions.size()).bytes(mesh.positions.data(), mesh.positions.size() * sizeof mesh.positions[0]);
  h.value(mesh.triangles.size()).bytes(mesh.triangles.data(), mesh.triangles.size() * sizeof mesh.triangles[0]);
  h.values(std::span<const std::uint32_t>(mesh.triangleGroup)).value(mesh.groupNames.size());
  for (const std::string& name : mesh.groupNames) h.text(name);
  return h.digest();
}

/// A stage's latest result and what it was made from.
template <class Result>
struct Stage {
  std::uint64_t key = 0;
  std::optional<Result> result;
};

} // namespace

struct Session::State {
  Scene scene;
  RunContext ctx;
  std::vector<StageRun> runs;
  Stage<Medium> medium;
  Stage<FlatMediumStorage> flat;
  Stage<PhotonResult> photons;
  Stage<ViewResult> view;
  std::shared_ptr<TracerState> tracers = std::make_shared<TracerState>();
  bool foreignRadiance = false; // photons.result came from setRadiance
  struct LoadedMesh {
    std::filesystem::file_time_type time;
    std::uint64_t key;
    std::shared_ptr<const Mesh> mesh;
  };
  std::map<std::filesystem::path, LoadedMesh> meshes; // as read, before placement
  struct Triangulation {
    Polygoniser polygoniser;
    std::uint64_t key = 0;
    std::shared_ptr<const Mesh> mesh; // in world space
  };
  std::map<std::size_t, Triangulation> triangulations; // by object: of a shape that moves little is made anew
  struct LoadedVolume {
    std::filesystem::file_time_type time;
    std::vector<std::string> names;
    std::shared_ptr<const VolumeGrids> grids;
  };
  std::map<std::filesystem::path, LoadedVolume> volumes; // of this scene alone: they are large

  Background background; // of the last call of Session::background()
  std::filesystem::file_time_type backgroundTime;

  /// Runs `run` when the stage's key has changed, and books the time.
  template <class Result, class Run>
  const Result& ensure(Stage<Result>& stage, const char* name, const Hash& hash, const Run& run) {
    const std::uint64_t key = hash.digest();
    if (stage.result && stage.key == key) return *stage.result;
    stage.result.reset(); // frees the old volume before the new one is made
    const auto start = std::chrono::steady_clock::now();
    stage.result.emplace(run());
    stage.key = key;
    const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
    runs.push_back({name, hash.hex(), ms.count()});
    return *stage.result;
  }

  /// The mesh of an object or a receiver.
  template <class Holder>
  const LoadedMesh& load(const Holder& object, SceneMeshReader& reader) {
    if (object.mesh) {
      // A mesh in memory may change behind its pointer, so it is hashed afresh.
      LoadedMesh& entry = meshes["memory:" + std::to_string(reinterpret_cast<std::uintptr_t>(object.mesh.get()))];
      entry = {{}, meshKey(*object.mesh), object.mesh};
      return entry;
    }
    std::error_code ignored;
    const auto time = std::filesystem::last_write_time(sceneMeshFile(object.meshFile), ignored);
    LoadedMesh& entry = meshes[object.meshFile];
    if (!entry.mesh || entry.time != time) {
      auto mesh = std::make_shared<const Mesh>(reader.read(object.meshFile));
      const std::uint64_t key = meshKey(*mesh);
      entry = {time, key, std::move(mesh)};
    }
    return entry;
  }

  static std::string nameOf(const SceneObject& object) {
    if (!object.name.empty()) return object.name;
    if (!object.shape.empty())
      return !object.shape.node().name.empty() ? object.shape.node().name
                                               : kShapeTypes[object.shape.node().kind.index()];
    return (object.volumeFile.empty() ? object.meshFile : object.volumeFile).filename().string();
  }

  const Material& material(const std::string& name, const SceneObject& object) const {
    for (const Material& m : scene.materials)
      if (m.name == name) return m;
    throw Error(ErrorKind::Input, "objects (" + nameOf(object) + "): no material is called '" + name + "'");
  }

  /// The triangles of a shape that is an object, as the latest ones where that is what they are of.
  std::shared_ptr<const Mesh> triangulated(const SceneObject& o, const Shape& placed) {
    Triangulation& latest = triangulations[static_cast<std::size_t>(&o - scene.objects.data())];
    Hash h;
    h.value(shapeHash(placed));
    addFields(h, o.polygonise);
    if (!latest.mesh || latest.key != h.digest()) {
      latest.mesh = std::make_shared<const Mesh>(latest.polygoniser.polygonise(placed, o.polygonise, ctx));
      latest.key = h.digest();
    }
    return latest.mesh;
  }

  Body bodyOf(const SceneObject& o) {
    Body body{nullptr, material(o.material, o), o.priority, nameOf(o)};
    try {
      const Shape placed = o.shape.placed(o.placement);
      if (o.triangulate)
        body.mesh = triangulated(o, placed);
      else
        body.shape = placed;
    } catch (const Error& error) { // which knows no object
      if (error.kind() != ErrorKind::Input) throw;
      throw Error(ErrorKind::Input, "objects (" + body.name + "): " + error.what());
    }
    return body;
  }

  std::vector<Body> bodiesOf(const SceneObject& o, SceneMeshReader& reader) {
    if (!o.shape.empty()) return {bodyOf(o)};
    auto mesh = std::make_shared<const Mesh>(transformed(*load(o, reader).mesh, affine(o.placement)));
    std::vector<GroupMaterial> groups;
    for (const SceneGroup& g : o.groups) groups.push_back({g.name, material(g.material, o), o.priority + g.priority});
    return bodiesByGroup(std::move(mesh), material(o.material, o), o.priority, groups, nameOf(o), ctx);
  }

  std::vector<Receiver> receivers() {
    std::vector<Receiver> all;
    SceneMeshReader reader(ctx);
    for (const SceneReceiver& r : scene.receivers) {
      const std::string name = !r.name.empty() ? r.name : "receiver" + std::to_string(all.size());
      const bool square = !r.mesh && r.meshFile.empty();
      all.push_back(
          {name, square ? nullptr : load(r, reader).mesh, affine(r.placement), r.albedo, r.resolution, r.visible});
    }
    return all;
  }

  void addReceivers(Hash& hash) {
    SceneMeshReader reader(ctx);
    for (const SceneReceiver& r : scene.receivers) {
      addFields(hash, r);
      if (r.mesh || !r.meshFile.empty()) hash.value(load(r, reader).key);
    }
  }

  static std::filesystem::file_time_type timeOf(const std::filesystem::path& file) {
    std::error_code ignored;
    return std::filesystem::last_write_time(file, ignored);
  }

  /// The scene's volumes; files that did not change are not read again.
  std::vector<MediumVolume> mediumVolumes() {
    std::map<std::filesystem::path, LoadedVolume> before = std::exchange(volumes, {});
    for (const SceneObject& o : scene.objects)
      if (o.visible && !o.volumeFile.empty())
        for (const PropertyGrid& p : o.grids) volumes[o.volumeFile].names.push_back(p.mapping.grid);
    for (auto& [file, loaded] : volumes) {
      loaded.time = timeOf(file);
      const auto old = before.find(file);
      if (old != before.end() && old->second.time == loaded.time && old->second.names == loaded.names)
        loaded.grids = std::move(old->second.grids);
    }
    before.clear(); // before the new ones take memory
    for (auto& [file, loaded] : volumes)
      if (!loaded.grids) loaded.grids = readVolumeGrids(file, loaded.names, ctx);

    std::vector<MediumVolume> placed;
    for (const SceneObject& o : scene.objects)
      if (o.visible && !o.volumeFile.empty())
        placed.push_back({volumes[o.volumeFile].grids, o.grids, affine(o.placement), "objects (" + nameOf(o) + ")"});
    return placed;
  }

  [[nodiscard]] Hash mediumKey() {
    Hash h;
    h.text("medium 2");
    const SceneVolume& v = scene.volume;
    addFields(h, v.ambient);
    if (!v.file.empty()) {
      std::error_code ignored;
      const auto time = std::filesystem::last_write_time(v.file, ignored).time_since_epoch().count();
      return h.text(v.file.string()).value(time);
    }
    h.value(v.automatic).value(v.margin).value(v.resolution).value(v.voxelSize);
    h.values(std::span<const double>(v.bounds.min)).values(std::span<const double>(v.bounds.max));
    addFields(h, scene.voxelise);
    SceneMeshReader reader(ctx);
    for (const SceneObject& o : scene.objects) {
      if (!o.visible) continue;
      addFields(h, o.placement);
      h.text(o.volumeFile.string());
      if (!o.volumeFile.empty()) {
        h.value(timeOf(o.volumeFile).time_since_epoch().count()).value(o.grids.size());
        for (const PropertyGrid& p : o.grids) addFields(h, p);
        continue;
      }
      addFields(h, material(o.material, o));
      h.value(o.priority).value(shapeHash(o.shape)).value(o.triangulate);
      if (!o.shape.empty()) {
        if (o.triangulate) addFields(h, o.polygonise);
        continue;
      }
      h.value(load(o, reader).key).value(o.groups.size());
      for (const SceneGroup& g : o.groups) {
        h.text(g.name).value(g.priority);
        addFields(h, material(g.material, o));
      }
    }
    return h;
  }

  Medium buildScene() {
    if (!scene.volume.file.empty()) return readMedium(scene.volume.file, ctx);
    std::vector<Body> bodies;
    SceneMeshReader reader(ctx);
    for (const SceneObject& o : scene.objects) {
      if (!o.visible || !o.volumeFile.empty()) continue;
      for (Body& body : bodiesOf(o, reader)) bodies.push_back(std::move(body));
    }
    const std::vector<MediumVolume> placed = mediumVolumes();
    return buildMedium(bodies, placed, scene.volume.ambient, domainOf(bodies, placed), scene.voxelise, ctx);
  }

  /// The medium made ready for the kernels; photons and view share it. `medium` must be current.
  const FlatMediumStorage& flattened() {
    Hash h;
    h.text("flatten 1").value(medium.key);
    addFields(h, scene.stepField);
    return ensure(flat, "stepField", h, [&] { return flattenMedium(*medium.result, scene.stepField, ctx); });
  }

  void addBackground(Hash& hash, Background b) const {
    addFields(hash, b);
    if (scene.background.image)
      for (const std::vector<float>& plane : b.image->planes) hash.values(std::span<const float>(plane));
    else if (b.image)
      hash.value(backgroundTime.time_since_epoch().count());
  }

  void addLight(Hash& hash, Light light) const {
    addFields(hash, light);
    if (light.type != LightType::Environment) return;
    light.environment.visible = true; // to the camera, of which light knows nothing
    addBackground(hash, light.environment);
  }

  static Box boundsOf(const Body& body) {
    try {
      return ShapeField(body.shape).bounds();
    } catch (const Error& error) { // which knows no object
      throw Error(error.kind(), "objects (" + body.name + "): " + error.what());
    }
  }

  /// The scene's box, or that of bodies and volumes enlarged by the margin.
  [[nodiscard]] Domain domainOf(const std::vector<Body>& bodies, const std::vector<MediumVolume>& placed) const {
    const SceneVolume& volume = scene.volume;
    Box box = volume.bounds;
    if (volume.automatic) {
      std::vector<Box> boxes;
      for (const Body& b : bodies) {
        const Box around = b.mesh ? bounds(*b.mesh) : boundsOf(b);
        if (around.min != around.max) boxes.push_back(around); // a shape may have no inside
      }
      for (const MediumVolume& v : placed)
        if (const auto around = bounds(*v.grids, v.placement)) boxes.push_back(*around);
      if (boxes.empty())
        throw Error(ErrorKind::Input,
                    "volume.bounds: \"auto\" needs a visible object that is not empty; give min and max");
      box = boxes.front();
      for (const Box& other : boxes) {
        for (int a = 0; a < 3; ++a) {
          box.min[a] = std::min(box.min[a], other.min[a]);
          box.max[a] = std::max(box.max[a], other.max[a]);
        }
      }
      const double longest = std::max({box.max[0] - box.min[0], box.max[1] - box.min[1], box.max[2] - box.min[2]});
      for (int a = 0; a < 3; ++a) {
        box.min[a] -= volume.margin * longest;
        box.max[a] += volume.margin * longest;
      }
    }
    return domainAround(box, volume.resolution, volume.voxelSize, 0);
  }
};

Session::Session(Scene scene, RunContext ctx) : mState(std::make_unique<State>()) {
  mState->scene = std::move(scene);
  mState->ctx = std::move(ctx);
}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

const Scene& Session::scene() const { return mState->scene; }
void Session::setScene(Scene scene) { mState->scene = std::move(scene); }
const std::vector<StageRun>& Session::runs() const { return mState->runs; }

const Medium& Session::medium() {
  State& s = *mState;
  return s.ensure(s.medium, "medium", s.mediumKey(), [&] { return s.buildScene(); });
}

const PhotonResult& Session::photons() {
  State& s = *mState;
  if (s.foreignRadiance) return *s.photons.result;
  const Medium& m = medium();
  const FlatMediumStorage& flat = s.flattened();
  Hash h;
  h.text("photons 1").value(s.flat.key).value(s.ctx.seed);
  addFields(h, s.scene.photons);
  std::vector<Light> lights = s.scene.lights;
  for (Light& light : lights)
    if (light.type == LightType::Environment) light.environment = background();
  for (const Light& light : lights) s.addLight(h, light);
  s.addReceivers(h);
  return s.ensure(s.photons, "photons", h,
                  [&] { return tracePhotons(m, flat, lights, s.receivers(), s.scene.photons, s.ctx, s.tracers); });
}

const ViewResult& Session::view(const ViewObserver& observer) {
  State& s = *mState;
  const Medium& m = medium();
  const PhotonResult& light = photons();
  const FlatMediumStorage& flat = s.flattened();
  Hash h;
  h.text("view 2").value(s.photons.key).value(s.flat.key);
  addFields(h, s.scene.camera);
  const Background& behind = background();
  s.addBackground(h, behind);
  addFields(h, s.scene.view);
  return s.ensure(s.view, "view", h,
                  [&] { return renderView(m, flat, light, s.scene.camera, behind, s.scene.view, s.ctx, observer); });
}

const Background& Session::background() {
  Background& b = mState->background;
  const std::filesystem::path fileBefore = std::exchange(b.file, {});
  const std::shared_ptr<const Image> imageBefore = std::exchange(b.image, nullptr);
  b = mState->scene.background;
  if (b.image || b.file.empty()) return b;
  const auto time = State::timeOf(b.file);
  const bool known = imageBefore && fileBefore == b.file && mState->backgroundTime == time;
  b.image = known ? imageBefore : readEnvironment(b.file, mState->ctx);
  mState->backgroundTime = time;
  return b;
}

std::vector<std::string> Session::viewChannels() const {
  const Scene& s = scene();
  const bool separate = s.photons.separate && !mState->foreignRadiance;
  return pictureChannels(separate ? lightLayers(s.lights) : std::vector<std::string>{});
}

void Session::setRadiance(RadianceVolume radiance) {
  State& s = *mState;
  s.foreignRadiance = true;
  s.photons.result = PhotonResult{std::move(radiance), {}, {}, {}, 0};
  s.photons.key = Hash().text("foreign").value(++s.photons.key).digest();
}

} // namespace volcaustic
