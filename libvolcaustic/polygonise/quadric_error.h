// The point nearest to several planes.
#pragma once

#include "volcaustic/types.h"

namespace volcaustic {

/// A sum of squared distances from planes, as a function of the offset from a base point.
class PlaneDistances {
public:
  /// A plane at `distance` from the base point, along its normal of length one.
  void add(const Vec3d& normal, double distance);

  /// The offset of least sum. Directions in which planes tell less than `least` of what they tell in the best one are
  /// left alone, so that edges keep the place along them that the base point has.
  [[nodiscard]] Vec3d minimum(double least) const;

private:
  double mMatrix[3][3] = {};
  Vec3d mRight{0, 0, 0};
};

} // namespace volcaustic
