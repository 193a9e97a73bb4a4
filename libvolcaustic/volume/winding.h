// Winding numbers of meshes that do not close (Jacobson, Kavan, Sorkine-Hornung, "Robust inside-outside segmentation
// using generalized winding numbers", ACM TOG 32(4), 2013).
//
// The directed edges on which the faces of a mesh do not cancel form closed loops. Capping each loop makes the mesh
// closed, and winding numbers add: w(mesh) = w(mesh with caps) - w(caps). The first term is a whole number that rows of
// signed crossings give exactly; the second is smooth away from the caps and small away from the holes. So a sample is
// inside, |w| >= 1/2, exactly where the whole number differs from w(caps) rounded to the nearest one.
#pragma once

#include "volcaustic/mesh.h"
#include "volcaustic/run_context.h"
#include "volcaustic/types.h"

#include <array>
#include <cstdint>
#include <vector>

namespace volcaustic {

/// A directed edge of the boundary of a mesh, as a chain: one entry for each face that no face on the other side
/// cancels.
struct BoundaryEdge {
  std::uint32_t from, to;
};

/// The boundary chain; vertices of equal position count as one. Empty when winding numbers are whole everywhere.
/// \pre every triangle's indices are in range
std::vector<BoundaryEdge> boundaryChain(const Mesh& mesh, const RunContext& ctx = {});

/// Triangles that close a mesh, and the edges along which they meet it.
struct LoopCaps {
  std::vector<Vec3d> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::array<std::uint32_t, 2>> edges;
};

/// Caps each simple loop of the chain. A loop is halved again and again, so that caps are small where they meet the
/// mesh and only few are large. Mesh and caps together are closed.
LoopCaps capLoops(const Mesh& mesh, const std::vector<BoundaryEdge>& chain);

} // namespace volcaustic
