// The last form of a medium: arrays that the kernels read, on this machine or on another.
#pragma once

#include "core/large_memory.h"
#include "core/zeroed_table.h"
#include "kernels/flat_medium.h"
#include "volcaustic/medium.h"

#include <cstdint>
#include <span>
#include <vector>

namespace volcaustic {

/// Owns what kernels::FlatMedium points at.
struct FlatMediumStorage {
  kernels::Int3 dims, brickDims;
  ZeroedTable<std::int32_t> fieldSlots, stepSlots, opticsSlots;
  ZeroedTable<float> indexOffsets;
  ZeroedTable<std::uint8_t> bends;
  LargeVector<kernels::FieldVoxel> fields;
  LargeVector<std::uint8_t> steps;
  LargeVector<std::int32_t> voxelOptics;
  std::vector<kernels::Optics> optics;
  float ambientIndex = 1;
  std::int32_t ambientStep = 0;
  float cap = 2;
  bool attenuates = false;

  [[nodiscard]] kernels::FlatMedium view() const;
  /// Of the arrays; pages of the tables that nothing was written to count too.
  [[nodiscard]] std::size_t memoryBytes() const;
};

/// Writes 1, 2, ... into the table's entries of the bricks. Returns the number of slots, 0 included.
/// \throws Error(Input) when there are more than kernels can address: with 32 bits, floats of a field voxel too.
std::int64_t assignBrickSlots(std::span<const std::int64_t> bricks, ZeroedTable<std::int32_t>& slots);

/// Builds the step field of the medium (docs/algorithms/step_field.md) and packs both for the kernels. Coefficients are
/// turned to 1/voxel, gradients to 1/voxel; asymmetry comes with the optics.
FlatMediumStorage flattenMedium(const Medium& medium, const StepFieldOptions& options, const RunContext& ctx);

} // namespace volcaustic
