#include "simulation/euler_angles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace volcaustic {

namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// Turns added until it is nearest.
double nearest(double degrees, double before) { return degrees + 360 * std::round((before - degrees) / 360); }

double distance2(const Vec3d& a, const Vec3d& b) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

} // namespace

Eigen::Matrix3d rotationMatrix(const Vec3d& degrees) {
  const Affine a = affine({.rotate = degrees});
  Eigen::Matrix3d m;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) m(r, c) = a[r][c];
  return m;
}

Vec3d anglesNear(const Eigen::Matrix3d& m, const Vec3d& before) {
  constexpr double kLocked = 1e-5; // cosine of y below which x and z turn about the same axis
  const double cosine = std::hypot(m(2, 1), m(2, 2));
  const double y = std::atan2(-m(2, 0), cosine) / kDegree;
  Vec3d one;
  if (cosine < kLocked) {
    // x stays, z takes the rest: Rz Ry = M Rx^-1.
    const Eigen::Matrix3d rest = m * rotationMatrix({before[0], 0, 0}).transpose();
    one = {before[0], y, std::atan2(-rest(0, 1), rest(1, 1)) / kDegree};
  } else {
    one = {std::atan2(m(2, 1), m(2, 2)) / kDegree, y, std::atan2(m(1, 0), m(0, 0)) / kDegree};
  }
  Vec3d other{one[0] + 180, 180 - one[1], one[2] + 180};
  for (int a = 0; a < 3; ++a) {
    one[a] = nearest(one[a], before[a]);
    other[a] = nearest(other[a], before[a]);
  }
  return cosine < kLocked || distance2(one, before) <= distance2(other, before) ? one : other;
}

} // namespace volcaustic
