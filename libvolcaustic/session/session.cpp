#include "volcaustic/session.h"

#include "core/hash.h"
#include "scene/scene_meshes.h"
#include "transport/passes.h"
#include "volcaustic/error.h"
#include "volcaustic/options.h"
#include "volcaustic/vdb.h"
#include "volume/flatten.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>

namespace volcaustic {

namespace {

/// A visitor of describe() that turns options into a key.
class KeyVisitor {
public:
  explicit KeyVisitor(Hash& hash) : mHash(hash) {}
  template <class T>
  void operator()(const char* name, const T& value, const FieldDoc&) {
    mHash.text(name);
    add(value);
  }

private:
  template <class T>
  void add(const T& v) {
    mHash.value(v);
  }
  template <class T, std::size_t N>
  void add(const std::array<T, N>& v) {
    mHash.values(std::span<const T>(v));
  }
  void add(const std::string& v) { mHash.text(v); }

  Hash& mHash;
};

template <class Options>
void addOptions(Hash& hash, Options options) {
  describe(KeyVisitor(hash), options);
}

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

  const LoadedMesh& load(const SceneObject& object, SceneMeshReader& reader) {
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
    return !object.name.empty() ? object.name : object.meshFile.filename().string();
  }

  const Material& material(const std::string& name, const SceneObject& object) const {
    for (const Material& m : scene.materials)
      if (m.name == name) return m;
    throw Error(ErrorKind::Input, "objects (" + nameOf(object) + "): no material is called '" + name + "'");
  }

  std::vector<Body> bodiesOf(const SceneObject& o, SceneMeshReader& reader) {
    auto mesh = std::make_shared<const Mesh>(transformed(*load(o, reader).mesh, affine(o.placement)));
    std::vector<GroupMaterial> groups;
    for (const SceneGroup& g : o.groups) groups.push_back({g.name, material(g.material, o), o.priority + g.priority});
    return bodiesByGroup(std::move(mesh), material(o.material, o), o.priority, groups, nameOf(o), ctx);
  }

  [[nodiscard]] Hash mediumKey() {
    Hash h;
    h.text("medium 1");
    const SceneVolume& v = scene.volume;
    addOptions(h, v.ambient);
    if (!v.file.empty()) {
      std::error_code ignored;
      const auto time = std::filesystem::last_write_time(v.file, ignored).time_since_epoch().count();
      return h.text(v.file.string()).value(time);
    }
    h.value(v.automatic).value(v.margin).value(v.resolution).value(v.voxelSize);
    h.values(std::span<const double>(v.bounds.min)).values(std::span<const double>(v.bounds.max));
    addOptions(h, scene.voxelise);
    SceneMeshReader reader(ctx);
    for (const SceneObject& o : scene.objects) {
      if (!o.visible) continue;
      addOptions(h, o.placement);
      addOptions(h, material(o.material, o));
      h.value(o.priority).value(load(o, reader).key).value(o.groups.size());
      for (const SceneGroup& g : o.groups) {
        h.text(g.name).value(g.priority);
        addOptions(h, material(g.material, o));
      }
    }
    return h;
  }

  Medium buildScene() {
    if (!scene.volume.file.empty()) return readMedium(scene.volume.file, ctx);
    std::vector<Body> bodies;
    SceneMeshReader reader(ctx);
    for (const SceneObject& o : scene.objects) {
      if (!o.visible) continue;
      for (Body& body : bodiesOf(o, reader)) bodies.push_back(std::move(body));
    }
    return buildMedium(bodies, scene.volume.ambient, domainOf(bodies), scene.voxelise, ctx);
  }

  /// The medium made ready for the kernels; photons and view share it. `medium` must be current.
  const FlatMediumStorage& flattened() {
    Hash h;
    h.text("flatten 1").value(medium.key);
    addOptions(h, scene.stepField);
    return ensure(flat, "stepField", h, [&] { return flattenMedium(*medium.result, scene.stepField, ctx); });
  }

  /// The scene's box, or the bodies' enlarged by the margin.
  [[nodiscard]] Domain domainOf(const std::vector<Body>& bodies) const {
    const SceneVolume& v = scene.volume;
    Box box = v.bounds;
    if (v.automatic) {
      if (bodies.empty())
        throw Error(ErrorKind::Input, "volume.bounds: \"auto\" needs a visible object; give min and max");
      box = bounds(*bodies.front().mesh);
      for (const Body& b : bodies) {
        const Box other = bounds(*b.mesh);
        for (int a = 0; a < 3; ++a) {
          box.min[a] = std::min(box.min[a], other.min[a]);
          box.max[a] = std::max(box.max[a], other.max[a]);
        }
      }
      const double longest = std::max({box.max[0] - box.min[0], box.max[1] - box.min[1], box.max[2] - box.min[2]});
      for (int a = 0; a < 3; ++a) {
        box.min[a] -= v.margin * longest;
        box.max[a] += v.margin * longest;
      }
    }
    return domainAround(box, v.resolution, v.voxelSize, 0);
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
  addOptions(h, s.scene.photons);
  for (const Light& light : s.scene.lights) addOptions(h, light);
  return s.ensure(s.photons, "photons", h,
                  [&] { return tracePhotons(m, flat, s.scene.lights, s.scene.photons, s.ctx, s.tracers); });
}

const ViewResult& Session::view(const ViewObserver& observer) {
  State& s = *mState;
  const Medium& m = medium();
  const PhotonResult& light = photons();
  const FlatMediumStorage& flat = s.flattened();
  Hash h;
  h.text("view 2").value(s.photons.key).value(s.flat.key);
  addOptions(h, s.scene.camera);
  addOptions(h, s.scene.background);
  addOptions(h, s.scene.view);
  return s.ensure(s.view, "view", h, [&] {
    return renderView(m, flat, light.radiance, s.scene.camera, s.scene.background, s.scene.view, s.ctx, observer);
  });
}

void Session::setRadiance(RadianceVolume radiance) {
  State& s = *mState;
  s.foreignRadiance = true;
  s.photons.result = PhotonResult{std::move(radiance), {}, {}, 0};
  s.photons.key = Hash().text("foreign").value(++s.photons.key).digest();
}

} // namespace volcaustic
