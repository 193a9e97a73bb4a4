// Triangles of a glTF mesh.
#pragma once

#include "scene/gltf_accessor.h"
#include "volcaustic/mesh.h"

#include <string_view>
#include <vector>

namespace volcaustic {

/// A primitive that is made of triangles, checked but for its numbers. \throws Error(Input) at its pointer.
class GltfPrimitive {
public:
  /// True for triangles, strips and fans; points and lines enclose nothing.
  static bool hasTriangles(const GltfValue& primitive);

  GltfPrimitive(GltfFile& file, const GltfValue& primitive);

  /// Vertices and corners of triangles that it adds to a mesh, at most.
  [[nodiscard]] std::uint64_t vertices() const { return mPositions.count(); }
  [[nodiscard]] std::uint64_t corners() const;
  void appendTo(Mesh& mesh) const;

private:
  GltfValue mPlace;
  std::uint64_t mMode;
  GltfAccessor mPositions;
  std::optional<GltfAccessor> mIndices;
};

/// Says how large the triangles of `primitives` (numbers inside of a mesh) are together, in bytes, and checks them.
std::uint64_t checkGltfPrimitives(GltfFile& file, std::size_t mesh, const std::vector<std::size_t>& primitives);

/// Their triangles as one mesh, counter-clockwise seen from outside, positions as they are stored.
Mesh readGltfPrimitives(GltfFile& file, std::size_t mesh, const std::vector<std::size_t>& primitives);

/// The numbers of a mesh's primitives that hasTriangles().
std::vector<std::size_t> gltfTriangles(const GltfFile& file, std::size_t mesh);

/// What follows the '#' of a reference to triangles: "/meshes/0" for all of a mesh, "/meshes/0/primitives/1,2" for
/// some.
std::string gltfFragment(std::size_t mesh, const std::vector<std::size_t>& primitives, bool all);
/// The triangles that a fragment names. \throws Error(Input) where there are none.
Mesh readGltfFragment(GltfFile& file, std::string_view fragment);

} // namespace volcaustic
