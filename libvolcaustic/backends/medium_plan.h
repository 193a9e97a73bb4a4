// What whoever builds a medium tells the machine that does it.
#pragma once

#include "kernels/flattening.h"
#include "volcaustic/types.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace volcaustic {

/// The triangles of a closed mesh on a lattice of sub-voxels (kernels/rows.h).
struct CountTask {
  std::span<const double> points; ///< three a vertex: whole numbers of lattice units
  std::span<const std::array<std::uint32_t, 3>> triangles;
  Vec3i bricks; ///< of the lattice
  int log2;     ///< of the sub-voxels along a voxel's edge, 0 to 3
};

struct MediumPlan {
  kernels::Int3 dims;
  kernels::PointOptics ambient;
  std::uint8_t grids; ///< kernels::PaintedGrids that some body changes
  int blur;           ///< width of the Gaussian on the index, odd, 1 to 11
  kernels::BlurWeights weights;
};

/// A body's samples on the host, as kernels::PaintedBody has them.
struct BodyCounts {
  kernels::Int3 first, bricks;
  int log2; ///< of the sub-voxels along a voxel's edge
  std::vector<kernels::BrickFill> fills;
  std::vector<std::uint32_t> counted;
  std::vector<std::uint16_t> counts;
};

} // namespace volcaustic
