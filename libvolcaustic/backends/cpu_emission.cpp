#include "backends/cpu_emission.h"

#include "core/parallel.h"

namespace volcaustic {

void emitOnCpu(const TracerSetup& setup, const LaneSet& lanes, const RunContext& ctx,
               const kernels::EmissionFrame& frame, const kernels::RasterReach& reach, RowRange rows,
               const RasterCells& cells, std::span<CpuSums> sums) {
  const EmissionTask task{setup.medium, frame,      kernels::rasterView(frame), reach, setup.scale, rows,
                          cells.entry,  cells.stops};
  const std::int64_t first = rows.begin / kernels::kReachTile,
                     last = (rows.end + kernels::kReachTile - 1) / kernels::kReachTile;
  parallelFor(last - first, 1, ctx, [&](std::int64_t begin, std::int64_t end, int slot) {
    for (std::int64_t t = begin; t < end; ++t)
      lanes.emitTileRow(task, static_cast<std::int32_t>(first + t), sums[slot].tally);
  });
}

} // namespace volcaustic
