// Solid angles of triangles and of distant groups of them, at many points at once.
#pragma once

#include "volcaustic/types.h"

#include <array>
#include <vector>

namespace volcaustic {

/// Points, and a winding number added up at each. They lie in lanes, the last block filled up with copies.
class PointSums {
public:
  static constexpr int kLanes = 16;
  struct Block {
    alignas(64) std::array<double, kLanes> x, y, z, sum;
  };

  void clear() {
    mBlocks.clear();
    mSize = 0;
  }
  void add(const Vec3d& p);
  /// Becomes the points of a pattern, moved, with sums of 0.
  void place(const PointSums& pattern, const Vec3d& by);
  void resetSums() {
    for (Block& b : mBlocks) b.sum.fill(0);
  }
  [[nodiscard]] int size() const { return mSize; }
  [[nodiscard]] double sum(int i) const { return mBlocks[i / kLanes].sum[i % kLanes]; }
  /// Adds each sum to a number of its own.
  void addSumsTo(double* numbers) const;
  std::vector<Block>& blocks() { return mBlocks; }

private:
  std::vector<Block> mBlocks;
  int mSize = 0;
};

/// A figure of N corners that counts `weight` times.
template <int N>
struct Weighted {
  std::array<Vec3d, N> corners;
  double weight;
};
using WeightedTriangle = Weighted<3>;

/// A group of triangles seen from afar: moments of their area vectors A about the centroid c, to second order (Barill,
/// Dickson, Schmidt, Levin, Jacobson, "Fast winding numbers for soups and clouds", ACM TOG 37(4), 2018).
struct AreaMoments {
  Vec3d centroid, areaVector;
  std::array<double, 6> first; ///< A (y - c), symmetric part: xx, yy, zz, xy, xz, yz
  double radius;               ///< of the triangles about the centroid
};

/// Adds to every point's sum the triangle's solid angle over 4 pi, by Van Oosterom and Strackee, "The solid angle of a
/// plane triangle", IEEE Trans. Biomed. Eng. 30(2), 1983: positive where the triangle is seen from behind.
void addTriangle(const WeightedTriangle& triangle, PointSums& points);

/// The same of a group. \pre the points are some radii away
void addGroup(const AreaMoments& group, PointSums& points);

} // namespace volcaustic
