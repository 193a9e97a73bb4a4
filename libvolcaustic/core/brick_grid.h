// A sparse voxel array over a domain: 8x8x8 bricks, each either one value or 512 of them. The working form between the
// stages; OpenVDB grids are the form at the borders. A brick is an OpenVDB leaf and has its voxel order (x slowest, z
// fastest).
//
// Memory goes by the bricks that are not the background: the tables with an entry for each brick begin as zeros that
// nobody wrote (zeroed_table.h), and zero says "background".
#pragma once

#include "core/large_memory.h"
#include "core/zeroed_table.h"
#include "volcaustic/types.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

namespace volcaustic {

inline constexpr int kBrickLog2 = 3;
inline constexpr int kBrickSize = 1 << kBrickLog2;
inline constexpr int kBrickVoxels = kBrickSize * kBrickSize * kBrickSize;

/// Offset of a voxel in its brick, from the low three bits of each coordinate.
constexpr int brickOffset(int x, int y, int z) { return ((x & 7) << 6) | ((y & 7) << 3) | (z & 7); }

/// Whether new voxels are set to their brick's constant at once, or by the caller.
enum class Fill { Constant, Later };

template <class T>
class BrickGrid {
public:
  BrickGrid() = default;
  BrickGrid(const Vec3i& dims, const T& background)
      : mDims(dims)
      , mBricks{(dims[0] + 7) / 8, (dims[1] + 7) / 8, (dims[2] + 7) / 8}
      , mSlots(std::size_t(mBricks[0]) * mBricks[1] * mBricks[2])
      , mValues(mSlots.size())
      , mBackground(background) {}

  [[nodiscard]] const Vec3i& dims() const { return mDims; }
  [[nodiscard]] const Vec3i& brickDims() const { return mBricks; }
  [[nodiscard]] std::int64_t brickCount() const { return static_cast<std::int64_t>(mSlots.size()); }
  [[nodiscard]] std::int64_t activeBrickCount() const {
    return static_cast<std::int64_t>(mVoxels.size() / kBrickVoxels);
  }
  [[nodiscard]] const T& background() const { return mBackground; }

  [[nodiscard]] std::int64_t brickIndex(const Vec3i& brick) const {
    return (std::int64_t{brick[0]} * mBricks[1] + brick[1]) * mBricks[2] + brick[2];
  }
  [[nodiscard]] Vec3i brickCoord(std::int64_t index) const {
    const int z = static_cast<int>(index % mBricks[2]);
    const std::int64_t rest = index / mBricks[2];
    return {static_cast<int>(rest / mBricks[1]), static_cast<int>(rest % mBricks[1]), z};
  }

