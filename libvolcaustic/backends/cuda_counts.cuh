// Samples inside a closed mesh, counted for each voxel in device memory (docs/algorithms/cuda.md, "Voxelising").
#pragma once

#include "backends/cuda_memory.cuh"
#include "backends/medium_plan.h"
#include "volcaustic/run_context.h"

namespace volcaustic {

/// Of the bricks of a mesh's lattice, z fastest, as kernels::PaintedBody has them.
struct DeviceCounts {
  DeviceArray<kernels::BrickFill> fills;
  DeviceArray<std::uint32_t> counted;
  DeviceArray<std::uint16_t> counts;
  bool any = false; ///< any sample is inside
};

/// The counts of the CPU to the bit, as many columns of bricks at a time as memory holds. \throws Error(Device).
DeviceCounts countOnDevice(DeviceStream& stream, const CountTask& task, const RunContext& ctx);

} // namespace volcaustic
