// Triangles of a block: how far from the surface they are, and whose surface they are.
#pragma once

#include "polygonise/faces.h"

namespace volcaustic {

struct BlockMeasure {
  std::uint64_t key = 0;            ///< of the faces and part names that it is of; 0: of none
  double deviation = 0;             ///< world: greatest distance found between triangles and surface
  std::vector<std::uint32_t> parts; ///< of the triangles; empty where there is one part only
};

/// Writes a block's triangles, two for each face from `out` on, and measures them unless `measure` is of them already.
/// \param partsKey of the names of parts; 0 where there is one part only
/// \return points at which the shape was evaluated
std::uint64_t triangulateBlock(const QuadMesh& mesh, std::size_t block, std::uint64_t partsKey, ShapeScratch& scratch,
                               std::array<std::uint32_t, 3>* out, BlockMeasure& measure);

} // namespace volcaustic