  [[nodiscard]] bool isConstant(std::int64_t brick) const { return mSlots[brick] <= 0; }
  /// The one value of a brick that is constant.
  [[nodiscard]] const T& constant(std::int64_t brick) const {
    return mSlots[brick] == kOwnConstant ? mValues[brick] : mBackground;
  }
  /// 512 values of a brick that is not constant.
  [[nodiscard]] std::span<const T> voxels(std::int64_t brick) const {
    assert(!isConstant(brick));
    return {mVoxels.data() + voxelBegin(brick), kBrickVoxels};
  }
  [[nodiscard]] std::span<T> voxels(std::int64_t brick) {
    assert(!isConstant(brick));
    return {mVoxels.data() + voxelBegin(brick), kBrickVoxels};
  }
  /// Of a constant brick. Safe from several threads for different bricks.
  void setConstant(std::int64_t brick, const T& value) {
    assert(isConstant(brick));
    if (value != mBackground) {
      mValues[brick] = value;
      mSlots[brick] = kOwnConstant;
    } else if (mSlots[brick] != kBackground) {
      mSlots[brick] = kBackground;
    }
  }
  /// Gives the brick 512 voxels of its own, filled with its constant. Not safe beside other allocations: use activate
  /// for many bricks at once.
  std::span<T> allocate(std::int64_t brick) {
    if (isConstant(brick)) {
      const T value = constant(brick);
      mVoxels.resize(mVoxels.size() + kBrickVoxels, value);
      mSlots[brick] = static_cast<std::int32_t>(mVoxels.size() / kBrickVoxels);
    }
    return voxels(brick);
  }
  /// allocate() for a list of bricks, in the order given, with one allocation. With Fill::Later the voxels are not
  /// written: whoever asked writes them all, from as many threads as it likes.
  void activate(std::span<const std::int64_t> bricks, Fill fill = Fill::Constant) {
    // At least half as much again, so that many calls in a row do not copy everything each time.
    if (const std::size_t needed = mVoxels.size() + bricks.size() * kBrickVoxels; needed > mVoxels.capacity())
      mVoxels.reserve(std::max(needed, mVoxels.empty() ? 0 : mVoxels.capacity() + mVoxels.capacity() / 2));
    if (fill == Fill::Constant) {
      for (const std::int64_t b : bricks) allocate(b);
      return;
    }
    for (const std::int64_t b : bricks) {
      assert(isConstant(b));
      mVoxels.resize(mVoxels.size() + kBrickVoxels);
      mSlots[b] = static_cast<std::int32_t>(mVoxels.size() / kBrickVoxels);
    }
  }
  /// Value at a voxel of the domain.
  [[nodiscard]] const T& at(int x, int y, int z) const {
    const std::int64_t brick = brickIndex({x >> 3, y >> 3, z >> 3});
    return isConstant(brick) ? constant(brick) : mVoxels[voxelBegin(brick) + brickOffset(x, y, z)];
  }
  /// The same with coordinates clamped into the domain.
  [[nodiscard]] const T& clamped(int x, int y, int z) const {
    return at(std::clamp(x, 0, mDims[0] - 1), std::clamp(y, 0, mDims[1] - 1), std::clamp(z, 0, mDims[2] - 1));
  }

  /// The bricks that are not the background all over, in order: those that vary and those of another value.
  [[nodiscard]] std::vector<std::int64_t> occupied() const {
    std::vector<std::int64_t> bricks;
    mSlots.forEachNonZero(0, mSlots.size(),
                          [&](std::size_t brick) { bricks.push_back(static_cast<std::int64_t>(brick)); });
    return bricks;
  }
  /// Whether the brick and its up to 26 neighbours are constant and of one value.
  [[nodiscard]] bool uniformAround(std::int64_t brick) const {
    if (!isConstant(brick)) return false;
    const Vec3i c = brickCoord(brick);
    const auto first = [&](int a) { return std::max(c[a] - 1, 0); };
    const auto last = [&](int a) { return std::min(c[a] + 1, mBricks[a] - 1); };
    for (int x = first(0); x <= last(0); ++x)
      for (int y = first(1); y <= last(1); ++y)
        for (int z = first(2); z <= last(2); ++z) {
          const std::int64_t other = brickIndex({x, y, z});
          if (!isConstant(other) || constant(other) != constant(brick)) return false;
        }
    return true;
  }

  /// Voxels and tables, pages of the tables that nothing was written to included.
  [[nodiscard]] std::size_t memoryBytes() const {
    return mVoxels.size() * sizeof(T) + mSlots.size() * (sizeof(std::int32_t) + sizeof(T));
  }

private:
  static constexpr std::int32_t kBackground = 0, kOwnConstant = -1;
  [[nodiscard]] std::size_t voxelBegin(std::int64_t brick) const {
    return (std::size_t(mSlots[brick]) - 1) * kBrickVoxels;
  }

  Vec3i mDims{0, 0, 0}, mBricks{0, 0, 0};
  ZeroedTable<std::int32_t> mSlots; // 1 and up: slot among the voxels + 1
  ZeroedTable<T> mValues;           // where the slot says kOwnConstant
  LargeVector<T> mVoxels;
  T mBackground{};
};

} // namespace volcaustic
