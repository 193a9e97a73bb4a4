// Numbers positions so that equal ones get the same number.
#pragma once

#include "volcaustic/types.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace volcaustic {

/// A hash table of positions, compared by value (so -0 equals 0); numbers are given in order of first appearance.
class PositionWelder {
public:
  explicit PositionWelder(std::size_t expected = 0) : mSlots(std::bit_ceil(2 * expected + 16), kEmpty) {
    mPositions.reserve(expected);
  }

  /// The number of `p`.
  std::uint32_t add(const Vec3d& p) {
    if (2 * (mPositions.size() + 1) > mSlots.size()) rehash(2 * mSlots.size());
    for (std::size_t slot = hash(p);; ++slot) {
      std::uint32_t& index = mSlots[slot & (mSlots.size() - 1)];
      if (index == kEmpty) {
        index = static_cast<std::uint32_t>(mPositions.size());
        mPositions.push_back(p);
        return index;
      }
      if (mPositions[index] == p) return index;
    }
  }

  [[nodiscard]] std::size_t size() const { return mPositions.size(); }
  /// The distinct positions, by number.
  [[nodiscard]] std::vector<Vec3d> takePositions() { return std::move(mPositions); }
  /// Upper bound of the bytes held, table and positions, for `count` distinct positions.
  [[nodiscard]] static std::uint64_t bytesFor(std::uint64_t count) {
    return count * sizeof(Vec3d) + std::bit_ceil(2 * count + 16) * sizeof(std::uint32_t);
  }

private:
  static constexpr std::uint32_t kEmpty = 0xffffffffu;

  static std::size_t hash(const Vec3d& p) {
    std::uint64_t h = 0;
    for (const double x : p) {
      h = (h ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9e3779b97f4a7c15ull; // + 0.0 turns -0 into 0
      h ^= h >> 32;
    }
    return h;
  }
  void rehash(std::size_t slots) {
    mSlots.assign(slots, kEmpty);
    for (std::size_t i = 0; i < mPositions.size(); ++i) {
      std::size_t slot = hash(mPositions[i]);
      while (mSlots[slot & (slots - 1)] != kEmpty) ++slot;
      mSlots[slot & (slots - 1)] = static_cast<std::uint32_t>(i);
    }
  }

  std::vector<std::uint32_t> mSlots;
  std::vector<Vec3d> mPositions;
};

} // namespace volcaustic
