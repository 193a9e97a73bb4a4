// Whether two triangles share a point that is no vertex or edge of both.
#pragma once

#include "mesh/topology.h"

#include <vector>

namespace volcaustic {

/// True for a triangle of no area: a point or a piece of a line. Exact.
bool isFlat(const TriangleCorners& t, const std::vector<Vec3d>& points);

/// Exact. Corners are numbers of `points`, which are all different; neither triangle is flat.
bool crossEachOther(const TriangleCorners& s, const TriangleCorners& t, const std::vector<Vec3d>& points);

} // namespace volcaustic
