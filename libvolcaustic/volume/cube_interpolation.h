// Smooth functions on cubes of sub-voxels, kept as values at 5 x 5 x 5 Chebyshev points.
#pragma once

#include "volcaustic/types.h"

#include <array>
#include <vector>

namespace volcaustic {

/// For cubes of n^3 sub-voxels, n a multiple of the sub-voxels along a voxel's edge. A function whose singularities are
/// kClearance half edges from the centre is met within 3e-4 of its range.
class CubeInterpolation {
public:
  static constexpr int kNodes = 5;
  static constexpr double kClearance = 3.2;
  /// x slowest.
  using Values = std::array<double, kNodes * kNodes * kNodes>;
  static constexpr int kMiddle = kNodes * kNodes * kNodes / 2;

  CubeInterpolation(int n, int log2Sub);

  [[nodiscard]] int size() const { return mSize; }
  /// Of the nodes along an edge, from the cube's low corner, in sub-voxels.
  [[nodiscard]] double node(int i) const;
  /// At every sample (SubLattice::sample) of the cube, in row order.
  void atSamples(const Values& values, std::vector<double>& samples) const;
  /// At the nodes of one of the eight octants; bits of `octant`: x, y, z from the highest.
  static Values atOctant(const Values& values, int octant);

private:
  int mSize, mSub;
  std::vector<double> mAcross; // weights of the nodes for position i + (phase + 1/2)/s: [i][phase][node]
  std::vector<double> mAlong;  // for k + (phase + 1/2)/s^2: [phase][node][k]
};

} // namespace volcaustic
