#include "volcaustic/live.h"

#include "volcaustic/error.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

namespace volcaustic {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kGreatestVoxelReduction = 4;
constexpr int kLeastCells = 8; ///< along a shape, for its triangles

/// The scene with fewer pixels along each axis and, where light has to be made anew, fewer photons and voxels, and
/// larger triangles of shapes. Surfaces stay as thick as they are in the world.
Scene reduced(Scene scene, int reduction, bool light) {
  if (reduction == 1) return scene;
  for (int& n : scene.camera.resolution) n = std::max(n / reduction, 1);
  scene.view.samples = 1;
  if (!light) return scene;
  for (int& n : scene.photons.grid) n = std::max(n / reduction, 1);
  const int voxels = std::min(reduction, kGreatestVoxelReduction);
  scene.volume.resolution = std::max(scene.volume.resolution / voxels, 1);
  scene.volume.voxelSize *= voxels;
  scene.voxelise.blur = std::max(scene.voxelise.blur / voxels | 1, 1); // odd
  for (SceneObject& o : scene.objects) {                               // triangles of shapes
    o.polygonise.resolution =
        std::max(o.polygonise.resolution / voxels, std::min(o.polygonise.resolution, kLeastCells));
    o.polygonise.cellSize *= voxels;
  }
  return scene;
}

/// Whether more than the view would run.
bool makesLight(const std::vector<StagePlan>& plan) {
  return std::any_of(plan.begin(), plan.end(), [](const StagePlan& s) { return s.runs && s.stage != "view"; });
}

} // namespace

struct LiveSession::State {
  mutable std::mutex mutex;
  mutable std::condition_variable changed; // a new scene, a new picture, or the end
  Scene scene;
  std::string device;
  std::uint64_t revision = 1;
  bool stop = false;
  std::shared_ptr<const LiveFrame> latest;
  std::string stageName;
  double stagePart = 0;

  LiveOptions options;
  std::atomic<bool> cancel{false};
  std::atomic<bool> refining{false};
  RunContext outside; // as it was given
  std::thread worker;

  /// Of rough pictures that need new light, and of those that do not.
  int roughReduction[2];

  [[nodiscard]] RunContext context() {
    RunContext ctx = outside;
    ctx.cancel = &cancel;
    ctx.device = device;
    ctx.onProgress = [this](std::string_view stage, double part) {
      const std::lock_guard lock(mutex);
      stageName = stage;
      stagePart = part;
    };
    return ctx;
  }

  /// Learns from a rough picture: the next one takes about a quarter with twice the reduction, four times with half.
  void learn(int& reduction, double ms) const {
    if (ms > options.frameMs)
      reduction = std::min(reduction * 2, options.greatestReduction);
    else if (ms * 5 < options.frameMs)
      reduction = std::max(reduction / 2, 1);
  }

