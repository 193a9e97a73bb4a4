// Rotations as the angles of a Placement.
#pragma once

#include "volcaustic/placement.h"

#include <Eigen/Core>

namespace volcaustic {

/// About x, then y, then z [degrees].
Eigen::Matrix3d rotationMatrix(const Vec3d& degrees);

/// The angles of a rotation that are nearest to those of a moment before: of the two triples within a turn, and all
/// their whole turns. Keys between them do not spin.
Vec3d anglesNear(const Eigen::Matrix3d& rotation, const Vec3d& before);

} // namespace volcaustic
