// The surface between the nodes of a level set.
#pragma once

#include "mesh/topology.h"
#include "volume/topology_blocks.h"

#include <functional>

namespace volcaustic {

struct Contour {
  std::vector<Vec3d> positions;
  std::vector<Vec3i> cells; ///< the lowest node of each position's cell
  std::vector<TriangleCorners> triangles;
};

/// Dual marching cubes (Nielson 2004) of the cells that `wanted` holds for: one vertex for each sheet of the surface in
/// a cell, one quadrangle for each edge of the lattice that passes it, so every edge has two faces, or one at the end
/// of the cells. Negative values are inside.
Contour contourOf(const BlockGrid& grid, const std::vector<float>& values,
                  const std::function<bool(const std::array<std::int64_t, 8>& corners)>& wanted, const RunContext& ctx);

} // namespace volcaustic
