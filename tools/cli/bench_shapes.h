// Smooth closed bodies in closed form, with as many triangles as a scene asks for. Outward-facing, about the origin.
#pragma once

#include <volcaustic/mesh.h>

namespace volcaustic::cli {

/// An ellipsoid whose radius swells and shrinks around its z axis.
struct LobedBody {
  Vec3d semiAxes{1, 1, 1};
  int lobes = 0;    ///< around the z axis
  double depth = 0; ///< of the lobes, as a part of the radius
  double twist = 0; ///< radians that the lobes turn from one pole to the other
};
/// \param columns, rings patches around and along the z axis: 2*columns*(rings - 1) triangles.
Mesh lobedBody(const LobedBody& shape, int columns, int rings);

/// A round tube along the curve that runs `p` times around the axis of a torus and `q` times through its hole; (1, 0)
/// is the torus itself, (2, 3) a trefoil. p and q have no common divisor.
struct TorusKnot {
  int p = 1, q = 0;
  double majorRadius = 1, minorRadius = 0; ///< of the torus that the curve lies on
  double tubeRadius = 0.25;
};
/// \param segments, sides patches along and around the tube: 2*segments*sides triangles.
Mesh torusKnot(const TorusKnot& shape, int segments, int sides);

} // namespace volcaustic::cli
