// The sums of a block of 4x4x4 bricks while they are made: 32x32x32 voxels of eight 32-bit integers, a megabyte, which
// stays in a core's second-level cache.
#pragma once

#include "kernels/tally.h"

#include <array>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <unordered_map>

namespace volcaustic {

inline constexpr int kBlockLog2 = 5;
inline constexpr int kBlockEdge = 1 << kBlockLog2;
inline constexpr int kBlockVoxels = kBlockEdge * kBlockEdge * kBlockEdge;

/// Sums of a voxel: powerLength RGB, then its luminance-weighted direction.
inline constexpr int kSums = 6;
using VoxelSums = std::array<std::int64_t, kSums>;

/// Blocks along each axis of a domain.
inline kernels::Int3 blockDims(const kernels::Int3& dims) {
  return {(dims.x + kBlockEdge - 1) >> kBlockLog2, (dims.y + kBlockEdge - 1) >> kBlockLog2,
          (dims.z + kBlockEdge - 1) >> kBlockLog2};
}
/// Number of a voxel in its block, from the low bits of its coordinates; z fastest.
constexpr int blockOffset(int x, int y, int z) {
  return ((x & 31) << (2 * kBlockLog2)) | ((y & 31) << kBlockLog2) | (z & 31);
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
  /// The eight low sums of a voxel when they are all there is, for whole blocks: null where some were carried.
  [[nodiscard]] const std::int32_t* lowOnly() const { return mHigh.empty() ? mLow.get() : nullptr; }

private:
  void carry(int voxel);

  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  std::unique_ptr<std::int32_t[], Free> mLow;
  std::unordered_map<int, VoxelSums> mHigh;
};

} // namespace volcaustic
