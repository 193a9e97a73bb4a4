// The voxels of a brick and of its surroundings as one dense block, for filters.
#pragma once

#include "core/brick_grid.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <type_traits>
#include <vector>

namespace volcaustic {

/// A brick, `Low` voxels before it and `High` after it along each axis. Rows run along z and are padded to whole SIMD
/// registers; the padding holds finite numbers of no meaning.
template <class T, int Low, int High>
class BrickBlock {
  static_assert(Low <= kBrickSize && High <= kBrickSize);

public:
  static constexpr int kEdge = kBrickSize + Low + High;
  static constexpr int kRow = (kEdge + 7) / 8 * 8; ///< voxels from row to row
  static constexpr int kPlane = kEdge * kRow;

  BrickBlock() : mVoxels(std::size_t{kEdge} * kPlane + kRow) {}

  /// Whether all that is gathered for a brick is in the domain.
  static bool isInside(const BrickGrid<T>& grid, const Vec3i& brick) {
    bool inside = true;
    for (int a = 0; a < 3; ++a)
      inside = inside && brick[a] * kBrickSize >= Low && (brick[a] + 1) * kBrickSize + High <= grid.dims()[a];
    return inside;
  }

  /// Beyond the domain stands its nearest voxel.
  void gather(const BrickGrid<T>& grid, const Vec3i& brick) {
    if (isInside(grid, brick))
      gatherInside(grid, brick);
    else
      gatherAtFace(brick, [&](const Vec3i& v) { return grid.clamped(v[0], v[1], v[2]); });
  }
  /// Beyond the domain the field goes on as it came: odd reflection about the voxel at the face.
  void gatherExtended(const BrickGrid<T>& grid, const Vec3i& brick) requires std::is_arithmetic_v<T> {
    if (isInside(grid, brick))
      gatherInside(grid, brick);
    else
      gatherAtFace(brick, [&](const Vec3i& v) { return extended(grid, v); });
  }

  /// Whether all voxels are equal.
  [[nodiscard]] bool uniform() const {
    for (int row = 0; row < kEdge * kEdge; ++row)
      if (const T* p = &mVoxels[std::size_t(row) * kRow];
          std::any_of(p, p + kEdge, [&](const T& v) { return v != mVoxels[0]; }))
        return false;
    return true;
  }

  /// The first voxel, which is (-Low, -Low, -Low) relative to the brick.
  [[nodiscard]] const T* data() const { return mVoxels.data(); }
  /// Place of a voxel of the brick's coordinates.
  static constexpr int place(int x, int y, int z) { return (x + Low) * kPlane + (y + Low) * kRow + z + Low; }

private:
  /// Where a neighbour's rows lie: its voxels, or one row of its constant for all.
  struct Source {
    const T* rows;
    int scale;
    const T* row(int x, int y) const { return rows + scale * brickOffset(x, y, 0); }
  };

  void gatherInside(const BrickGrid<T>& grid, const Vec3i& brick) {
    std::array<std::array<T, kBrickSize>, 27> constants;
    std::array<Source, 27> sources;
    for (int i = 0; i < 27; ++i) {
      const std::int64_t b = grid.brickIndex(neighbour(grid, brick, i));
      if (grid.isConstant(b)) constants[i].fill(grid.constant(b));
      sources[i] = grid.isConstant(b) ? Source{constants[i].data(), 0} : Source{grid.voxels(b).data(), 1};
    }
    T* out = mVoxels.data();
    for (int x = -Low; x < kBrickSize + High; ++x)
      for (int y = -Low; y < kBrickSize + High; ++y, out += kRow) {
        const Source* source = &sources[((x + kBrickSize) >> kBrickLog2) * 9 + ((y + kBrickSize) >> kBrickLog2) * 3];
        if constexpr (Low > 0) std::memcpy(out, source[0].row(x, y) + kBrickSize - Low, Low * sizeof(T));
        std::memcpy(out + Low, source[1].row(x, y), kBrickSize * sizeof(T));
        if constexpr (High > 0) std::memcpy(out + Low + kBrickSize, source[2].row(x, y), High * sizeof(T));
      }
  }
  /// Number `i` of the 27 around a brick; where the domain has none, and no voxel of it is asked for, the nearest.
  static Vec3i neighbour(const BrickGrid<T>& grid, const Vec3i& brick, int i) {
    Vec3i n{brick[0] + i / 9 - 1, brick[1] + i / 3 % 3 - 1, brick[2] + i % 3 - 1};
    for (int a = 0; a < 3; ++a) n[a] = std::clamp(n[a], 0, grid.brickDims()[a] - 1);
    return n;
  }

  template <class At>
  void gatherAtFace(const Vec3i& brick, const At& at) {
    T* out = mVoxels.data();
    for (int x = -Low; x < kBrickSize + High; ++x)
      for (int y = -Low; y < kBrickSize + High; ++y, out += kRow)
        for (int z = -Low; z < kBrickSize + High; ++z)
          out[z + Low] = at({brick[0] * kBrickSize + x, brick[1] * kBrickSize + y, brick[2] * kBrickSize + z});
  }
  static T extended(const BrickGrid<T>& grid, const Vec3i& v) {
    Vec3i face;
    for (int a = 0; a < 3; ++a) face[a] = std::clamp(v[a], 0, grid.dims()[a] - 1);
    const T value = grid.at(face[0], face[1], face[2]);
    return face == v ? value : 2 * value - grid.clamped(2 * face[0] - v[0], 2 * face[1] - v[1], 2 * face[2] - v[2]);
  }

  std::vector<T> mVoxels;
};

} // namespace volcaustic
