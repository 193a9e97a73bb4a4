#include "volcaustic/session.h"

#include "core/xxhash64.h"
#include "session/result_files.h"
#include "session/scene_medium.h"
#include "session/stage.h"
#include "session/surfaces.h"
#include "transport/passes.h"
#include "transport/picture.h"
#include "volcaustic/error.h"
#include "volcaustic/shape_fields.h"
#include "volcaustic/vdb.h"
#include "volume/flatten.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace volcaustic {

namespace {

using Clock = std::chrono::steady_clock;

/// Of stages whose results are not kept in files.
struct NoFiles {
  bool has(const StageKey&) const { return false; }
  std::nullptr_t read(const StageKey&) const { return nullptr; }
  template <class Result>
  void write(const StageKey&, const Result&) const {}
};

std::uint64_t imageKey(const Image& image) {
  XxHash64 hash;
  hash.add(&image.width, sizeof image.width);
  hash.add(&image.height, sizeof image.height);
  for (const std::string& name : image.channels) hash.add(name.c_str(), name.size() + 1);
  for (const std::vector<float>& plane : image.planes) hash.add(plane.data(), plane.size() * sizeof(float));
  return hash.digest();
}

} // namespace

struct Session::State {
  explicit State(SessionOptions o) : options(std::move(o)), files(!options.cache.empty()) {}

  Scene scene;
  RunContext ctx;
  SessionOptions options;
  std::vector<StageRun> runs;
  SceneFiles files;
  Surfaces surfaces;
  Stage<Medium> mediumStage;
  Stage<FlatMediumStorage> flatStage;
  Stage<PhotonResult> photonStage;
  Stage<ViewResult> viewStage;
  std::shared_ptr<TracerState> tracers = std::make_shared<TracerState>();
  std::shared_ptr<const PhotonResult> foreignPhotons; // of setRadiance
  std::uint64_t foreignCount = 0;

  void book(const std::string& name, const StageKey& key, std::vector<std::string> because, Clock::time_point start,
            bool fromDisk) {
    const std::chrono::duration<double, std::milli> ms = Clock::now() - start;
    runs.push_back({name, key.hex(), ms.count(), std::move(because), fromDisk});
  }

  /// The result of the key where it is there, in memory or on the disk; else null.
  template <class Result, class Files = NoFiles>
  std::shared_ptr<const Result> recall(Stage<Result>& stage, const std::string& name, const StageKey& key,
                                       const Files& stored = {}) {
    if (auto known = stage.find(key)) {
      stage.ask(key);
      return known;
    }
    if (!stored.has(key)) return nullptr;
    if (options.results <= 1) stage.makeRoom(1); // frees the old volume before the new one takes memory
    const auto start = Clock::now();
    std::shared_ptr<const Result> read = stored.read(key);
    if (!read) return nullptr;
    book(name, key, stage.because(key), start, true);
    return keep(stage, key, std::move(read));
  }

  /// Runs `make`, books the time and keeps the result.
  template <class Result, class Make, class Files = NoFiles>
  std::shared_ptr<const Result> run(Stage<Result>& stage, const std::string& name, const StageKey& key,
                                    const Make& make, const Files& stored = {}) {
    if (options.results <= 1) stage.makeRoom(1);
    const auto start = Clock::now();
    auto result = std::make_shared<const Result>(make());
    book(name, key, stage.because(key), start, false);
    result = keep(stage, key, std::move(result));
    stored.write(key, *result);
    return result;
  }

  template <class Result>
  std::shared_ptr<const Result> keep(Stage<Result>& stage, const StageKey& key, std::shared_ptr<const Result> result) {
    stage.makeRoom(static_cast<std::size_t>(std::max(options.results, 1)));
    stage.ask(key);
    return stage.keep(key, std::move(result));
  }

  template <class Result, class Make>
  std::shared_ptr<const Result> ensure(Stage<Result>& stage, const std::string& name, const StageKey& key,
                                       const Make& make) {
    if (auto known = recall(stage, name, key)) return known;
    return run(stage, name, key, make);
  }

  // Keys. Each is a function of the scene and its files; none runs a stage.

  static std::string place(const char* list, std::size_t i) { return list + std::string("/") + std::to_string(i); }

