// From the sums of a block of voxels to its light: the 3x3x3 Gaussian, and sixteen bytes a voxel.
#pragma once

#include "kernels/fluence.h"

namespace volcaustic::kernels {

/// What a voxel's sums hold beyond their array.
struct CarriedSums {
  std::int32_t voxel;
  float sums[8];
};

/// Sums of a cube of voxels and of one voxel around it, eight numbers each: fluence RGB, 0, direction sum, 0; z
/// fastest.
template <class T>
struct LightSums {
  const T* sums;
  const CarriedSums* carried = nullptr; ///< by voxel
  std::int32_t carriedCount = 0;
  /// Voxels [from, to) along each axis are inside the domain. Beyond its faces stand the values before them, so the
  /// Gaussian keeps the total.
  std::int32_t from[3], to[3];
  float unit = 1; ///< of the sums
  bool smooth = true;
};

/// Three passes of (1, 2, 1)/4, z first; calls emit(x, y, z, v) with the 8x8 numbers v of eight voxels from (x, y, z)
/// of the cube on. Plain loops over rows, which compilers turn into lanes by themselves; only sums and products in a
/// fixed order, so that no instruction set changes a bit.
template <int kEdge, class T, class Emit>
VOLCAUSTIC_HD inline void finishLight(const LightSums<T>& in, const Emit& emit) {
  constexpr int kPadded = kEdge + 2, kRow = 8 * kEdge;
  const float side = in.smooth ? 1 : 0, middle = in.smooth ? 2 : 1, scale = in.smooth ? in.unit / 64 : in.unit;
  float line[8 * kPadded], rows[kPadded][kRow], slices[3][kEdge][kRow];
  std::int32_t carried = 0;

  const auto sumAlongZ = [&](std::int32_t row, float* out) __attribute__((always_inline)) {
    const T* sums = in.sums + std::int64_t{row} * (8 * kPadded);
    for (int i = 0; i < 8 * kPadded; ++i) line[i] = static_cast<float>(sums[i]);
    for (; carried < in.carriedCount && in.carried[carried].voxel < (row + 1) * kPadded; ++carried)
      if (const std::int32_t z = in.carried[carried].voxel - row * kPadded; z >= 0)
        for (int i = 0; i < 8; ++i) line[8 * z + i] += in.carried[carried].sums[i];
    for (int i = 0; i < 8; ++i) {
      if (in.from[2] > 0) line[8 * (in.from[2] - 1) + i] = line[8 * in.from[2] + i];
      if (in.to[2] < kPadded) line[8 * in.to[2] + i] = line[8 * (in.to[2] - 1) + i];
    }
    for (int i = 0; i < kRow; ++i) out[i] = side * (line[i] + line[i + 16]) + middle * line[i + 8];
    for (int i = 8 * (in.to[2] - 1); i < kRow; ++i) out[i] = 0;
  };
  const auto emitSlice = [&](std::int32_t x) __attribute__((always_inline)) {
    const auto& a = slices[larger(x - 1, in.from[0]) % 3];
    const auto& b = slices[x % 3];
    const auto& c = slices[smaller(x + 1, in.to[0] - 1) % 3];
    for (std::int32_t y = larger(in.from[1], 1); y < smaller(in.to[1], kEdge + 1); ++y)
      for (std::int32_t z = 0; z < kEdge && z + 1 < in.to[2]; z += 8) {
        alignas(64) float v[64];
        for (int i = 0; i < 64; ++i) {
          const int at = 8 * z + i;
          v[i] = (side * (a[y - 1][at] + c[y - 1][at]) + middle * b[y - 1][at]) * scale;
        }
        emit(x - 1, y - 1, z, v);
      }
  };

  for (std::int32_t x = in.from[0]; x < in.to[0]; ++x) {
    for (std::int32_t y = in.from[1]; y < in.to[1]; ++y) sumAlongZ(x * kPadded + y, rows[y]);
    for (std::int32_t y = larger(in.from[1], 1); y < smaller(in.to[1], kEdge + 1); ++y) {
      const float* a = rows[larger(y - 1, in.from[1])];
      const float* c = rows[smaller(y + 1, in.to[1] - 1)];
      for (int i = 0; i < kRow; ++i) slices[x % 3][y - 1][i] = side * (a[i] + c[i]) + middle * rows[y][i];
    }
    if (x > larger(in.from[0], 1)) emitSlice(x - 1);
    if (x == in.to[0] - 1 && x <= kEdge) emitSlice(x);
  }
}

/// The same into bricks of 8x8x8 voxels, z fastest: eight numbers of eight voxels go to packVoxels(numbers, to), which
/// says whether there is light in them. Returns which bricks have light, a bit each. Voxels outside the domain are dark
/// or left as they are.
template <int kEdge, class T, class Pack>
VOLCAUSTIC_HD inline std::uint64_t finishBricks(const LightSums<T>& sums, FluenceVoxel* const* bricks,
                                                const Pack& packVoxels) {
  std::uint64_t lit = 0;
  finishLight<kEdge>(
      sums, [&](std::int32_t x, std::int32_t y, std::int32_t z, const float* v) __attribute__((always_inline)) {
        const std::int32_t brick = ((x >> 3) * (kEdge / 8) + (y >> 3)) * (kEdge / 8) + (z >> 3);
        const bool any = packVoxels(v, bricks[brick] + FlatMedium::voxelOffset(Int3(x, y, z)));
        lit |= static_cast<std::uint64_t>(any) << brick;
      });
  return lit;
}

} // namespace volcaustic::kernels
