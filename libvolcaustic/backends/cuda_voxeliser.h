// Samples inside a closed mesh, counted for each voxel on a CUDA device (docs/algorithms/cuda.md). Names no CUDA type.
#pragma once

#include "volcaustic/run_context.h"
#include "volcaustic/types.h"

#include <array>
#include <cstdint>
#include <functional>
#include <span>

namespace volcaustic {

/// The triangles of a closed mesh on a lattice of sub-voxels (kernels/rows.h).
struct CountTask {
  std::span<const double> points; ///< three a vertex: whole numbers of lattice units
  std::span<const std::array<std::uint32_t, 3>> triangles;
  Vec3i bricks; ///< of the lattice
  int log2;     ///< of the sub-voxels along a voxel's edge, 0 to 3
};

/// What is inside of a brick: nothing, everything, or as its counts say.
enum class BrickFill : std::uint8_t { Empty, Full, Counted };

/// Bricks one after the other, z fastest.
struct CountedBricks {
  std::int64_t first;                    ///< brick
  std::span<const BrickFill> fills;      ///< of each
  std::span<const std::uint16_t> counts; ///< samples inside the 512 voxels of those that are Counted, in their order
};
using TakeBricks = std::function<void(const CountedBricks&)>;

/// Calls take() for all bricks of the lattice, in their order, as many at a time as memory holds; what it is given
/// lasts until it returns. The counts are those of the CPU to the bit. \throws Error(Device) beginning with "cuda:I".
void countOnCuda(const CountTask& task, const TakeBricks& take, const RunContext& ctx, int ordinal);

} // namespace volcaustic