  std::shared_ptr<LiveFrame> render(Session& session, const Scene& wanted, std::uint64_t of, int reduction,
                                    bool light) {
    auto frame = std::make_shared<LiveFrame>();
    frame->revision = of;
    frame->scene = wanted;
    frame->reduction = reduction;
    const std::size_t before = session.runs().size();
    const auto start = Clock::now();
    try {
      session.setScene(reduced(wanted, reduction, light));
      frame->medium = session.sharedMedium();
      frame->flat = session.sharedFlat();
      frame->photons = session.sharedPhotons();
      frame->view = session.sharedView();
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::Cancelled) return nullptr;
      frame->error = error.what();
      frame->errorKind = error.kind();
    } catch (const std::exception& error) {
      frame->error = error.what();
    }
    frame->milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    frame->runs.assign(session.runs().begin() + static_cast<std::ptrdiff_t>(before), session.runs().end());
    return frame;
  }

  void publish(std::shared_ptr<LiveFrame> frame) {
    const std::lock_guard lock(mutex);
    if (!frame->error.empty() && latest) {
      frame->medium = latest->medium;
      frame->flat = latest->flat;
      frame->photons = latest->photons;
      frame->view = latest->view;
    }
    latest = std::move(frame);
    stageName.clear();
    stagePart = 0;
    changed.notify_all();
  }

  void run() {
    std::unique_lock first(mutex); // which others may already be changing
    Session session(scene, context(), {.results = 4});
    first.unlock();
    std::uint64_t done = 0;
    int reduction = 0; // of the latest picture of revision `done`
    bool light = true; // it is made of light of that reduction
    for (;;) {
      Scene wanted;
      std::uint64_t of = 0;
      bool rough = false;
      {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return stop || revision != done || reduction > 1; });
        if (stop) return;
        wanted = scene;
        of = revision;
        rough = of != done;
        refining = !rough; // only a refinement gives way to a newer scene
        cancel = false;
        if (session.context().device != device) session.setContext(context());
      }
      if (rough) light = needsLight(session, wanted);
      reduction = rough ? roughReduction[light] : reduction / 2;
      const std::shared_ptr<LiveFrame> frame = render(session, wanted, of, reduction, light);
      if (!frame) { // cancelled: what is newer has priority
        reduction = std::max(reduction * 2, 2);
        continue;
      }
      done = of;
      if (!frame->error.empty())
        reduction = 1; // nothing to refine
      else if (rough)
        learn(roughReduction[light], frame->milliseconds);
      publish(frame);
    }
  }

  static bool needsLight(Session& session, const Scene& wanted) {
    try {
      session.setScene(wanted);
      return makesLight(session.plan());
    } catch (const std::exception&) {
      return true; // whoever renders it reports
    }
  }

  /// \pre the mutex is held
  std::uint64_t renew() {
    ++revision;
    if (refining) cancel = true;
    changed.notify_all();
    return revision;
  }
};

LiveSession::LiveSession(Scene scene, LiveOptions options, RunContext ctx) : mState(std::make_unique<State>()) {
  if (!(options.frameMs > 0)) throw Error(ErrorKind::Usage, "live: frameMs must be above 0");
  if (options.greatestReduction < 1 || !std::has_single_bit(static_cast<unsigned>(options.greatestReduction)))
    throw Error(ErrorKind::Usage, "live: greatestReduction must be a power of two");
  mState->scene = std::move(scene);
  mState->options = options;
  mState->device = ctx.device;
  mState->outside = std::move(ctx);
  for (int& reduction : mState->roughReduction) reduction = options.greatestReduction;
  mState->worker = std::thread([s = mState.get()] { s->run(); });
}

LiveSession::~LiveSession() {
  {
    const std::lock_guard lock(mState->mutex);
    mState->stop = true;
    mState->cancel = true;
    mState->changed.notify_all();
  }
  mState->worker.join();
}

std::uint64_t LiveSession::setScene(Scene scene) {
  const std::lock_guard lock(mState->mutex);
  mState->scene = std::move(scene);
  return mState->renew();
}

std::uint64_t LiveSession::setDevice(std::string device) {
  const std::lock_guard lock(mState->mutex);
  mState->device = std::move(device);
  return mState->renew();
}

std::shared_ptr<const LiveFrame> LiveSession::latest() const {
  const std::lock_guard lock(mState->mutex);
  return mState->latest;
}

std::shared_ptr<const LiveFrame> LiveSession::wait(std::uint64_t revision, int reduction) const {
  std::unique_lock lock(mState->mutex);
  const auto& latest = mState->latest;
  const auto isThere = [&] {
    return latest && latest->revision >= revision && (latest->reduction <= reduction || !latest->error.empty());
  };
  constexpr std::chrono::milliseconds kLook(20); // at whether the caller has given up
  while (!mState->changed.wait_for(lock, kLook, isThere)) mState->outside.throwIfCancelled();
  return latest;
}

bool LiveSession::busy() const {
  const std::lock_guard lock(mState->mutex);
  const auto& latest = mState->latest;
  return !latest || latest->revision != mState->revision || (latest->reduction > 1 && latest->error.empty());
}

std::pair<std::string, double> LiveSession::progress() const {
  const std::lock_guard lock(mState->mutex);
  return {mState->stageName, mState->stagePart};
}

} // namespace volcaustic
