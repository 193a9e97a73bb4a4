// Smooth functions on cubes of sub-voxels, kept as values at 5 x 5 x 5 Chebyshev points.
#pragma once

#include "volume/solid_angle.h"

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
  /// All nodes, as Values are ordered, seen from the low corner.
  [[nodiscard]] const PointSums& nodes() const { return mNodes; }
  /// Functions whose singularities are kFarClearance half edges away need 3 x 3 x 3 points for the same.
  static constexpr int kFarNodes = 3;
  static constexpr double kFarClearance = 10;
  [[nodiscard]] const PointSums& farNodes() const { return mFarNodes; }
  /// At the nodes, from sums at farNodes().
  static Values fromFarNodes(const PointSums& points);
  /// At every sample (SubLattice::sample) of the cube, in row order.
  void atSamples(const Values& values, std::vector<double>& samples) const;
  /// What is within `change` of `middle` all over the cube.
  struct Range {
    double middle, change;
  };
  /// Of the interpolation: the sizes of its Chebyshev coefficients add up to no less. Close for what is nearly linear.
  static Range range(const Values& values);
  /// At the nodes of one of the eight octants; bits of `octant`: x, y, z from the highest.
  static Values atOctant(const Values& values, int octant);

private:
  int mSize, mSub;
  PointSums mNodes, mFarNodes;
  std::vector<double> mAcross; // weights of the nodes for position i + (phase + 1/2)/s: [i][phase][node]
  std::vector<double> mAlong;  // for k + (phase + 1/2)/s^2: [phase][node][k]
};

} // namespace volcaustic
