// The sums of a block of 4x4x4 bricks while they are made: 32x32x32 voxels, and one voxel around them so that a block
// can be smoothed without its neighbours, of eight 32-bit integers: 1.3 MB, which stay in a core's second-level cache.
#pragma once

#include "kernels/block_light.h"
#include "kernels/tally.h"

#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <vector>

namespace volcaustic {

inline constexpr int kBlockLog2 = 5;
inline constexpr int kBlockEdge = 1 << kBlockLog2;
/// The same with one voxel around the block.
inline constexpr int kSumsEdge = kBlockEdge + 2;
inline constexpr int kSumsVoxels = kSumsEdge * kSumsEdge * kSumsEdge;

/// Sums of a voxel: powerLength RGB, then its luminance-weighted direction.
inline constexpr int kSums = 6;
using VoxelSums = std::array<std::int64_t, kSums>;

/// Blocks along each axis of a domain.
inline kernels::Int3 blockDims(const kernels::Int3& dims) {
  return {(dims.x + kBlockEdge - 1) >> kBlockLog2, (dims.y + kBlockEdge - 1) >> kBlockLog2,
          (dims.z + kBlockEdge - 1) >> kBlockLog2};
}
/// First voxel of a block, blocks numbered with z fastest.
inline kernels::Int3 blockCorner(const kernels::Int3& blockDims, std::int64_t block) {
  const auto rest = static_cast<std::int32_t>(block / blockDims.z);
  return {rest / blockDims.y * kBlockEdge, rest % blockDims.y * kBlockEdge,
          static_cast<std::int32_t>(block % blockDims.z) * kBlockEdge};
}
/// Number of a voxel in its block's sums, from its place relative to the block's corner, -1 to 32; z fastest.
constexpr int sumsOffset(int x, int y, int z) { return ((x + 1) * kSumsEdge + y + 1) * kSumsEdge + z + 1; }
/// Calls visit(k, number in the sums) for the voxels k of a brick (z fastest) that are inside; `corner` is the brick's
/// first voxel relative to the block's corner.
template <class Visit>
void forVoxelsInSums(const kernels::Int3& corner, const Visit& visit) {
  const auto from = [](int c) { return c < -1 ? -1 - c : 0; };
  const auto to = [](int c) { return c + 8 > kBlockEdge + 1 ? kBlockEdge + 1 - c : 8; };
  for (int x = from(corner.x); x < to(corner.x); ++x)
    for (int y = from(corner.y); y < to(corner.y); ++y)
      for (int z = from(corner.z); z < to(corner.z); ++z)
        visit(x << 6 | y << 3 | z, sumsOffset(corner.x + x, corner.y + y, corner.z + z));
}
/// Calls visit(number of a brick, its first voxel relative to the block's corner) for the bricks of the block, and for
/// those around it, that are inside the domain.
template <class Visit>
void forBricksInSums(const kernels::Int3& brickDims, const kernels::Int3& corner, const Visit& visit) {
  constexpr int kEdge = kBlockEdge / 8;
  const kernels::Int3 first(corner.x / 8, corner.y / 8, corner.z / 8);
  const auto from = [](int c) { return c > 0 ? c - 1 : 0; };
  const auto to = [](int c, int dim) { return c + kEdge + 1 < dim ? c + kEdge + 1 : dim; };
  for (int x = from(first.x); x < to(first.x, brickDims.x); ++x)
    for (int y = from(first.y); y < to(first.y, brickDims.y); ++y)
      for (int z = from(first.z); z < to(first.z, brickDims.z); ++z)
        visit((std::int64_t{x} * brickDims.y + y) * brickDims.z + z,
              kernels::Int3(8 * (x - first.x), 8 * (y - first.y), 8 * (z - first.z)));
}

/// Adds to a voxel's eight low sums where they stay within half of their range; false, and nothing done, where not.
bool addWithinRange(std::int32_t* low, const VoxelSums& sums);

class BlockSums {
public:
  BlockSums();

  void clear();
  /// Eight for each voxel: powerLength RGB, 0, direction, 0.
  [[nodiscard]] std::int32_t* low() { return mLow.get(); }
  /// Moves sums that have used half of their range to 64 bits. Whoever adds through low() calls it before any sum can
  /// have grown by half the range.
  void carry();

  void add(int voxel, const VoxelSums& sums);
  [[nodiscard]] VoxelSums at(int voxel) const;
  [[nodiscard]] const std::int32_t* low() const { return mLow.get(); }
  /// What voxels hold beyond low(), in their order.
  [[nodiscard]] std::vector<kernels::CarriedSums> carried() const;

private:
  void carry(int voxel);

  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  std::unique_ptr<std::int32_t[], Free> mLow;
  std::map<int, VoxelSums> mHigh;
};

} // namespace volcaustic
