// The 3x3x3 Gaussian over a brick of three-vectors.
#pragma once

#include "kernels/vec.h"

namespace volcaustic::kernels {

/// A brick's edge, and the same with one voxel around it.
inline constexpr int kSmoothEdge = 8, kSmoothBlock = kSmoothEdge + 2;

/// Three passes of (1, 2, 1)/4, x first. `in` holds 10x10x10 vectors, `out` 8x8x8, z fastest. The passes run over plain
/// rows of numbers, which compilers turn into lanes by themselves; no instruction set changes a bit of the result.
VOLCAUSTIC_HD inline void smoothBrick(const float* in, float* out) {
  constexpr int kRow = 3 * kSmoothBlock, kPlane = kSmoothBlock * kRow, kOut = 3 * kSmoothEdge;
  float afterX[kSmoothEdge * kPlane], afterY[kSmoothEdge * kSmoothEdge * kRow];
  for (int i = 0; i < kSmoothEdge * kPlane; ++i)
    afterX[i] = 0.25f * (in[i] + in[i + 2 * kPlane]) + 0.5f * in[i + kPlane];
  for (int x = 0; x < kSmoothEdge; ++x)
    for (int i = 0; i < kSmoothEdge * kRow; ++i) {
      const float* row = afterX + x * kPlane + i;
      afterY[x * kSmoothEdge * kRow + i] = 0.25f * (row[0] + row[2 * kRow]) + 0.5f * row[kRow];
    }
  for (int row = 0; row < kSmoothEdge * kSmoothEdge; ++row)
    for (int i = 0; i < kOut; ++i) {
      const float* column = afterY + row * kRow + i;
      out[row * kOut + i] = 0.25f * (column[0] + column[6]) + 0.5f * column[3];
    }
}

} // namespace volcaustic::kernels
