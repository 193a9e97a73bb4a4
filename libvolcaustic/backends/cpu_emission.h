// Emission on this machine's cores.
#pragma once

#include "backends/lanes.h"
#include "volcaustic/run_context.h"

#include <span>

namespace volcaustic {

/// PhotonTracer::emit on the worker threads: `sums` has an entry for each of them. The same bits for any number of
/// threads and any way of dividing a raster's rows into calls.
void emitOnCpu(const TracerSetup& setup, const LaneSet& lanes, const RunContext& ctx,
               const kernels::EmissionFrame& frame, const kernels::RasterReach& reach, RowRange rows,
               const RasterCells& cells, std::span<CpuSums> sums);

} // namespace volcaustic
