// Closest points on a set of triangles.
#pragma once

#include "mesh/topology.h"
#include "mesh/vector.h"

#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace volcaustic {

struct ClosestPoint {
  static constexpr std::uint32_t kNone = 0xffffffffu;

  double distance = std::numeric_limits<double>::infinity();
  std::uint32_t triangle = kNone; ///< an index into the tree's triangles
  Vec3d point{0, 0, 0};
  [[nodiscard]] bool found() const { return triangle != kNone; }
};

Vec3d closestPointOfTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

/// A tree of boxes over triangles, which may be segments or points. Reads from many threads at once.
class TriangleTree {
public:
  TriangleTree(std::span<const Vec3d> positions, std::vector<TriangleCorners> triangles);

  [[nodiscard]] const std::vector<TriangleCorners>& triangles() const { return mTriangles; }
  [[nodiscard]] const Box& bounds() const { return mNodes[0].box; }
  [[nodiscard]] const Vec3d& corner(std::uint32_t triangle, int k) const { return mPositions[mTriangles[triangle][k]]; }
  /// Twice the area long.
  [[nodiscard]] Vec3d normal(std::uint32_t triangle) const {
    const Vec3d &a = corner(triangle, 0), &b = corner(triangle, 1), &c = corner(triangle, 2);
    return cross(difference(b, a), difference(c, a));
  }

  /// The closest point nearer than `within`, or none. `hint`, a triangle that is likely to be near, saves time.
  [[nodiscard]] ClosestPoint closest(const Vec3d& p, double within = std::numeric_limits<double>::infinity(),
                                     std::uint32_t hint = ClosestPoint::kNone) const {
    return closestIf(p, within, hint, [](std::uint32_t, const Vec3d&) { return true; });
  }
  /// The same of those points that `accept(triangle, point)` holds for. It is asked of the closest point of each
  /// triangle, so a triangle that is accepted in part is missed where its closest point is not.
  template <class Accept>
  [[nodiscard]] ClosestPoint closestIf(const Vec3d& p, double within, std::uint32_t hint, Accept accept) const;

private:
  struct Node {
    Box box;
    std::uint32_t first, count; ///< of mOrder; an inner node has count 0 and its second child at `first`
  };
  static constexpr std::uint32_t kLeaf = 4;

  void build(std::uint32_t begin, std::uint32_t end, const std::vector<Vec3d>& centres);
  [[nodiscard]] static double squaredDistance(const Box& box, const Vec3d& p);

  std::span<const Vec3d> mPositions;
  std::vector<TriangleCorners> mTriangles;
  std::vector<std::uint32_t> mOrder;
  std::vector<Node> mNodes;
};

inline double TriangleTree::squaredDistance(const Box& box, const Vec3d& p) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double outside = std::max({box.min[k] - p[k], p[k] - box.max[k], 0.0});
    sum += outside * outside;
  }
  return sum;
}

template <class Accept>
ClosestPoint TriangleTree::closestIf(const Vec3d& p, double within, std::uint32_t hint, Accept accept) const {
  ClosestPoint best;
  double limit = within * within;
  const auto test = [&](std::uint32_t triangle) {
    const Vec3d point = closestPointOfTriangle(p, corner(triangle, 0), corner(triangle, 1), corner(triangle, 2));
    const Vec3d d = difference(p, point);
    const double squared = dot(d, d);
    // Of equally close triangles the first one, so that no hint changes the answer.
    const bool nearer = squared < limit || (squared == limit && best.found() && triangle < best.triangle);
    if (!nearer || !accept(triangle, point)) return;
    limit = squared;
    best = {std::sqrt(squared), triangle, point};
  };
  if (hint != ClosestPoint::kNone) test(hint);
  std::array<std::uint32_t, 64> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t index = stack[--depth];
    const Node& node = mNodes[index];
    if (squaredDistance(node.box, p) > limit) continue;
    if (node.count > 0) {
      for (std::uint32_t i = 0; i < node.count; ++i) test(mOrder[node.first + i]);
      continue;
    }
    const std::uint32_t left = index + 1, right = node.first;
    const bool leftFirst = squaredDistance(mNodes[left].box, p) <= squaredDistance(mNodes[right].box, p);
    stack[depth++] = leftFirst ? right : left;
    stack[depth++] = leftFirst ? left : right;
  }
  return best;
}

} // namespace volcaustic
