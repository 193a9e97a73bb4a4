// What keeps the mesh a manifold: an edge of it never has four faces.
//
// The mesh is the dual of the pieces of surface in the cells: a vertex for each patch, an edge for each piece of curve
// in which the surface meets a face between two cells, a face with four corners for each crossed edge of the lattice.
// Pieces of curve and patches make a closed surface, and so does its dual, as long as no two edges join the same two
// vertices. Two patches share two pieces of curve only where both are on the one face between their cells: the face is
// ambiguous, and both its pieces are of one patch on either side. Pairing the four crossings of that face the other way
// cuts the loop of that patch in two in both cells: of two pieces a -> b and c -> d of a loop become a -> d and c -> b.
// It joins no loops, so that no other face becomes such a one. A diagonal of a face joins cells that have only the
// crossed edge in common, and so is no other edge.
#pragma once

#include "polygonise/block.h"

#include <memory>
#include <span>
#include <vector>

namespace volcaustic {

struct BlockFlips {
  std::size_t block;
  std::vector<FlippedFaces> faces; ///< in order of cells
};

/// Faces to pair the other way, block after block. Where one flip makes another needless, the first in space comes
/// first.
std::vector<BlockFlips> pinchedFaces(std::span<const SurfaceBlock> blocks,
                                     std::span<const std::shared_ptr<const BlockSurface>> surfaces);

} // namespace volcaustic
