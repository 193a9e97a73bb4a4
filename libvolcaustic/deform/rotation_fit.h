// The rotation that maps one set of vectors onto another best.
#pragma once

#include <Eigen/Core>

namespace volcaustic {

/// The proper rotation R that makes trace(R * covariance) greatest, where `covariance` is the sum of
/// weight * before * after^T: of all rotations, R * before is closest to `after` (least squares; Horn 1987). One of
/// those where several are equally good, the identity for a covariance of zero, always the same for the same bits.
/// \param bound at least the greatest trace, as the root of (sum of weight * before^2) * (sum of weight * after^2),
/// which is near where vectors kept their lengths: the nearer, the faster
Eigen::Matrix3d fittedRotation(const Eigen::Matrix3d& covariance, double bound);

/// The same with the bound that every matrix has.
inline Eigen::Matrix3d fittedRotation(const Eigen::Matrix3d& covariance) {
  return fittedRotation(covariance, 1.7320508075688773 * covariance.norm());
}

} // namespace volcaustic
