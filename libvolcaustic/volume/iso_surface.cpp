#include "volume/iso_surface.h"

#include "core/parallel.h"
#include "volcaustic/error.h"
#include "volume/lattice.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <openvdb/tools/VolumeToMesh.h>
#include <span>

namespace volcaustic {

namespace {

using openvdb::tools::PolygonPool;
using openvdb::tools::VolumeToMesh;

/// OpenVDB winds its polygons clockwise seen from where values are lower, of a level set from where they are higher.
bool flipsPolygons(const openvdb::FloatGrid& grid, double isovalue) {
  const bool levelSet = grid.getGridClass() == openvdb::GRID_LEVEL_SET;
  const bool highOutside = levelSet ? grid.background() >= isovalue : grid.background() > isovalue;
  return isMirrored(grid) != (highOutside != levelSet);
}

using Tree = openvdb::FloatTree;

/// Whether an inactive voxel of the leaf has an inactive neighbour on the other side of the isovalue.
bool hidesFaces(const Tree::LeafNodeType& leaf, const openvdb::FloatGrid::ConstAccessor& tree, double isovalue) {
  for (auto voxel = leaf.cbeginValueOff(); voxel; ++voxel)
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        openvdb::Coord neighbour = voxel.getCoord();
        neighbour[axis] += side;
        float value = 0;
        if (!tree.probeValue(neighbour, value) && (value < isovalue) != (*voxel < isovalue)) return true;
      }
  return false;
}

/// The same for a tile and the blocks of 8^3 voxels beside it, those that are leaves left out.
template <class Tile>
bool hidesFaces(const Tile& tile, const openvdb::FloatGrid::ConstAccessor& tree, double isovalue) {
  const openvdb::CoordBBox box = tile.getBoundingBox();
  const auto isHidden = [&](const openvdb::Coord& at) {
    float value = 0;
    return !tree.probeConstLeaf(at) && !tree.probeValue(at, value) && (value < isovalue) != (*tile < isovalue);
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int u = 0; u < box.dim()[0]; u += 8)
      for (int v = 0; v < box.dim()[0]; v += 8) {
        openvdb::Coord before = box.min();
        before[(axis + 1) % 3] += u;
        before[(axis + 2) % 3] += v;
        openvdb::Coord after = before;
        --before[axis];
        after[axis] = box.max()[axis] + 1;
        if (isHidden(before) || isHidden(after)) return true;
      }
  return false;
}

/// OpenVDB's mesher looks for the surface between two voxels only where one of them is active, so it leaves a hole
/// where both are not, as where a level set was clipped through its inside.
bool hidesFaces(const openvdb::FloatGrid& grid, double isovalue, const RunContext& ctx) {
  std::atomic<bool> hidden{false};
  std::vector<const Tree::LeafNodeType*> leaves;
  grid.tree().getNodes(leaves);
  parallelFor(static_cast<std::int64_t>(leaves.size()), 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    const openvdb::FloatGrid::ConstAccessor tree = grid.getConstAccessor();
    for (std::int64_t i = begin; i < end && !hidden; ++i)
      if (hidesFaces(*leaves[i], tree, isovalue)) hidden = true;
  });
  const openvdb::FloatGrid::ConstAccessor tree = grid.getConstAccessor();
  auto tile = grid.tree().cbeginValueOff();
  tile.setMaxDepth(Tree::ValueOffCIter::LEAF_DEPTH - 1);
  for (; tile && !hidden; ++tile)
    if ((*tile < isovalue) != (grid.background() < isovalue)) hidden = hidesFaces(tile, tree, isovalue);
  return hidden;
}

/// The grid so that OpenVDB's mesher sees all of its surface: all that lies beyond the isovalue active, where it must.
openvdb::FloatGrid::ConstPtr withVisibleFaces(const openvdb::FloatGrid& grid, double isovalue, const RunContext& ctx) {
  if (!hidesFaces(grid, isovalue, ctx)) return grid.copy();
  const openvdb::FloatGrid::Ptr result = grid.deepCopy();
  for (auto value = result->beginValueOff(); value; ++value)
    if ((*value < isovalue) != (grid.background() < isovalue)) value.setActiveState(true);
  return result;
}

