// How the faces of a mesh hang together once vertices of equal position are one.
#pragma once

#include "volcaustic/mesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace volcaustic {

using TriangleCorners = std::array<std::uint32_t, 3>;

struct WeldedMesh {
  std::vector<TriangleCorners> triangles; ///< those of the mesh, over welded vertices
  std::uint32_t vertexCount = 0;
};
WeldedMesh weld(const Mesh& mesh);

/// Such a face has no part in edges, patches and shells.
inline bool hasRepeatedCorner(const TriangleCorners& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// The shells of a mesh, numbered by their first face.
struct FaceShells {
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::vector<std::uint32_t> shellOf; ///< of each face; kNone where a corner is repeated
  std::uint32_t count = 0;
  bool mayHaveDuplicates = false; ///< false: no two faces have the same three corners
  /// One face of each open and of each inconsistent edge.
  std::vector<std::uint32_t> openEdgeFaces, inconsistentEdgeFaces;
};

/// Finds the shells, and fills in what the report says of edges, orientation and shellCount.
FaceShells analyseEdges(const WeldedMesh& mesh, MeshReport& report);

std::uint64_t countDuplicateFaces(const WeldedMesh& mesh);
/// Parts connected over shared vertices.
std::uint64_t countComponents(const WeldedMesh& mesh);

} // namespace volcaustic
