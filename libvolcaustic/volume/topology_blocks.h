// The nodes of a lattice near a change of the surface, in blocks.
#pragma once

#include "volcaustic/run_context.h"
#include "volcaustic/types.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace volcaustic {

/// A set of blocks of 8 x 8 x 8 nodes. Node (i, j, k) is at voxelSize * (i, j, k). A value for each node is held in an
/// array of nodeCount() elements.
class BlockGrid {
public:
  static constexpr int kSide = 8;
  static constexpr int kNodes = kSide * kSide * kSide;
  static constexpr std::int64_t kNone = -1;

  BlockGrid(const Box& room, double voxelSize, const RunContext& ctx) : mVoxelSize(voxelSize) {
    double blocks = 1;
    for (int k = 0; k < 3; ++k) {
      mFirst[k] = blockOf(room.min[k]);
      mSize[k] = blockOf(room.max[k]) - mFirst[k] + 1;
      blocks *= mSize[k];
    }
    ctx.requireMemory(static_cast<std::uint64_t>(std::min(blocks * sizeof(int), 1e18)), "the blocks of the level set");
    mSlot.assign(static_cast<std::size_t>(blocks), -1);
  }

  [[nodiscard]] double voxelSize() const { return mVoxelSize; }
  /// Marks the blocks that a box touches; number() makes them usable.
  void mark(const Box& box) {
    std::array<int, 3> low, high;
    for (int k = 0; k < 3; ++k) {
      low[k] = std::max(blockOf(box.min[k]), mFirst[k]);
      high[k] = std::min(blockOf(box.max[k]), mFirst[k] + mSize[k] - 1);
    }
    for (int z = low[2]; z <= high[2]; ++z)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int x = low[0]; x <= high[0]; ++x) mSlot[slot(x, y, z)] = 0;
  }
  void number() {
    mBlocks.clear();
    for (int z = 0; z < mSize[2]; ++z)
      for (int y = 0; y < mSize[1]; ++y)
        for (int x = 0; x < mSize[0]; ++x) {
          int& index = mSlot[slot(x + mFirst[0], y + mFirst[1], z + mFirst[2])];
          if (index < 0) continue;
          index = static_cast<int>(mBlocks.size());
          mBlocks.push_back({(x + mFirst[0]) * kSide, (y + mFirst[1]) * kSide, (z + mFirst[2]) * kSide});
        }
  }

  /// The first node of each block.
  [[nodiscard]] const std::vector<Vec3i>& blocks() const { return mBlocks; }
  [[nodiscard]] std::size_t nodeCount() const { return mBlocks.size() * kNodes; }
  [[nodiscard]] std::int64_t node(int i, int j, int k) const {
    const int x = (i >> 3) - mFirst[0], y = (j >> 3) - mFirst[1], z = (k >> 3) - mFirst[2];
    if (x < 0 || y < 0 || z < 0 || x >= mSize[0] || y >= mSize[1] || z >= mSize[2]) return kNone;
    const int block = mSlot[(static_cast<std::size_t>(z) * mSize[1] + y) * mSize[0] + x];
    if (block < 0) return kNone;
    return std::int64_t{block} * kNodes + static_cast<std::int64_t>(inBlock({i, j, k}));
  }
  /// The place of a node in its block.
  [[nodiscard]] static std::size_t inBlock(const Vec3i& n) {
    return static_cast<std::size_t>(((n[2] & 7) * kSide + (n[1] & 7)) * kSide + (n[0] & 7));
  }
  /// The coordinates of a node.
  [[nodiscard]] Vec3i coordinates(std::size_t node) const {
    const Vec3i& b = mBlocks[node / kNodes];
    const int n = static_cast<int>(node % kNodes);
    return {b[0] + (n & 7), b[1] + ((n >> 3) & 7), b[2] + (n >> 6)};
  }
  [[nodiscard]] Vec3d position(const Vec3i& n) const {
    return {mVoxelSize * n[0], mVoxelSize * n[1], mVoxelSize * n[2]};
  }
  /// The nodes around a cell of lowest node (i, j, k): corner c is at (c & 1, c >> 1 & 1, c >> 2). False where one of
  /// them is in no block.
  [[nodiscard]] bool cell(int i, int j, int k, std::array<std::int64_t, 8>& corners) const {
    for (int c = 0; c < 8; ++c) {
      corners[c] = node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
      if (corners[c] == kNone) return false;
    }
    return true;
  }
  /// Trilinear between the nodes; `outside` where they are in no block. `slope`, when given, gets the gradient.
  [[nodiscard]] double sample(const std::vector<float>& values, const Vec3d& p, double outside,
                              Vec3d* slope = nullptr) const;

private:
  [[nodiscard]] int blockOf(double x) const {
    constexpr double kMost = 1 << 26; // far beyond any memory
    return static_cast<int>(std::clamp(std::floor(std::floor(x / mVoxelSize) / kSide), -kMost, kMost));
  }
  [[nodiscard]] std::size_t slot(int x, int y, int z) const {
    return (static_cast<std::size_t>(z - mFirst[2]) * mSize[1] + static_cast<std::size_t>(y - mFirst[1])) * mSize[0] +
           static_cast<std::size_t>(x - mFirst[0]);
  }

  double mVoxelSize;
  Vec3i mFirst{0, 0, 0}, mSize{0, 0, 0};
  std::vector<int> mSlot; ///< of each block in the room: -1 none
  std::vector<Vec3i> mBlocks;
};

inline double BlockGrid::sample(const std::vector<float>& values, const Vec3d& p, double outside, Vec3d* slope) const {
  Vec3i low;
  Vec3d t;
  for (int k = 0; k < 3; ++k) {
    const double x = p[k] / mVoxelSize;
    low[k] = static_cast<int>(std::floor(x));
    t[k] = x - low[k];
  }
  std::array<std::int64_t, 8> corners;
  if (!cell(low[0], low[1], low[2], corners)) {
    if (slope) *slope = {0, 0, 0};
    return outside;
  }
  double sum = 0;
  Vec3d gradient{0, 0, 0};
  for (int c = 0; c < 8; ++c) {
    const double v = values[static_cast<std::size_t>(corners[c])];
    const std::array<double, 3> w{c & 1 ? t[0] : 1 - t[0], c >> 1 & 1 ? t[1] : 1 - t[1], c >> 2 ? t[2] : 1 - t[2]};
    sum += v * w[0] * w[1] * w[2];
    gradient[0] += (c & 1 ? v : -v) * w[1] * w[2] / mVoxelSize;
    gradient[1] += (c >> 1 & 1 ? v : -v) * w[0] * w[2] / mVoxelSize;
    gradient[2] += (c >> 2 ? v : -v) * w[0] * w[1] / mVoxelSize;
  }
  if (slope) *slope = gradient;
  return sum;
}

} // namespace volcaustic
