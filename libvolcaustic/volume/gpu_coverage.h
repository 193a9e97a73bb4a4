// Coverage of a closed mesh on the GPU.
#pragma once

#include "backends/cuda_voxeliser.h"
#include "core/brick_grid.h"

#include <string_view>

namespace volcaustic {

/// Voxelises on the GPU that ctx.device means, with the CPU's result to the bit. False, and `coverage` untouched, when
/// the CPU is to do it: ctx.device means it, or leaves it open and the mesh is small, or a GPU that it left open has
/// failed, which is warned of. `coverage` has the task's bricks, all of them 0. \throws Error(Device) when a device
/// asked for by name cannot be used or its memory does not do; Error(Input), naming `what`, for the host's.
bool coverageOnGpu(const CountTask& task, std::string_view what, BrickGrid<float>& coverage, const RunContext& ctx);

} // namespace volcaustic
