// Where the vertex of a patch of surface in a cell lies: on the surface, and on its edge or corner where it has one.
#pragma once

#include "polygonise/points.h"

#include <span>
#include <vector>

namespace volcaustic {

/// Where the surface crosses an edge of the lattice.
struct Root {
  Vec3d position;
  Tangent tangent; ///< its distance is that of `position`, as small as the search for roots leaves it
};

struct PatchVertex {
  Vec3d cell;                ///< its lowest corner
  std::size_t firstRoot = 0; ///< in the list of all patches' roots, in order around the patch
  std::size_t rootCount = 0;
  Vec3d position{0, 0, 0}; ///< inside the cell
  /// Of an edge or corner at the cell's border, or beyond by no more than a cell; other cells may see the same one.
  Vec3d outside{0, 0, 0};
  Vec3d within{0, 0, 0}; ///< of what of it is in the cell
  bool strays = false;   ///< whether there is such a one; `position` then leaves it aside
};

/// Places the vertices of all patches. \param patchRoots indices of roots, patch after patch
void placeVertices(PointEvaluator& evaluator, double cellSize, std::span<const Root> roots,
                   std::span<const int> patchRoots, std::vector<PatchVertex>& patches);

} // namespace volcaustic