  void addObject(StageKey& key, std::size_t i, SceneMeshReader& reader) {
    const SceneObject& o = scene.objects[i];
    const std::string here = place("objects", i);
    key.addFields(here, o.placement);
    if (!o.volumeFile.empty()) {
      key.add(here + "/volume", files.fileKey(o.volumeFile, ctx));
      for (std::size_t g = 0; g < o.grids.size(); ++g) key.addFields(here + "/" + place("grids", g), o.grids[g]);
      return;
    }
    key.addFields(here + "/material", materialOf(scene, o.material, o));
    key.add(here + "/priority", Hash().value(o.priority));
    if (hasSurfaceStage(o))
      key.add(here + "/surface", Surfaces::key(o, files, reader));
    else if (!o.shape.empty())
      key.add(here + "/shape", shapeHash(o.shape));
    else
      key.add(here + "/mesh", files.mesh(o, reader).key);
    for (std::size_t g = 0; g < o.groups.size(); ++g) {
      const std::string group = here + "/" + place("groups", g);
      key.add(group, Hash().text(o.groups[g].name).value(o.groups[g].priority));
      key.addFields(group + "/material", materialOf(scene, o.groups[g].material, o));
    }
  }

  StageKey mediumKey() {
    StageKey key("medium 3");
    const SceneVolume& v = scene.volume;
    key.addFields("volume", v.ambient);
    if (!v.file.empty()) {
      key.add("volume/file", files.fileKey(v.file, ctx));
      return key;
    }
    Hash bounds;
    bounds.value(v.automatic).value(v.automatic ? v.margin : 0);
    if (!v.automatic)
      bounds.values(std::span<const double>(v.bounds.min)).values(std::span<const double>(v.bounds.max));
    key.add("volume/bounds", bounds);
    key.add("volume/resolution", Hash().value(v.voxelSize > 0 ? 0 : v.resolution).value(v.voxelSize));
    key.addFields("voxelise", scene.voxelise);
    SceneMeshReader reader(ctx);
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
      if (scene.objects[i].visible) addObject(key, i, reader);
    return key;
  }

  StageKey flatKey(const StageKey& medium) const {
    StageKey key("stepField 2");
    key.add("medium", medium);
    key.addFields("stepField", scene.stepField);
    return key;
  }

  void addBackground(StageKey& key, const std::string& here, Background b) {
    key.addFields(here, b);
    if (scene.background.image)
      key.add(here + "/image", imageKey(*b.image));
    else if (b.image)
      key.add(here + "/file", files.fileKey(b.file, ctx));
  }

