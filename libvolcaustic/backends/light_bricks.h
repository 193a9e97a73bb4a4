// Where light bends: private sums of a worker, in 8x8x8 bricks that appear when touched.
//
// A voxel is eight 32-bit integers, half a cache line: powerLength RGB, 0, luminance-weighted direction, 0. Integers
// add up to the same in any order, so neither the number of threads nor their timing changes a bit. When a sum comes
// near the end of its range the voxel's sums are carried to 64-bit ones; that happens once in some thousand deposits,
// at the brightest voxels only.
#pragma once

#include "backends/photon_tracer.h"

#include <atomic>
#include <memory>
#include <unordered_map>
#include <vector>

namespace volcaustic {

/// A budget that the workers of a pass share.
struct MemoryBudget {
  std::uint64_t limit = 0;
  std::atomic<std::uint64_t> used{0};
};

class LightBricks {
public:
  struct alignas(32) Sums {
    std::int32_t s[8];
  };
  using Brick = std::array<Sums, kernels::kStepVoxels>;
  /// Sums stay within this; a deposit adds less.
  static constexpr std::int32_t kCarryAt = 1 << 30;

  LightBricks(std::int64_t brickCount, MemoryBudget& budget);
  LightBricks(LightBricks&&) = default;
  ~LightBricks();

  /// The brick's sums, made on first touch. \throws Error(Input) beyond the budget.
  [[nodiscard]] Brick& touch(std::int64_t brick) {
    if (!mBricks[brick]) [[unlikely]]
      allocate(brick);
    return *mBricks[brick];
  }
  /// touch() by table: entries are null until allocate().
  [[nodiscard]] Brick* const* table() const { return mBricks.get(); }
  void allocate(std::int64_t brick);
  /// Moves a voxel's sums to 64 bits.
  void carry(std::int64_t brick, std::int32_t offset);

  [[nodiscard]] bool touched(std::int64_t brick) const { return mBricks[brick] != nullptr; }
  /// Adds a brick to a block of which, or beside which, it is; `corner` is its first voxel relative to the block's.
  void addTo(std::int64_t brick, BlockSums& sums, const kernels::Int3& corner) const;
  /// The other way: adds to a brick what its own block holds.
  void add(std::int64_t brick, const BlockSums& sums, const kernels::Int3& corner);

private:
  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  std::unique_ptr<Brick*[], Free> mBricks; // calloc: pages that nothing is written to cost nothing
  std::vector<Brick*> mChunks;
  std::size_t mInLastChunk;
  std::unordered_map<std::int64_t, VoxelSums> mCarried; // by 512 * brick + offset
  MemoryBudget* mBudget;
};

} // namespace volcaustic
