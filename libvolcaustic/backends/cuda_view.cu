// The camera pass on a CUDA device: the body of kernels/view.h as it stands, a thread for a pixel
// (docs/algorithms/view.md).

#include "backends/cuda_arrays.cuh"
#include "backends/view_tracer.h"

namespace volcaustic {

namespace {

constexpr int kBlock = 128; // threads
constexpr int kWarp = 32;
// A warp takes 8x4 pixels, so that its rays stay together; a tile is as many blocks as it needs.
constexpr int kWarpColumns = 8, kWarpRows = kWarp / kWarpColumns;
constexpr int kTileBlocks = kTilePixels / kBlock;
// Tiles that one launch renders; between launches the run can be cancelled, and tells its progress.
constexpr std::int64_t kLaunchTiles = 256;
constexpr int kCounts = 3; // steps, rays not finite, rays at the step limit

/// Counts of a thread, added to the device's when it is done.
class DeviceViewSink {
public:
  __device__ explicit DeviceViewSink(DeviceSum* totals) : mTotals(totals) {}
  __device__ void count(kernels::Counter c, std::int64_t n) {
    using kernels::Counter;
    mCounts[c == Counter::Steps ? 0 : c == Counter::NotFinite ? 1 : 2] += static_cast<DeviceSum>(n);
  }
  __device__ void addTotals() const {
    for (int i = 0; i < kCounts; ++i)
      if (mCounts[i]) atomicAdd(mTotals + i, mCounts[i]);
  }

private:
  DeviceSum* mTotals;
  DeviceSum mCounts[kCounts] = {};
};

/// Block b renders a part of tile tiles[b / kTileBlocks].
__global__ void __launch_bounds__(kBlock)
    viewTiles(kernels::ViewBody<DeviceViewSink> body, const std::int32_t* tiles, DeviceSum* totals) {
  const std::int32_t width = body.scene.camera.width, columns = (width + kViewTile - 1) / kViewTile;
  const std::int32_t tile = tiles[blockIdx.x / kTileBlocks];
  const int warp =
                static_cast<int>(blockIdx.x % kTileBlocks) * (kBlock / kWarp) + static_cast<int>(threadIdx.x) / kWarp,
            lane = static_cast<int>(threadIdx.x) % kWarp;
  constexpr int kWarpsAcross = kViewTile / kWarpColumns;
  const std::int32_t column = tile % columns * kViewTile + warp % kWarpsAcross * kWarpColumns + lane % kWarpColumns,
                     row = tile / columns * kViewTile + warp / kWarpsAcross * kWarpRows + lane / kWarpColumns;
  if (column >= width || row >= body.scene.camera.height) return;
  DeviceViewSink sink(totals);
  body(std::int64_t{row} * width + column, sink);
  sink.addTotals();
}

/// A view's light in device memory.
class DeviceViewLight {
public:
  DeviceViewLight(DeviceStream& s, const kernels::ViewLight& light, const ViewTables& tables) : mView(light) {
    const std::int64_t bricks = tables.brickCount();
    const auto copy = [&](auto& array, const auto*& host, std::int64_t count) {
      array = {s, host, count, kWhat};
      host = array.data();
    };
    mVoxels = {s, light.caustic.voxels, tables.lightVoxelCount(), kWhat};
    int part = 0;
    for (kernels::LightTexture* texture : {&mView.caustic, &mView.direct, &mView.towards}) {
      if (texture->entries) copy(mEntries[part++], texture->entries, bricks);
      texture->voxels = mVoxels.data();
    }
    // Of the direct light, only the sets of lamps are looked at; the rest is in the voxels.
    const ViewTables::LampCounts lamps = tables.lampCounts();
    mView.lamps.stored = {};
    mView.lamps.sets = nullptr;
    copy(mSetBegins, mView.lamps.setBegins, lamps.sets + 1);
    copy(mSetLamps, mView.lamps.setLamps, lamps.setLamps);
    copy(mLamps, mView.lamps.lamps, lamps.lamps);
  }
  [[nodiscard]] const kernels::ViewLight& view() const { return mView; }

private:
  static constexpr const char* kWhat = "the light of the view";

