// Vertices of edges and corners that lie just outside the cell that saw them.
#pragma once

#include "polygonise/faces.h"

namespace volcaustic {

/// Moves each vertex that belongs at an edge outside its cell there, if its triangles come nearer to the surface, none
/// of them turns over, and no other vertex is there; out of another's way, if it does no harm. One after the other, in
/// the order of blocks.
/// \return points at which the shape was evaluated
std::uint64_t moveStrays(QuadMesh& mesh, const RunContext& ctx);

} // namespace volcaustic
