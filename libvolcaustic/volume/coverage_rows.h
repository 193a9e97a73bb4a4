// Signed crossings of rows of sub-voxels with triangles, and the coverage that the rows of a brick add up to. Plain
// functions over plain structs; voxelise.cpp drives them.
//
// Each sub-voxel holds one sample. A row is all samples of one (i, j); the winding number of a sample is the sum of the
// signs of the crossings before it on its row.
//
// Samples are not at the centres: of a voxel's s x s rows, row (i, j) is sampled at x = i + (j + 1/2)/s, y = j + (i +
// 1/2)/s and z = k + (i s + j + 1/2)/s^2 sub-voxels, so that they lie at s^2 different heights along every axis where
// centres would lie at s. A surface that faces an axis, as the top of a ball does, then moves its coverage in steps of
// 1/s^2 voxel, not of 1/s, and its normal follows: at s = 4 rays through the middle of a ball are eight times truer.
//
// Every decision is taken on coordinates that were snapped to a fixed-point lattice, with samples moved by (eps, eps^2)
// in x and y, so that an edge or a vertex on a sample belongs to exactly one of the triangles around it: rows neither
// leak through shared edges nor count them twice.
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/types.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace volcaustic {

/// Fractional bits of a snapped coordinate: the lattice's unit is 2^-16 sub-voxel.
inline constexpr int kFixedBits = 16;
inline constexpr std::int64_t kFixedOne = std::int64_t{1} << kFixedBits;
/// Largest coordinate that snaps, in sub-voxels: beyond it products of differences would leave 128 bits.
inline constexpr double kMaxSubVoxels = 0x1p40;

struct FixedPoint {
  std::int64_t x, y, z;
};
using FixedTriangle = std::array<FixedPoint, 3>;

/// The sub-voxels of a box of whole bricks.
struct SubLattice {
  Vec3d corner{0, 0, 0}; ///< lower corner of the domain, world space
  double scale = 1;      ///< sub-voxels per world unit
  int log2 = 0;          ///< of the number of sub-voxels along a voxel's edge, 0 to 3
  Vec3i first{0, 0, 0};  ///< first sub-voxel of the box, counted from the domain's corner
  Vec3i size{0, 0, 0};   ///< sub-voxels of the box along each axis

  /// Sub-voxels along a brick's edge: 8 to 64, so that a row through a brick fits one word.
  [[nodiscard]] int brickSamples() const { return kBrickSize << log2; }
  /// Relative to the box's corner. The domain's corner is subtracted first: what is far from the origin keeps its
  /// precision. \pre within kMaxSubVoxels of the domain
  [[nodiscard]] FixedPoint snap(const Vec3d& pWorld) const;
  /// Where sub-voxel (i, j, k) is sampled, relative to the box's corner, in sub-voxels.
  [[nodiscard]] Vec3d sample(int i, int j, int k) const {
    const int s = 1 << log2, p = i & (s - 1), q = j & (s - 1);
    return {i + (q + 0.5) / s, j + (p + 0.5) / s, k + (p * s + q + 0.5) / (s * s)};
  }
};

/// Rows x0..x1 by y0..y1, both inclusive.
struct RowRect {
  int x0, y0, x1, y1;
  [[nodiscard]] bool empty() const { return x0 > x1 || y0 > y1; }
};

/// Rows of the lattice that a triangle's bounding rectangle meets; empty also where it lies beyond the rows' far ends.
RowRect rowsMet(const FixedTriangle& triangle, const SubLattice& lattice);

/// False when no row of `rect` meets the triangle. \pre rect is inside rowsMet(triangle)
bool mayMeet(const FixedTriangle& triangle, const RowRect& rect);

/// A crossing, packed so that integers sort by brick along the row, then row of the column, then sample:
/// brick (12 bits), row (12 bits), first sample at or after the crossing (6 bits), 1 where the winding number rises.
using Crossing = std::uint32_t;
constexpr Crossing packCrossing(int sample, int brickLog2, int row, bool rises) {
  const int inBrick = sample & ((1 << brickLog2) - 1);
  return Crossing(sample >> brickLog2) << 19 | Crossing(row) << 7 | Crossing(inBrick) << 1 | Crossing(rises);
}
constexpr int crossingBrick(Crossing c) { return int(c >> 19); }
constexpr int crossingRow(Crossing c) { return int(c >> 7 & 0xfff); }
constexpr int crossingSample(Crossing c) { return int(c >> 1 & 0x3f); }
constexpr int crossingSign(Crossing c) { return (c & 1) ? 1 : -1; }

/// Appends the crossings of a triangle with the rows of the brick column (columnX, columnY). Crossings before the first
/// sample count at the first, those after the last are dropped.
void appendCrossings(const FixedTriangle& triangle, int columnX, int columnY, const SubLattice& lattice,
                     std::vector<Crossing>& crossings);

/// Bit k: the k-th sample of a row through a brick is inside, which is winding number + offset != 0. `crossings` are
/// those of this row and brick in order; `winding` is the number before the brick and becomes the number after it.
std::uint64_t insideBits(std::span<const Crossing> crossings, int offset, int samples, int& winding);
/// The same with an offset for each sample.
std::uint64_t insideBits(std::span<const Crossing> crossings, std::span<const std::int16_t> offsets, int& winding);

/// Samples inside each voxel of a brick, from the bits of its brickSamples()^2 rows (y fastest).
void countSamples(std::span<const std::uint64_t> rows, int log2, std::span<std::uint16_t, kBrickVoxels> counts);

} // namespace volcaustic
