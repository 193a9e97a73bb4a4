// Where functions change sign between pairs of points.
#pragma once

#include "polygonise/points.h"

#include <vector>

namespace volcaustic {

/// A piece of a line parallel to an axis, with values of different sign at its ends.
struct Bracket {
  Vec3d from;
  int axis;
  double length;
  double valueFrom, valueTo;
};

/// The place of a root on each of them, 0 at its beginning and 1 at its end: where the value is at most `accuracy` of
/// the difference between the ends, or where the piece that holds the root is as short as that.
void findRoots(PointEvaluator& evaluator, const std::vector<Bracket>& brackets, double accuracy,
               std::vector<double>& places);

} // namespace volcaustic
