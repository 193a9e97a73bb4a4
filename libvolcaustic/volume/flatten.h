// From a medium to the arrays that the kernels read.
#pragma once

#include "backends/flat_storage.h"
#include "volcaustic/medium.h"

#include <cstdint>
#include <span>

namespace volcaustic {

/// Writes 1, 2, ... into the table's entries of the bricks. Returns the number of slots, 0 included.
/// \throws Error(Input) when there are more than kernels can address: with 32 bits, floats of a field voxel too.
std::int64_t assignBrickSlots(std::span<const std::int64_t> bricks, ZeroedTable<std::int32_t>& slots);

/// Builds the step field of the medium (docs/algorithms/step_field.md) and packs both for the kernels. Coefficients are
/// turned to 1/voxel, gradients to 1/voxel; asymmetry comes with the optics.
FlatMediumStorage flattenMedium(const Medium& medium, const StepFieldOptions& options, const RunContext& ctx);

} // namespace volcaustic
