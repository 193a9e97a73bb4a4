// The medium in the making as kernels see it: bricks of 8x8x8 voxels in the order of core/brick_grid.h, on any machine.
//
// A kernel body is written once. Its operator() does the work of one element, or of one block of threads: then it says
// what is to be done for each of `count` places with block.forEach(), which ends in a barrier, and may ask with
// block.any() whether a predicate holds at one of them. SerialBlock does the same with one thread.
#pragma once

#include "kernels/vec.h"

namespace volcaustic::kernels {

inline constexpr int kBrickEdge = 8, kVoxelsOfBrick = kBrickEdge * kBrickEdge * kBrickEdge;

struct SerialBlock {
  template <class Body>
  void forEach(int count, const Body& body) {
    for (int i = 0; i < count; ++i) body(i);
  }
  template <class Predicate>
  bool any(int count, const Predicate& predicate) {
    for (int i = 0; i < count; ++i)
      if (predicate(i)) return true;
    return false;
  }
};

/// Adds to a counter that several threads share; of whole numbers, so that their order does not matter.
VOLCAUSTIC_HD inline void addShared(std::uint32_t* counter, std::uint32_t n) {
#ifdef __CUDA_ARCH__
  atomicAdd(counter, n);
#else
  *counter += n;
#endif
}
/// Lowers a number that several threads share.
VOLCAUSTIC_HD inline void lowerShared(std::uint32_t* number, std::uint32_t to) {
#ifdef __CUDA_ARCH__
  atomicMin(number, to);
#else
  *number = smaller(*number, to);
#endif
}

/// Sets elements to one value.
template <class T>
struct SetAll {
  T* elements;
  T value;
  VOLCAUSTIC_HD void operator()(std::int64_t i) const { elements[i] = value; }
};

/// The bricks of a domain, z fastest.
struct BrickLayout {
  Int3 dims;   ///< voxels
  Int3 bricks; ///< of which the last along an axis may reach beyond the domain

  VOLCAUSTIC_HD std::int64_t count() const { return std::int64_t{bricks.x} * bricks.y * bricks.z; }
  VOLCAUSTIC_HD std::int64_t index(const Int3& b) const {
    return (std::int64_t{b.x} * bricks.y + b.y) * bricks.z + b.z;
  }
  VOLCAUSTIC_HD Int3 coord(std::int64_t b) const {
    const std::int64_t row = b / bricks.z;
    return {static_cast<std::int32_t>(row / bricks.y), static_cast<std::int32_t>(row % bricks.y),
            static_cast<std::int32_t>(b % bricks.z)};
  }
  VOLCAUSTIC_HD static Int3 voxelOf(int offset) { return {offset >> 6, offset >> 3 & 7, offset & 7}; }
  VOLCAUSTIC_HD static int offsetOf(const Int3& v) { return (v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7); }
  VOLCAUSTIC_HD Int3 clamped(const Int3& v) const {
    return {clampTo(v.x, 0, dims.x - 1), clampTo(v.y, 0, dims.y - 1), clampTo(v.z, 0, dims.z - 1)};
  }
  /// Whether visit(brick) is true for the brick itself or one of its up to 26 neighbours.
  template <class Visit>
  VOLCAUSTIC_HD bool anyAround(std::int64_t b, const Visit& visit) const {
    const Int3 c = coord(b);
    for (int x = larger(c.x - 1, 0); x <= smaller(c.x + 1, bricks.x - 1); ++x)
      for (int y = larger(c.y - 1, 0); y <= smaller(c.y + 1, bricks.y - 1); ++y)
        for (int z = larger(c.z - 1, 0); z <= smaller(c.z + 1, bricks.z - 1); ++z)
          if (visit(index({x, y, z}))) return true;
    return false;
  }
};

VOLCAUSTIC_HD inline bool differ(float a, float b) { return a != b; }
VOLCAUSTIC_HD inline bool differ(const Float3& a, const Float3& b) { return a.x != b.x || a.y != b.y || a.z != b.z; }

// A *grid* below has `layout`, `ambient`, isConstant(brick), constant(brick), and voxel(brick, offset).

/// Whether the brick is not the ambient value all over.
template <class Grid>
VOLCAUSTIC_HD bool occupied(const Grid& grid, std::int64_t b) {
  return !grid.isConstant(b) || differ(grid.constant(b), grid.ambient);
}
/// Whether the brick and its neighbours are constant and of one value.
template <class Grid>
VOLCAUSTIC_HD bool uniformAround(const Grid& grid, std::int64_t b) {
  if (!grid.isConstant(b)) return false;
  const auto value = grid.constant(b);
  return !grid.layout.anyAround(
      b, [&](std::int64_t other) { return !grid.isConstant(other) || differ(grid.constant(other), value); });
}
/// The value at a voxel; beyond the domain stands its nearest one.
template <class Grid>
VOLCAUSTIC_HD auto clampedAt(const Grid& grid, const Int3& v) {
  const Int3 c = grid.layout.clamped(v);
  const std::int64_t b = grid.layout.index({c.x >> 3, c.y >> 3, c.z >> 3});
  return grid.isConstant(b) ? grid.constant(b) : grid.voxel(b, BrickLayout::offsetOf(c));
}
/// Beyond the domain the field goes on as it came: odd reflection about the voxel at the face.
template <class Grid>
VOLCAUSTIC_HD float extendedAt(const Grid& grid, const Int3& v) {
  const Int3 face = grid.layout.clamped(v);
  const float value = clampedAt(grid, face);
  if (face.x == v.x && face.y == v.y && face.z == v.z) return value;
  return 2 * value - clampedAt(grid, {2 * face.x - v.x, 2 * face.y - v.y, 2 * face.z - v.z});
}

/// A grid of the smoothed index.
struct IndexGrid {
  BrickLayout layout;
  float ambient;
  const std::int32_t* slots; ///< 0: constant; s: voxels of s - 1
  const float* constants;    ///< of every brick that is constant
  const float* voxels;

  VOLCAUSTIC_HD bool isConstant(std::int64_t b) const { return slots[b] == 0; }
  VOLCAUSTIC_HD float constant(std::int64_t b) const { return constants[b]; }
  VOLCAUSTIC_HD float voxel(std::int64_t b, int offset) const {
    return voxels[(std::int64_t{slots[b]} - 1) * kVoxelsOfBrick + offset];
  }
};

} // namespace volcaustic::kernels
