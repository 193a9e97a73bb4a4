// The camera pass on this machine's cores: oneTBB over tiles of the picture, lanes inside.

#include "backends/view_tracer.h"
#include "core/parallel.h"

#include <vector>

namespace volcaustic {

namespace {

class CpuViewer final : public ViewTracer {
public:
  CpuViewer(const kernels::ViewScene& scene, const kernels::PixelPlanes& planes, const LaneSet& lanes,
            const RunContext& ctx)
      : mScene(scene), mPlanes(planes), mLanes(lanes), mCtx(ctx) {
    for (int i = 0; i < threadCount(ctx); ++i) mScratch.push_back(std::make_unique_for_overwrite<ViewScratch>());
  }

  ViewCounts add(const ViewPass& pass) override {
    const std::int32_t columns = (mScene.camera.width + kViewTile - 1) / kViewTile;
    std::vector<ViewCounts> counts(mScratch.size());
    parallelFor(
        static_cast<std::int64_t>(pass.tiles.size()), 1, mCtx,
        [&](std::int64_t begin, std::int64_t end, int slot) {
          for (std::int64_t i = begin; i < end; ++i)
            mLanes.view({mScene, mPlanes, pass.tiles[i] % columns * kViewTile, pass.tiles[i] / columns * kViewTile,
                         pass.firstSample, pass.endSample, *mScratch[slot]},
                        counts[slot]);
        },
        "view");
    ViewCounts total;
    for (const ViewCounts& c : counts) {
      total.steps += c.steps;
      total.notFinite += c.notFinite;
      total.stepLimit += c.stepLimit;
    }
    return total;
  }

private:
  const kernels::ViewScene mScene;
  const kernels::PixelPlanes mPlanes;
  const LaneSet& mLanes;
  const RunContext mCtx;
  std::vector<std::unique_ptr<ViewScratch>> mScratch;
};

} // namespace

std::unique_ptr<ViewTracer> makeCpuViewer(const kernels::ViewScene& scene, const kernels::PixelPlanes& planes,
                                          const LaneSet& lanes, const RunContext& ctx) {
  return std::make_unique<CpuViewer>(scene, planes, lanes, ctx);
}

} // namespace volcaustic