  kernels::ViewLight mView;
  DeviceArray<kernels::HalfVoxel> mVoxels;
  DeviceArray<std::int32_t> mEntries[3], mSetBegins, mSetLamps;
  DeviceArray<kernels::Lamp> mLamps;
};

/// A background's map in device memory.
class DeviceBackground {
public:
  DeviceBackground(DeviceStream& s, const kernels::Environment& background) : mView(background) {
    const std::int64_t pixels = std::int64_t{background.width} * background.height;
    for (int c = 0; c < 3; ++c) {
      if (!background.planes[c]) continue;
      mPlanes[c] = {s, background.planes[c], pixels, "the background"};
      mView.planes[c] = mPlanes[c].data();
    }
  }
  [[nodiscard]] const kernels::Environment& view() const { return mView; }

private:
  kernels::Environment mView;
  DeviceArray<float> mPlanes[3];
};

/// A picture on one device, which must be current on the calling thread for every member.
class CudaPicture {
public:
  CudaPicture(const kernels::ViewScene& scene, const ViewTables& tables, std::shared_ptr<const DeviceFlatMedium> there,
              const kernels::PixelPlanes& planes, const RunContext& ctx, int ordinal)
      : mCtx(ctx)
      , mHost(planes)
      , mPixels(std::int64_t{scene.camera.width} * scene.camera.height)
      , mStream(ordinal, "view")
      , mMedium(mStream, scene.medium, std::move(there))
      , mLight(mStream, scene.light, tables)
      , mBackground(mStream, scene.rules.background)
      , mReceivers(mStream, scene.receivers)
      , mPlanBricks(mStream, scene.plan.bricks, tables.brickCount(), kPlan)
      , mPlanVoxels(mStream, scene.plan.voxels, tables.planVoxelCount(), kPlan)
      , mPlanes(mStream, (kernels::kPixelPlanes + (planes.spread ? 1 : 0)) * mPixels, "the picture")
      , mTotals(mStream, kCounts, "the picture")
      , mInFlight(mStream)
      , mDone(mStream) {
    mBody.scene = scene;
    mBody.scene.medium = mMedium.view();
    mBody.scene.light = mLight.view();
    mBody.scene.rules.background = mBackground.view();
    mBody.scene.receivers = mReceivers.view();
    mBody.scene.plan.bricks = mPlanBricks.data();
    mBody.scene.plan.voxels = mPlanVoxels.data();
    mBody.planes.voxelSize = planes.voxelSize;
    for (int i = 0; i < kernels::kPixelPlanes; ++i) mBody.planes.of[i] = mPlanes.data() + i * mPixels;
    if (planes.spread) mBody.planes.spread = mPlanes.data() + kernels::kPixelPlanes * mPixels;
    wait(); // an upload that fails is known now
  }

  ViewCounts add(const ViewPass& pass) {
    const auto count = static_cast<std::int64_t>(pass.tiles.size());
    const DeviceArray<std::int32_t> tiles(mStream, pass.tiles.data(), count, "the picture");
    mTotals.fill(0);
    mBody.firstSample = pass.firstSample;
    mBody.endSample = pass.endSample;
    for (std::int64_t first = 0; first < count; first += kLaunchTiles)
      mInFlight.launch([&] {
        mCtx.progress("view", static_cast<double>(first) / static_cast<double>(count));
        launchKernel(mStream, viewTiles, std::min(kLaunchTiles, count - first) * kTileBlocks, kBlock, mBody,
                     static_cast<const std::int32_t*>(tiles.data() + first), mTotals.data());
      });
    for (int i = 0; i < kernels::kPixelPlanes; ++i) mPlanes.download(mHost.of[i], i * mPixels, mPixels);
    if (mHost.spread) mPlanes.download(mHost.spread, kernels::kPixelPlanes * mPixels, mPixels);
    DeviceSum totals[kCounts];
    mTotals.download(totals, 0, kCounts);
    wait();
    return {static_cast<std::int64_t>(totals[0]), static_cast<std::int64_t>(totals[1]),
            static_cast<std::int64_t>(totals[2])};
  }

private:
  static constexpr const char* kPlan = "the plan of the view";

  void wait() {
    mDone.record();
    mDone.wait();
  }

  const RunContext mCtx;
  const kernels::PixelPlanes mHost;
  const std::int64_t mPixels;
  DeviceStream mStream; // the arrays below are freed in its order
  DeviceMedium mMedium;
  DeviceViewLight mLight;
  DeviceBackground mBackground;
  DeviceReceivers mReceivers;
  DeviceArray<std::int32_t> mPlanBricks, mPlanVoxels;
  DeviceArray<float> mPlanes;
  DeviceArray<DeviceSum> mTotals;
  FewInFlight mInFlight;
  DeviceEvent mDone;
  kernels::ViewBody<DeviceViewSink> mBody{};
};

/// The picture behind the interface, with its device current while it works.
class CudaViewer final : public ViewTracer {
public:
  CudaViewer(const kernels::ViewScene& scene, const ViewTables& tables, std::shared_ptr<const DeviceFlatMedium> there,
             const kernels::PixelPlanes& planes, const RunContext& ctx, int ordinal)
      : mOrdinal(ordinal) {
    const DeviceScope device(mOrdinal);
    mPicture = std::make_unique<CudaPicture>(scene, tables, std::move(there), planes, ctx, ordinal);
  }
  ~CudaViewer() override {
    try {
      const DeviceScope device(mOrdinal);
      mPicture.reset();
    } catch (const Error&) { // the device is gone, and its memory with it
    }
  }
  ViewCounts add(const ViewPass& pass) override {
    const DeviceScope device(mOrdinal);
    return mPicture->add(pass);
  }

private:
  const int mOrdinal;
  std::unique_ptr<CudaPicture> mPicture;
};

} // namespace

std::unique_ptr<ViewTracer> makeCudaViewer(const kernels::ViewScene& scene, const ViewTables& tables,
                                           std::shared_ptr<const DeviceFlatMedium> there,
                                           const kernels::PixelPlanes& planes, const RunContext& ctx, int ordinal) {
  return std::make_unique<CudaViewer>(scene, tables, std::move(there), planes, ctx, ordinal);
}

} // namespace volcaustic