struct MovedValue {
  openvdb::Index offset;
  float value;
};

float reachOf(const Tree::LeafNodeType& leaf, float isovalue) {
  const float* values = leaf.buffer().data();
  float reach = 0;
  for (openvdb::Index v = 0; v < leaf.SIZE; ++v) reach = std::max(reach, std::abs(values[v] - isovalue));
  return reach;
}

/// Greatest distance of a value from the isovalue.
float reachOf(const openvdb::FloatGrid& grid, std::span<const Tree::LeafNodeType* const> leaves, float isovalue,
              const RunContext& ctx) {
  std::vector<float> reach(threadCount(ctx), 0.0f);
  parallelFor(static_cast<std::int64_t>(leaves.size()), 256, ctx, [&](std::int64_t begin, std::int64_t end, int slot) {
    for (std::int64_t i = begin; i < end; ++i) reach[slot] = std::max(reach[slot], reachOf(*leaves[i], isovalue));
  });
  float greatest = *std::max_element(reach.begin(), reach.end());
  auto tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) greatest = std::max(greatest, std::abs(*tile - isovalue));
  return std::max(greatest, std::abs(grid.background() - isovalue));
}

/// The values of a leaf that are too near to the isovalue (clearOf).
std::vector<MovedValue> movedValues(const Tree::LeafNodeType& leaf, const openvdb::FloatGrid::ConstAccessor& tree,
                                    float isovalue, float reach) {
  std::vector<MovedValue> moved;
  const float* values = leaf.buffer().data();
  for (openvdb::Index v = 0; v < leaf.SIZE; ++v) {
    if (clearOf(isovalue, values[v], 2 * reach) == values[v]) continue;
    float difference = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        openvdb::Coord neighbour = leaf.offsetToGlobalCoord(v);
        neighbour[axis] += side;
        const float other = tree.getValue(neighbour);
        if ((other < isovalue) != (values[v] < isovalue))
          difference = std::max(difference, std::abs(other - values[v]));
      }
    const float value = clearOf(isovalue, values[v], difference);
    if (value != values[v] && std::isfinite(value)) moved.push_back({v, value});
  }
  return moved;
}

/// The grid without values so near to the isovalue that triangles would have no area.
openvdb::FloatGrid::ConstPtr withClearValues(const openvdb::FloatGrid::ConstPtr& grid, float isovalue,
                                             const RunContext& ctx) {
  std::vector<const Tree::LeafNodeType*> leaves;
  grid->tree().getNodes(leaves);
  const auto count = static_cast<std::int64_t>(leaves.size());
  const float reach = reachOf(*grid, leaves, isovalue, ctx);
  std::vector<std::vector<MovedValue>> moved(leaves.size());
  std::atomic<bool> any{false};
  parallelFor(count, 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    const openvdb::FloatGrid::ConstAccessor tree = grid->getConstAccessor();
    for (std::int64_t i = begin; i < end; ++i)
      if (moved[i] = movedValues(*leaves[i], tree, isovalue, reach); !moved[i].empty()) any = true;
  });
  if (!any) return grid;
  const openvdb::FloatGrid::Ptr result = grid->deepCopy();
  std::vector<Tree::LeafNodeType*> targets;
  result->tree().getNodes(targets);
  for (std::int64_t i = 0; i < count; ++i)
    for (const MovedValue& voxel : moved[i]) targets[i]->setValueOnly(voxel.offset, voxel.value);
  return result;
}

/// What OpenVDB's mesher and the mesh take at most: the faces of tiles beyond the isovalue, which it divides into
/// voxels, and a few layers of voxels in each leaf.
void requireSurfaceMemory(const openvdb::FloatGrid& grid, double isovalue, const std::string& place,
                          const RunContext& ctx) {
  constexpr double kBytesPerQuad = 150, kQuadsPerLeaf = 192;
  double quads = kQuadsPerLeaf * static_cast<double>(grid.tree().leafCount());
  auto value = grid.tree().cbeginValueAll();
  value.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; value; ++value)
    if ((*value < isovalue) != (grid.background() < isovalue)) {
      const double edge = value.getBoundingBox().extents().x();
      quads += 6 * edge * edge;
    }
  ctx.requireMemory(static_cast<std::uint64_t>(std::min(quads * kBytesPerQuad, 1e19)), place + ": its surface");
}

