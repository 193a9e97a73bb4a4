/// \file mesh.h
/// Triangle meshes: the plain data, files in and out, and what is wrong with them.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/run_context.h"
#include "volcaustic/types.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace volcaustic {

/// A triangle soup with shared vertices. Nothing is assumed of its topology: open, non-manifold and inconsistently
/// wound meshes are all legal. Counter-clockwise triangles face outwards.
struct Mesh {
  std::vector<Vec3d> positions;                        ///< world (or object) space
  std::vector<std::array<std::uint32_t, 3>> triangles; ///< indices into positions
  std::vector<std::uint32_t> triangleGroup;            ///< empty, or an index into groupNames for each triangle
  std::vector<std::string> groupNames;                 ///< material names (OBJ usemtl) or solids (STL), else empty

  [[nodiscard]] bool empty() const { return triangles.empty(); }
};

/// Reads an OBJ, PLY, STL or OFF file (ASCII or binary, recognised by content first and extension second). Polygons are
/// triangulated, PLY triangle strips expanded, identical STL corners welded; NaN or infinite coordinates, indices out
/// of range, faces of fewer than three corners and truncated data are errors. \throws Error(File) when it cannot be
/// opened, Error(Input) "path:line: ..." (or "path: byte N: ...") when the content is wrong or holds no triangle.
VOLCAUSTIC_API Mesh readMesh(const std::filesystem::path& path, const RunContext& ctx = {});

struct MeshWriteOptions {
  bool binary = true; ///< where the format has both forms (PLY, STL)
};

/// Writes OBJ, PLY, STL or OFF by extension, beside the target and renamed when whole. Every face is written, and every
/// position without loss, except that a binary STL holds 32-bit floats: where they move a vertex by more than a hundred
/// thousandth of the mesh's longest side, the context is warned.
/// \throws Error(File), Error(Usage) for an unknown extension, Error(Input) for a mesh that is not valid.
VOLCAUSTIC_API void writeMesh(const std::filesystem::path& path, const Mesh& mesh, const MeshWriteOptions& options = {},
                              const RunContext& ctx = {});

/// What a voxeliser and a person want to know of a mesh. Edges are counted after welding vertices of equal position.
struct MeshReport {
  std::uint64_t vertices = 0, triangles = 0; ///< as stored, before welding
  std::uint64_t openEdges = 0;               ///< with exactly one face
  std::uint64_t nonManifoldEdges = 0;        ///< with more than two faces
  /// With two or more faces whose directions along the edge do not cancel: each face runs along it one way (+1) or the
  /// other (-1), and the sum is not zero. For two faces wound the same way it is 2 or -2; four faces of two bodies that
  /// touch along an edge sum to 0.
  std::uint64_t inconsistentEdges = 0;
  std::uint64_t duplicateFaces = 0;  ///< same three corners, in any order, as an earlier face
  std::uint64_t degenerateFaces = 0; ///< repeated corner (which no edge is counted of) or zero area
  std::uint64_t components = 0;      ///< connected over shared vertices; vertices of no face do not count
  double signedVolume = 0;           ///< world units cubed; negative when faces point inwards
  double area = 0;                   ///< world units squared
  Box bounds;

  /// True when every edge has two faces wound against each other (or pairs of them): winding numbers are whole numbers.
  [[nodiscard]] bool closedAndConsistent() const { return openEdges == 0 && inconsistentEdges == 0; }
};
/// \throws Error(Input) for a mesh that is not valid: an index out of range, a coordinate that is not finite.
VOLCAUSTIC_API MeshReport checkMesh(const Mesh& mesh, const RunContext& ctx = {});

/// The mesh with every position mapped by `placement`; a mirroring placement also flips the winding, so that outwards
/// stays outwards.
VOLCAUSTIC_API Mesh transformed(Mesh mesh, const Affine& placement);

/// Of the triangles' corners; vertices of no face do not count. A box of zeros where there is no triangle.
VOLCAUSTIC_API Box bounds(const Mesh& mesh);

} // namespace volcaustic