  StageKey photonKey(const StageKey& flat) {
    StageKey key("photons 2");
    if (foreignPhotons) {
      key.add("radiance", foreignCount);
      return key;
    }
    key.add("stepField", flat);
    key.add("seed", ctx.seed);
    key.add("device", Hash().text(ctx.device));
    key.addFields("photons", scene.photons);
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
      key.addFields(place("lights", i), scene.lights[i]);
      if (scene.lights[i].type != LightType::Environment) continue;
      Background shining = files.background(scene, ctx);
      shining.visible = true; // to the camera, of which light knows nothing
      addBackground(key, place("lights", i) + "/background", shining);
    }
    SceneMeshReader reader(ctx);
    for (std::size_t i = 0; i < scene.receivers.size(); ++i) {
      const SceneReceiver& r = scene.receivers[i];
      key.addFields(place("receivers", i), r);
      if (r.mesh || !r.meshFile.empty()) key.add(place("receivers", i) + "/mesh", files.mesh(r, reader).key);
    }
    return key;
  }

  StageKey viewKey(const StageKey& photons, const StageKey& flat) {
    StageKey key("view 3");
    key.add("photons", photons);
    key.add("stepField", flat);
    key.add("seed", ctx.seed);
    key.add("device", Hash().text(ctx.device));
    key.addFields("camera", scene.camera);
    addBackground(key, "background", files.background(scene, ctx));
    key.addFields("view", scene.view);
    return key;
  }

  // Stages.

  Surface surface(std::size_t i, SceneMeshReader& reader) {
    const SceneObject& o = scene.objects[i];
    return *ensure(surfaces.stage(i), "surface", Surfaces::key(o, files, reader),
                   [&] { return surfaces.make(i, o, files, reader, ctx); });
  }

  std::vector<Body> bodies() {
    std::vector<Body> all;
    SceneMeshReader reader(ctx);
    surfaces.resize(scene.objects.size());
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      const SceneObject& o = scene.objects[i];
      if (!o.visible || !o.volumeFile.empty()) continue;
      if (!o.shape.empty() && !hasSurfaceStage(o)) {
        all.push_back(shapeBody(scene, o));
        continue;
      }
      const Surface made = hasSurfaceStage(o) ? surface(i, reader) : Surface{files.mesh(o, reader).mesh, false};
      for (Body& body : meshBodies(scene, o, placedMesh(made, o), ctx)) all.push_back(std::move(body));
    }
    return all;
  }

  Medium makeMedium(const std::vector<Body>& bodies) {
    if (!scene.volume.file.empty()) return readMedium(scene.volume.file, ctx);
    const std::vector<MediumVolume> volumes = files.volumes(scene, ctx);
    return buildMedium(bodies, volumes, scene.volume.ambient, domainOf(scene.volume, bodies, volumes), scene.voxelise,
                       ctx);
  }

  std::shared_ptr<const Medium> medium(const StageKey& key) {
    // Surfaces are stages of their own: they run, and are booked, before the medium.
    std::vector<Body> made;
    if (!mediumStage.has(key) && scene.volume.file.empty()) made = bodies();
    return ensure(mediumStage, "medium", key, [&] { return makeMedium(made); });
  }

  /// The medium made ready for the kernels; photons and view share it.
  std::shared_ptr<const FlatMediumStorage> flat(const StageKey& key, const Medium& medium) {
    return ensure(flatStage, "stepField", key, [&] { return flattenMedium(medium, scene.stepField, ctx); });
  }

  std::vector<Receiver> receivers() {
    std::vector<Receiver> all;
    SceneMeshReader reader(ctx);
    for (const SceneReceiver& r : scene.receivers) {
      const std::string name = !r.name.empty() ? r.name : "receiver" + std::to_string(all.size());
      const bool square = !r.mesh && r.meshFile.empty();
      all.push_back({name, square ? nullptr : files.mesh(r, reader).mesh, affine(r.placement), r.albedo, r.resolution,
                     r.visible});
    }
    return all;
  }

  /// Keys of the stages that a picture needs, each made of those before it.
  struct Keys {
    explicit Keys(State& s)
        : medium(s.mediumKey()), flat(s.flatKey(medium)), photons(s.photonKey(flat)), view(s.viewKey(photons, flat)) {}
    StageKey medium, flat, photons, view;
  };

  std::shared_ptr<const PhotonResult> photons(const StageKey& mediumKey, const StageKey& flatKey, const StageKey& key) {
    if (foreignPhotons) return foreignPhotons;
    const PhotonFiles stored(options.cache, ctx, [this] { return receivers(); });
    if (auto known = recall(photonStage, "photons", key, stored)) return known;
    const auto m = medium(mediumKey);
    const auto f = flat(flatKey, *m);
    std::vector<Light> lights = scene.lights;
    for (Light& light : lights)
      if (light.type == LightType::Environment) light.environment = files.background(scene, ctx);
    return run(
        photonStage, "photons", key,
        [&] { return tracePhotons(*m, *f, lights, receivers(), scene.photons, ctx, tracers); }, stored);
  }

  /// Light from elsewhere is counted, not hashed, and means nothing to another session.
  [[nodiscard]] ViewFiles viewFiles() const { return {foreignPhotons ? std::filesystem::path() : options.cache, ctx}; }

  std::shared_ptr<const ViewResult> view(const Keys& keys, const ViewObserver& observer) {
    const ViewFiles stored = viewFiles();
    if (auto known = recall(viewStage, "view", keys.view, stored)) return known;
    const auto light = photons(keys.medium, keys.flat, keys.photons);
    const auto m = medium(keys.medium);
    const auto f = flat(keys.flat, *m);
    const Background& behind = files.background(scene, ctx);
    return run(
        viewStage, "view", keys.view,
        [&] { return renderView(*m, *f, *light, scene.camera, behind, scene.view, ctx, observer); }, stored);
  }
};

Session::Session(Scene scene, RunContext ctx, SessionOptions options)
    : mState(std::make_unique<State>(std::move(options))) {
  mState->scene = std::move(scene);
  mState->ctx = std::move(ctx);
}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

const Scene& Session::scene() const { return mState->scene; }
void Session::setScene(Scene scene) {
  mState->scene = std::move(scene);
  mState->files.keepOnly(mState->scene);
}
const RunContext& Session::context() const { return mState->ctx; }
void Session::setContext(RunContext ctx) {
  if (ctx.device != mState->ctx.device) mState->tracers = std::make_shared<TracerState>();
  mState->ctx = std::move(ctx);
}
const std::vector<StageRun>& Session::runs() const { return mState->runs; }

