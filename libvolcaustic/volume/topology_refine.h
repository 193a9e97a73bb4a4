// Divides large triangles near a change, so that a cut along a curved line fits them.
#pragma once

#include "volume/topology_parts.h"

namespace volcaustic {

struct RefinedTriangles {
  std::vector<TriangleCorners> triangles;
  std::vector<std::uint32_t> source; ///< of each: the triangle of the surface that it is a piece of
  std::vector<bool> whole;           ///< of each: it is all of that triangle
};

/// Divides edges longer than `longest` of triangles near the blocks where `level` is below `near`, again and again.
/// Middles of edges are appended to `positions`; both triangles at an edge are divided, so nothing opens.
RefinedTriangles refinedNear(const WeldedSurface& surface, const std::vector<std::uint32_t>& faces,
                             const BlockGrid& grid, const std::vector<float>& level, double near, double longest,
                             std::vector<Vec3d>& positions);

} // namespace volcaustic
