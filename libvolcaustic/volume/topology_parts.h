// The parts of a surface whose topology is controlled, and the signed distance from each.
#pragma once

#include "volume/topology_blocks.h"
#include "volume/topology_columns.h"
#include "volume/topology_tree.h"

#include <memory>

namespace volcaustic {

/// A closed mesh over welded vertices, without triangles that repeat a corner.
struct WeldedSurface {
  std::vector<Vec3d> positions;
  std::vector<TriangleCorners> triangles;
  std::vector<std::uint32_t> meshVertex; ///< of each position, one of the mesh
  std::vector<std::uint32_t> meshFace;   ///< of each triangle
  std::vector<std::uint32_t> partOf;     ///< of each triangle
  std::uint32_t partCount = 0, shellCount = 0;
};

/// Parts are shells that face outwards, each with the cavities in it. \throws Error(Input) for a mesh that is not
/// closed and consistently wound, or has a shell that faces inwards and is no cavity.
WeldedSurface weldedSurface(const Mesh& mesh, const RunContext& ctx);

/// How often the triangles wind around a point, rounded.
int windingNumber(const WeldedSurface& surface, std::span<const std::uint32_t> triangles, const Vec3d& p);

struct NodeDistance {
  float distance = 0; ///< negative inside
  Vec3f gradient{0, 0, 0};
  bool atCrease = false; ///< where a part that runs through itself leaves itself
};

/// One part, as a field of distances at the nodes of a lattice.
class SurfacePart {
public:
  SurfacePart(const WeldedSurface& surface, std::vector<std::uint32_t> faces, double voxelSize, const RunContext& ctx);

  /// Triangles of the surface, by their index in the tree.
  [[nodiscard]] const std::vector<std::uint32_t>& faces() const { return mFaces; }
  [[nodiscard]] const TriangleTree& tree() const { return *mTree; }
  [[nodiscard]] const WindingColumns& columns() const { return mColumns; }
  [[nodiscard]] bool runsThroughItself() const { return mRunsThroughItself; }
  /// At a point, whose side is that of node `n` nearby; distances stop at `limit`. `hint` is a triangle that may be
  /// near, and gets the closest one.
  [[nodiscard]] NodeDistance distance(const Vec3d& p, const Vec3i& n, double limit, std::uint32_t& hint) const;
  /// The closest point that is not inside the part.
  [[nodiscard]] ClosestPoint closest(const Vec3d& p, double within, std::uint32_t hint = ClosestPoint::kNone) const;

private:
  [[nodiscard]] bool isBuried(std::uint32_t triangle, const Vec3d& point) const;

  double mVoxelSize;
  std::vector<std::uint32_t> mFaces;
  std::unique_ptr<TriangleTree> mTree;
  WindingColumns mColumns;
  bool mRunsThroughItself = false;
};

} // namespace volcaustic
