// Closed curves of straight lines and circular arcs in a plane, by their signed distance.
#pragma once

#include "shapes/interval.h"
#include "shapes/profile_chain.h"

#include <array>
#include <vector>

namespace volcaustic {

struct Rectangle {
  Vec2d min, max;
};

/// A curve may touch and cross itself: inside is where a straight way out crosses it an odd number of times.
class ProfileCurve {
public:
  /// \param profile as requireValid() takes it
  ProfileCurve(const shapes::Profile& profile, ProfileUse use);

  struct Results {
    double* value;       ///< distance from the curve, positive inside
    double* gradient[2]; ///< null where it is not wanted
  };
  /// At `count` points, kShapeBatch at most; of a revolution with x >= 0. A value is the same to the bit whatever the
  /// other points are. The cost goes by how many lines and arcs may be the nearest ones of these points.
  void evaluate(const double* x, const double* y, int count, const Results& results) const;

  /// Holds every value that evaluate() gives in the rectangle.
  [[nodiscard]] Interval bound(const Rectangle& rectangle) const;

  /// A line, or an arc of half a circle at most. The end `a` is the lower one, of two as high the left one: what is
  /// left and right of the way from a to b is the same then whichever way the curve takes it.
  struct Piece {
    Vec2d a, b;
    Vec2d tangentA, tangentB;
    double chord;      ///< length of it
    double curvature;  ///< positive where the centre is to the left
    bool interiorLeft; ///< of curves that do not cross themselves
    bool surface;      ///< false along the axis of a revolution
  };

private:
  /// Pieces under a node of the tree, in the order of the curve. Its first half follows the node, then the second.
  struct Range {
    std::size_t node, begin, end;
  };
  static Range firstHalf(const Range& r) { return {r.node + 1, r.begin, (r.begin + r.end) / 2}; }
  static Range secondHalf(const Range& r) {
    const std::size_t middle = (r.begin + r.end) / 2;
    return {r.node + 2 * (middle - r.begin), middle, r.end};
  }
  [[nodiscard]] Range all() const { return {0, 0, mPieces.size()}; }

  Rectangle buildTree(const Range& range);
  [[nodiscard]] double nearestSquare(const Range& range, const Vec2d& p, double best) const;
  [[nodiscard]] double reachFrom(const Rectangle& rectangle) const;
  template <class Near, class Right>
  void walk(const Rectangle& rectangle, double reach, const Near& near, const Right& right, const Range& range) const;
  void findGradients(const double* x, const double* y, int count, const double* nearest, const Results& results) const;

  std::vector<Piece> mPieces;
  std::vector<double> mHeights; // of the points between pieces, the first one once more at the end
  std::vector<Rectangle> mTree; // around the pieces under each node
  double mExtent = 0;           // greatest coordinate
};

} // namespace volcaustic
