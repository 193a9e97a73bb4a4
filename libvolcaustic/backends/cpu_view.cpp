// The camera pass on this machine's cores: oneTBB over blocks of the picture, lanes inside.

#include "backends/cpu_view.h"

#include "core/parallel.h"

#include <vector>

namespace volcaustic {

ViewCounts viewOnCpu(const kernels::ViewScene& scene, const kernels::PixelPlanes& planes, const LaneSet& lanes,
                     const RunContext& ctx) {
  const auto blocks = [](std::int64_t pixels) { return (pixels + kViewBlock - 1) / kViewBlock; };
  const std::int64_t columns = blocks(scene.camera.width);
  std::vector<ViewCounts> counts(threadCount(ctx));
  parallelFor(
      columns * blocks(scene.camera.height), 1, ctx,
      [&](std::int64_t begin, std::int64_t end, int slot) {
        for (std::int64_t b = begin; b < end; ++b)
          lanes.view({scene, planes, static_cast<std::int32_t>(b % columns * kViewBlock),
                      static_cast<std::int32_t>(b / columns * kViewBlock)},
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

} // namespace volcaustic
