// The last form of a medium: arrays that the kernels read, on this machine or on another.
#pragma once

#include "kernels/flat_medium.h"
#include "volcaustic/medium.h"

#include <vector>

namespace volcaustic {

/// Owns what kernels::FlatMedium points at.
struct FlatMediumStorage {
  kernels::Int3 dims, brickDims;
  std::vector<kernels::BrickRecord> bricks;
  std::vector<kernels::FieldVoxel> fields;
  std::vector<std::uint8_t> steps;
  std::vector<std::uint32_t> voxelOptics;
  std::vector<kernels::Optics> optics;
  float cap = 2;

  [[nodiscard]] kernels::FlatMedium view() const;
  [[nodiscard]] std::size_t memoryBytes() const;
};

/// Builds the step field of the medium (docs/algorithms/step_field.md) and packs both for the kernels. Coefficients are
/// turned to 1/voxel, gradients to 1/voxel; asymmetry comes with the optics.
FlatMediumStorage flattenMedium(const Medium& medium, const StepFieldOptions& options, const RunContext& ctx);

} // namespace volcaustic
