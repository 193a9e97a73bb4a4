// Signs of determinants of points, exact for doubles.
#pragma once

#include "volcaustic/types.h"

namespace volcaustic {

/// Sign of det(a - d, b - d, c - d): on which side of the plane through a, b and c the point d lies; 0 on it. Exact as
/// long as no product of three differences leaves the range of doubles or falls below it: for points whose coordinates
/// are at most 1e100 and, where not zero, differ by at least 1e-60.
int orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

/// The same in the plane of two coordinates: whether a, b and c turn left (1), right (-1) or lie on a line (0).
int turn(const Vec3d& a, const Vec3d& b, const Vec3d& c, int u, int v);

} // namespace volcaustic