/// Gets the corners of the triangles of one pool, degenerate ones left out; a quadrangle is cut along its shorter
/// diagonal.
template <class Visit>
void forEachTriangle(const PolygonPool& pool, const openvdb::Vec3s* points, Visit&& visit) {
  const auto triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a != b && b != c && c != a) visit(a, b, c);
  };
  for (std::size_t i = 0; i < pool.numTriangles(); ++i) {
    const openvdb::Vec3I& t = pool.triangle(i);
    triangle(t[0], t[1], t[2]);
  }
  for (std::size_t i = 0; i < pool.numQuads(); ++i) {
    const openvdb::Vec4I& q = pool.quad(i);
    if ((points[q[0]] - points[q[2]]).lengthSqr() <= (points[q[1]] - points[q[3]]).lengthSqr()) {
      triangle(q[0], q[1], q[2]);
      triangle(q[0], q[2], q[3]);
    } else {
      triangle(q[1], q[2], q[3]);
      triangle(q[1], q[3], q[0]);
    }
  }
}

std::vector<std::array<std::uint32_t, 3>> trianglesOf(const VolumeToMesh& mesher, bool flip, const RunContext& ctx) {
  const auto pools = static_cast<std::int64_t>(mesher.polygonPoolListSize());
  const openvdb::Vec3s* points = mesher.pointList().get();
  const auto forPools = [&](const auto& body) {
    parallelFor(pools, 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t p = begin; p < end; ++p) body(p, mesher.polygonPoolList()[p]);
    });
  };
  std::vector<std::size_t> first(pools + 1);
  forPools([&](std::int64_t p, const PolygonPool& pool) {
    forEachTriangle(pool, points, [&](auto...) { ++first[p + 1]; });
  });
  for (std::int64_t p = 0; p < pools; ++p) first[p + 1] += first[p];
  std::vector<std::array<std::uint32_t, 3>> triangles(first[pools]);
  forPools([&](std::int64_t p, const PolygonPool& pool) {
    auto* next = &triangles[first[p]];
    forEachTriangle(pool, points, [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      *next++ = flip ? std::array{a, b, c} : std::array{a, c, b};
    });
  });
  return triangles;
}

std::vector<Vec3d> positionsOf(const VolumeToMesh& mesher, const openvdb::FloatGrid& grid, const std::string& place,
                               const RunContext& ctx) {
  std::vector<Vec3d> positions(mesher.pointListSize());
  std::atomic<bool> finite{true};
  parallelFor(static_cast<std::int64_t>(positions.size()), 4096, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      const openvdb::Vec3d world = grid.indexToWorld(openvdb::Vec3d(mesher.pointList()[i]));
      positions[i] = {world[0], world[1], world[2]};
      if (!world.isFinite()) finite = false;
    }
  });
  if (!finite)
    throw Error(ErrorKind::Input, place + ": holds values that are not finite at the surface; repair the grid first");
  return positions;
}

} // namespace

Mesh isoSurface(const openvdb::FloatGrid& grid, double isovalue, double adaptivity, const std::string& place,
                const RunContext& ctx) {
  requireSurfaceMemory(grid, isovalue, place, ctx);
  // Meshed in index space: single precision in world space would lose small grids far from the origin.
  const auto indexGrid = withClearValues(withVisibleFaces(grid, isovalue, ctx), static_cast<float>(isovalue), ctx)
                             ->copyReplacingTransform(openvdb::math::Transform::createLinearTransform(1.0));
  VolumeToMesh mesher(isovalue, adaptivity);
  withThreads(ctx, [&] { mesher(*indexGrid); });
  Mesh mesh;
  mesh.positions = positionsOf(mesher, grid, place, ctx);
  mesh.triangles = trianglesOf(mesher, flipsPolygons(grid, isovalue), ctx);
  return mesh;
}

} // namespace volcaustic
