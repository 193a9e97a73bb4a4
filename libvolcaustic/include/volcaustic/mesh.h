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
  std::vector<std::string> groupNames;                 ///< OBJ usemtl, or else g, or else o; STL solids; or empty

  [[nodiscard]] bool empty() const { return triangles.empty(); }
};

/// Reads an OBJ, PLY, STL or OFF file (ASCII or binary, recognised by content first and extension second; "-" is
/// standard input). Polygons are
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

/// What a shell does to the space inside it, by the rule that inside is where winding numbers do not sum to zero.
enum class ShellRole {
  Open,     ///< has open or inconsistently wound edges: encloses nothing for certain, and takes no part in nesting
  Flat,     ///< closed, but its faces cancel (each present once for each side): encloses nothing
  Body,     ///< stands in empty space and encloses matter, whichever way it faces
  Cavity,   ///< inside a body and wound against it: hollow
  Immersed, ///< inside a body and wound like it: changes nothing, because overlapping shells are a union
};

/// Faces that hang together over edges. A part that touches another in a vertex only is a shell of its own.
struct MeshShell {
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  std::uint64_t triangles = 0;
  std::uint64_t openEdges = 0, inconsistentEdges = 0; ///< as of MeshReport
  double signedVolume = 0;                            ///< world units cubed; negative when faces point inwards
  double area = 0;                                    ///< world units squared
  Box bounds;
  ShellRole role = ShellRole::Open;
  int depth = 0;                  ///< number of closed shells around it
  std::size_t enclosedBy = kNone; ///< the innermost of them, as an index into MeshReport::shells, if it is listed there

  [[nodiscard]] bool closed() const { return openEdges == 0 && inconsistentEdges == 0; }
};

/// What a voxeliser and a person want to know of a mesh. Edges are counted after welding vertices of equal position.
struct MeshReport {
  static constexpr std::size_t kListedShells = 64;

  std::uint64_t vertices = 0, triangles = 0; ///< as stored, before welding
  std::uint64_t openEdges = 0;               ///< with exactly one face
  std::uint64_t nonManifoldEdges = 0;        ///< with more than two faces
  /// With two or more faces whose directions along the edge do not cancel: each face runs along it one way (+1) or the
  /// other (-1), and the sum is not zero. For two faces wound the same way it is 2 or -2; four faces of two bodies that
  /// touch along an edge sum to 0.
  std::uint64_t inconsistentEdges = 0;
  /// Faces to reverse, at least, until no edge of exactly two faces is inconsistent. A patch is what hangs together
  /// over such edges; the smaller side of each counts, and of those that cannot be oriented none.
  std::uint64_t flippedFaces = 0;
  std::uint64_t unorientablePatches = 0; ///< one-sided like a Moebius strip: no reversal makes them consistent
  std::uint64_t duplicateFaces = 0;      ///< same three corners, in any order, as an earlier face
  std::uint64_t degenerateFaces = 0;     ///< repeated corner (which no edge is counted of) or zero area
  std::uint64_t components = 0;          ///< connected over shared vertices; vertices of no face do not count
  double signedVolume = 0;               ///< world units cubed; negative when faces point inwards
  double area = 0;                       ///< world units squared
  Box bounds;

  /// The shells of most area, in that order, kListedShells at most. The counts below are of all shells.
  std::vector<MeshShell> shells;
  std::uint64_t shellCount = 0, closedShells = 0;
  std::uint64_t cavities = 0, immersedShells = 0, flatShells = 0;
  std::uint64_t inwardBodies = 0; ///< bodies whose faces point inwards
  /// False where nesting was looked at between the listed shells only, because there are too many others.
  bool nestingComplete = true;

  /// True when every edge has two faces wound against each other (or pairs of them): winding numbers are whole numbers.
  [[nodiscard]] bool closedAndConsistent() const { return openEdges == 0 && inconsistentEdges == 0; }
};
/// \throws Error(Input) for a mesh that is not valid: an index out of range, a coordinate that is not finite.
VOLCAUSTIC_API MeshReport checkMesh(const Mesh& mesh, const RunContext& ctx = {});

/// What is wrong with a mesh, in words: "223 open edges, 10 inconsistently wound edges (4 flipped faces), 2 duplicate
/// faces"; empty for a flawless one.
VOLCAUSTIC_API std::string describeDefects(const MeshReport& report);

/// How FillRule::Auto tells inside from outside for a mesh.
struct FillRoute {
  bool exact;         ///< rows of signed crossings; otherwise generalised winding numbers
  std::string reason; ///< "closed and consistently wound", or the defects
};
VOLCAUSTIC_API FillRoute fillRoute(const MeshReport& report);

/// Sentences for whoever expected something else: of shells inside shells, of faces that point inwards or cancel, each
/// with what to try. Empty for a single closed shell that faces outwards.
VOLCAUSTIC_API std::vector<std::string> shellRemarks(const MeshReport& report);

/// One mesh for each of `groupNames`, in that order, without the vertices and names that it does not use; empty for a
/// group of no triangle. A mesh without groups comes back as the only element.
VOLCAUSTIC_API std::vector<Mesh> splitByGroup(const Mesh& mesh, const RunContext& ctx = {});

/// The mesh with every position mapped by `placement`; a mirroring placement also flips the winding, so that outwards
/// stays outwards.
VOLCAUSTIC_API Mesh transformed(Mesh mesh, const Affine& placement);

/// Of the triangles' corners; vertices of no face do not count. A box of zeros where there is no triangle.
VOLCAUSTIC_API Box bounds(const Mesh& mesh);

} // namespace volcaustic
