#include "deform/rotation_fit.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace volcaustic {

namespace {

constexpr double kTiny = 1e-150, kHuge = 1e150; // between them numbers have squares

/// Horn's matrix: its eigenvector of the greatest eigenvalue is the rotation as a quaternion (w, x, y, z).
Eigen::Matrix4d quaternionMatrix(const Eigen::Matrix3d& m) {
  Eigen::Matrix4d k;
  k << m(0, 0) + m(1, 1) + m(2, 2), m(1, 2) - m(2, 1), m(2, 0) - m(0, 2), m(0, 1) - m(1, 0), //
      m(1, 2) - m(2, 1), m(0, 0) - m(1, 1) - m(2, 2), m(0, 1) + m(1, 0), m(2, 0) + m(0, 2),  //
      m(2, 0) - m(0, 2), m(0, 1) + m(1, 0), m(1, 1) - m(0, 0) - m(2, 2), m(1, 2) + m(2, 1),  //
      m(0, 1) - m(1, 0), m(2, 0) + m(0, 2), m(1, 2) + m(2, 1), m(2, 2) - m(0, 0) - m(1, 1);
  return k;
}

/// The greatest eigenvalue of the quaternion matrix of `m`, whose squares sum to one, by Newton's method on its
/// characteristic polynomial. From an upper bound it falls to the greatest root and never below.
double greatestEigenvalue(const Eigen::Matrix3d& m, double bound) {
  Eigen::Matrix3d cofactors;
  for (int i = 0; i < 3; ++i) cofactors.row(i) = m.row((i + 1) % 3).cross(m.row((i + 2) % 3));
  const double c1 = -8 * m.row(0).dot(cofactors.row(0)), c0 = 1 - 4 * cofactors.squaredNorm();
  double x = std::min(bound, 1.7320508075688773);
  for (int i = 0; i < 50; ++i) {
    const double value = ((x * x - 2) * x + c1) * x + c0, slope = (4 * x * x - 4) * x + c1;
    if (!(slope > 0) || !(value > 0)) break;
    const double step = value / slope;
    x -= step;
    if (step < 1e-9 * x) break; // squared by the next
  }
  return x;
}

/// Column of the adjugate of a symmetric singular matrix with the largest diagonal: an eigenvector of eigenvalue zero,
/// as long as the others' product.
Eigen::Vector4d nullVector(const Eigen::Matrix4d& a) {
  const double s0 = a(0, 0) * a(1, 1) - a(1, 0) * a(0, 1), s1 = a(0, 0) * a(1, 2) - a(1, 0) * a(0, 2),
               s2 = a(0, 0) * a(1, 3) - a(1, 0) * a(0, 3), s3 = a(0, 1) * a(1, 2) - a(1, 1) * a(0, 2),
               s4 = a(0, 1) * a(1, 3) - a(1, 1) * a(0, 3), c5 = a(2, 2) * a(3, 3) - a(3, 2) * a(2, 3),
               c4 = a(2, 1) * a(3, 3) - a(3, 1) * a(2, 3), c3 = a(2, 1) * a(3, 2) - a(3, 1) * a(2, 2),
               c2 = a(2, 0) * a(3, 3) - a(3, 0) * a(2, 3), c1 = a(2, 0) * a(3, 2) - a(3, 0) * a(2, 2),
               c0 = a(2, 0) * a(3, 1) - a(3, 0) * a(2, 1);
  const double d0 = a(1, 1) * c5 - a(1, 2) * c4 + a(1, 3) * c3, d1 = a(0, 0) * c5 - a(0, 2) * c2 + a(0, 3) * c1,
               d2 = a(3, 0) * s4 - a(3, 1) * s2 + a(3, 3) * s0, d3 = a(2, 0) * s3 - a(2, 1) * s1 + a(2, 2) * s0;
  const double d01 = -a(1, 0) * c5 + a(1, 2) * c2 - a(1, 3) * c1, d02 = a(1, 0) * c4 - a(1, 1) * c2 + a(1, 3) * c0,
               d03 = -a(1, 0) * c3 + a(1, 1) * c1 - a(1, 2) * c0, d12 = -a(0, 0) * c4 + a(0, 1) * c2 - a(0, 3) * c0,
               d13 = a(0, 0) * c3 - a(0, 1) * c1 + a(0, 2) * c0, d23 = -a(3, 0) * s3 + a(3, 1) * s1 - a(3, 2) * s0;
  const double largest = std::max({std::abs(d0), std::abs(d1), std::abs(d2), std::abs(d3)});
  if (std::abs(d0) == largest) return {d0, d01, d02, d03};
  if (std::abs(d1) == largest) return {d01, d1, d12, d13};
  if (std::abs(d2) == largest) return {d02, d12, d2, d23};
  return {d03, d13, d23, d3};
}

} // namespace

Eigen::Matrix3d fittedRotation(const Eigen::Matrix3d& covariance, double bound) {
  const double norm = covariance.norm();
  if (!(norm > kTiny && norm < kHuge)) { // squares of very small or large numbers are none
    const double largest = covariance.cwiseAbs().maxCoeff();
    if (!(largest > 0) || !std::isfinite(largest)) return Eigen::Matrix3d::Identity();
    return fittedRotation(covariance / largest, kHuge);
  }
  const Eigen::Matrix3d m = covariance * (1 / norm);
  const Eigen::Matrix4d k = quaternionMatrix(m);
  const double eigenvalue = greatestEigenvalue(m, bound * (1 / norm));
  Eigen::Vector4d q = nullVector(k - eigenvalue * Eigen::Matrix4d::Identity());
  constexpr double kSafe = 1e-5; // below, the greatest eigenvalue is nearly a double one and the adjugate mostly noise
  if (!(q.norm() > kSafe)) q = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(k).eigenvectors().col(3);
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

} // namespace volcaustic
