// Mass, centre and axes of what a closed mesh encloses.
#pragma once

#include "volcaustic/mesh.h"

#include <Eigen/Dense>

namespace volcaustic {

/// Of density 1, in the space of the mesh.
struct MassProperties {
  double mass = 0; ///< volume
  Eigen::Vector3d center{0, 0, 0};
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity(); ///< columns: principal axes, a rotation
  Eigen::Vector3d inertia{0, 0, 0};                   ///< about them, through the centre
};

/// Sums over the tetrahedra between triangles and origin, so that a closed mesh gives exact integrals.
MassProperties massProperties(const Mesh& mesh);

} // namespace volcaustic
