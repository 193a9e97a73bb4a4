// Sets of bricks of a domain, small where they hold few.
#pragma once

#include "core/zeroed_table.h"
#include "volcaustic/types.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

namespace volcaustic {

/// What either of two sorted lists holds, sorted.
inline std::vector<std::int64_t> merged(std::span<const std::int64_t> a, std::span<const std::int64_t> b) {
  std::vector<std::int64_t> both;
  both.reserve(a.size() + b.size());
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

/// Bricks by index, z fastest, as BrickGrid counts them.
class BrickSet {
public:
  explicit BrickSet(const Vec3i& brickDims)
      : mBricks(brickDims), mHeld(std::size_t(brickDims[0]) * brickDims[1] * brickDims[2]) {}

  /// The bricks and the up to 26 neighbours of each.
  void insertAround(std::span<const std::int64_t> bricks) {
    for (const std::int64_t b : bricks) {
      const std::int64_t row = b / mBricks[2];
      const int x = static_cast<int>(row / mBricks[1]), y = static_cast<int>(row % mBricks[1]);
      const int z = static_cast<int>(b % mBricks[2]);
      const int z0 = std::max(z - 1, 0), z1 = std::min(z + 1, mBricks[2] - 1);
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, mBricks[0] - 1); ++i)
        for (int j = std::max(y - 1, 0); j <= std::min(y + 1, mBricks[1] - 1); ++j)
          for (int k = z0; k <= z1; ++k) mHeld[(std::size_t(i) * mBricks[1] + j) * mBricks[2] + k] = 1;
    }
  }
  /// Those from one corner to another, both inclusive and in the domain.
  void insertBox(const Vec3i& first, const Vec3i& last) {
    for (int i = first[0]; i <= last[0]; ++i)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int k = first[2]; k <= last[2]; ++k) mHeld[(std::size_t(i) * mBricks[1] + j) * mBricks[2] + k] = 1;
  }
  /// What it holds, in order.
  [[nodiscard]] std::vector<std::int64_t> sorted() const {
    std::vector<std::int64_t> bricks;
    mHeld.forEachNonZero(0, mHeld.size(), [&](std::size_t b) { bricks.push_back(static_cast<std::int64_t>(b)); });
    return bricks;
  }

private:
  Vec3i mBricks;
  ZeroedTable<std::uint8_t> mHeld;
};

} // namespace volcaustic
