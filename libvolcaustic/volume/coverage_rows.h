// The lattice of sub-voxels that coverage is counted on, and the counting.
//
// Each sub-voxel holds one sample. A row is all samples of one (i, j); the winding number of a sample is the sum of the
// signs of the crossings before it on its row (kernels/rows.h).
//
// Samples are not at the centres: of a voxel's s x s rows, row (i, j) is sampled at x = i + (j + 1/2)/s, y = j + (i +
// 1/2)/s and z = k + (i s + j + 1/2)/s^2 sub-voxels, so that they lie at s^2 different heights along every axis where
// centres would lie at s. A surface that faces an axis, as the top of a ball does, then moves its coverage in steps of
// 1/s^2 voxel, not of 1/s, and its normal follows: at s = 4 rays through the middle of a ball are eight times truer.
#pragma once

#include "core/brick_grid.h"
#include "kernels/rows.h"
#include "volcaustic/types.h"

#include <array>
#include <cstdint>
#include <span>

namespace volcaustic {

/// Largest coordinate that snaps, in sub-voxels: beyond it products of differences would leave 128 bits.
inline constexpr double kMaxSubVoxels = 0x1p40;

using kernels::kFixedOne;

/// A snapped point: whole numbers of the lattice's unit.
struct LatticePoint {
  double x, y, z;
};

/// The sub-voxels of a box of whole bricks.
struct SubLattice {
  Vec3d corner{0, 0, 0}; ///< lower corner of the domain, world space
  double scale = 1;      ///< sub-voxels per world unit
  int log2 = 0;          ///< of the number of sub-voxels along a voxel's edge, 0 to 3
  Vec3i first{0, 0, 0};  ///< first sub-voxel of the box, counted from the domain's corner
  Vec3i size{0, 0, 0};   ///< sub-voxels of the box along each axis

  /// Sub-voxels along a brick's edge: 8 to 64, so that a row through a brick fits one word.
  [[nodiscard]] int brickSamples() const { return kBrickSize << log2; }
  /// Snapped to the lattice of 2^-16 sub-voxel: whole numbers of its units, relative to the box's corner. The domain's
  /// corner is subtracted first: what is far from the origin keeps its precision.
  [[nodiscard]] LatticePoint snap(const Vec3d& pWorld) const;
  /// snap() of `count` points, three numbers each.
  void snap(const double* pWorld, std::int64_t count, double* snapped) const;
  /// Where sub-voxel (i, j, k) is sampled, relative to the box's corner, in sub-voxels.
  [[nodiscard]] Vec3d sample(int i, int j, int k) const {
    const int s = 1 << log2, p = i & (s - 1), q = j & (s - 1);
    return {i + (q + 0.5) / s, j + (p + 0.5) / s, k + (p * s + q + 0.5) / (s * s)};
  }
};

/// The inside of a brick's rows along which the winding number does not change: bit k of a row is set where that and
/// the offset of sample k (`samples` a row, in row order) are not 0 together.
void insideOfOffsets(const std::int32_t* winding, const std::int16_t* offsets, int rows, int samples,
                     std::uint32_t* inside);
void insideOfOffsets(const std::int64_t* winding, const std::int16_t* offsets, int rows, int samples,
                     std::uint64_t* inside);

/// Samples inside each voxel of a brick, from the bits of its brickSamples()^2 rows (y fastest).
void countSamples(const std::uint32_t* rows, int log2, std::span<std::uint16_t, kBrickVoxels> counts);
void countSamples(const std::uint64_t* rows, int log2, std::span<std::uint16_t, kBrickVoxels> counts);

} // namespace volcaustic