const Medium& Session::medium() { return *sharedMedium(); }
const PhotonResult& Session::photons() { return *sharedPhotons(); }
const ViewResult& Session::view(const ViewObserver& observer) { return *sharedView(observer); }

std::shared_ptr<const Medium> Session::sharedMedium() { return mState->medium(mState->mediumKey()); }

std::shared_ptr<const FlatMediumStorage> Session::sharedFlat() {
  State& s = *mState;
  const StageKey medium = s.mediumKey();
  return s.flat(s.flatKey(medium), *s.medium(medium));
}

std::shared_ptr<const PhotonResult> Session::sharedPhotons() {
  State& s = *mState;
  const StageKey medium = s.mediumKey(), flat = s.flatKey(medium);
  return s.photons(medium, flat, s.photonKey(flat));
}

std::shared_ptr<const ViewResult> Session::sharedView(const ViewObserver& observer) {
  return mState->view(State::Keys(*mState), observer);
}

std::shared_ptr<const Mesh> Session::surface(std::size_t i) {
  State& s = *mState;
  const std::string here = "objects/" + std::to_string(i);
  if (i >= s.scene.objects.size()) throw Error(ErrorKind::Usage, here + ": there is no such object");
  const SceneObject& o = s.scene.objects[i];
  if (!o.volumeFile.empty())
    throw Error(ErrorKind::Usage, here + " (" + nameOf(o) + "): is a volume and has no surface");
  SceneMeshReader reader(s.ctx);
  if (o.shape.empty() && !hasSurfaceStage(o)) return placedMesh({s.files.mesh(o, reader).mesh, false}, o);
  return placedMesh(s.surface(i, reader), o);
}

std::optional<Box> Session::contentBox() {
  State& s = *mState;
  return boxAround(s.bodies(), s.files.volumes(s.scene, s.ctx));
}

const Background& Session::background() { return mState->files.background(mState->scene, mState->ctx); }

std::vector<std::string> Session::viewChannels() const {
  const Scene& s = scene();
  const bool separate = s.photons.separate && !mState->foreignPhotons;
  return pictureChannels(separate ? lightLayers(s.lights) : std::vector<std::string>{});
}

void Session::setRadiance(RadianceVolume radiance) {
  State& s = *mState;
  s.foreignPhotons = std::make_shared<const PhotonResult>(PhotonResult{std::move(radiance), {}, {}, {}, 0});
  ++s.foreignCount;
}

std::vector<StagePlan> Session::plan() {
  State& s = *mState;
  const State::Keys keys(s);
  // A result that is there, in memory or on the disk, spares all stages before it.
  const bool view = !s.viewStage.has(keys.view) && !s.viewFiles().has(keys.view);
  const bool light = view && !s.foreignPhotons && !s.photonStage.has(keys.photons) &&
                     !PhotonFiles(s.options.cache, s.ctx, {}).has(keys.photons);
  const bool medium = view && !s.mediumStage.has(keys.medium);
  std::vector<StagePlan> plan;
  SceneMeshReader reader(s.ctx);
  for (std::size_t i = 0; i < s.scene.objects.size(); ++i) {
    const SceneObject& o = s.scene.objects[i];
    if (!o.visible || !hasSurfaceStage(o)) continue;
    const StageKey key = Surfaces::key(o, s.files, reader);
    plan.push_back({"surface", medium && !s.surfaces.stage(i).has(key), s.surfaces.stage(i).because(key)});
  }
  plan.push_back({"medium", medium, s.mediumStage.because(keys.medium)});
  plan.push_back({"stepField", view && !s.flatStage.has(keys.flat), s.flatStage.because(keys.flat)});
  if (!s.foreignPhotons) plan.push_back({"photons", light, s.photonStage.because(keys.photons)});
  plan.push_back({"view", view, s.viewStage.because(keys.view)});
  return plan;
}

void SceneHistory::push(Scene scene) {
  mScenes.erase(mScenes.begin() + static_cast<std::ptrdiff_t>(mCurrent) + 1, mScenes.end());
  mScenes.push_back(std::move(scene));
  if (mScenes.size() > mDepth + 1) mScenes.erase(mScenes.begin());
  mCurrent = mScenes.size() - 1;
}

const Scene& SceneHistory::undo() {
  if (canUndo()) --mCurrent;
  return current();
}

const Scene& SceneHistory::redo() {
  if (canRedo()) ++mCurrent;
  return current();
}

} // namespace volcaustic
