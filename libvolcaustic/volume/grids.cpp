#include "volume/grids.h"

#include "core/parallel.h"

#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace volcaustic {

namespace {

const float& toVdb(const float& v) { return v; }
openvdb::Vec3s toVdb(const Vec3f& v) { return {v[0], v[1], v[2]}; }

/// Both have the same bytes: three floats without padding, and 512 values in the same order.
static_assert(sizeof(openvdb::Vec3s) == sizeof(Vec3f));
static_assert(openvdb::FloatTree::LeafNodeType::NUM_VOXELS == kBrickVoxels);

Vec3i brickOrigin(const Vec3i& brick) { return {brick[0] * kBrickSize, brick[1] * kBrickSize, brick[2] * kBrickSize}; }

bool sticksOut(const Vec3i& origin, const Vec3i& dims) {
  return origin[0] + kBrickSize > dims[0] || origin[1] + kBrickSize > dims[1] || origin[2] + kBrickSize > dims[2];
}

/// Calls visit(offset, inside) for the voxels of the brick at `origin`; inside says whether the domain has that voxel.
template <class Visit>
void forEachVoxel(const Vec3i& origin, const Vec3i& dims, Visit&& visit) {
  for (int x = 0; x < kBrickSize; ++x)
    for (int y = 0; y < kBrickSize; ++y)
      for (int z = 0; z < kBrickSize; ++z)
        visit(brickOffset(x, y, z), origin[0] + x < dims[0] && origin[1] + y < dims[1] && origin[2] + z < dims[2]);
}

template <class Tree, class T>
std::unique_ptr<typename Tree::LeafNodeType> makeLeaf(const BrickGrid<T>& bricks, std::int64_t brick) {
  using Leaf = typename Tree::LeafNodeType;
  const Vec3i o = brickOrigin(bricks.brickCoord(brick));
  // Created in part: the leaf's values are written once.
  auto leaf = std::make_unique<Leaf>(openvdb::PartialCreate(), openvdb::Coord(o[0], o[1], o[2]), toVdb(T{}), true);
  auto* values = leaf->buffer().data();
  if (bricks.isConstant(brick))
    std::fill_n(values, kBrickVoxels, toVdb(bricks.constant(brick)));
  else
    std::memcpy(static_cast<void*>(values), bricks.voxels(brick).data(), kBrickVoxels * sizeof(T));
  if (sticksOut(o, bricks.dims()))
    forEachVoxel(o, bricks.dims(), [&](int offset, bool inside) {
      if (!inside) leaf->setValueOff(offset, toVdb(bricks.background()));
    });
  return leaf;
}

template <class GridType, class T>
typename GridType::Ptr toGrid(const BrickGrid<T>& bricks, const Domain& domain, const char* name,
                              const RunContext& ctx) {
  using Tree = typename GridType::TreeType;
  auto grid = GridType::create(toVdb(bricks.background()));
  grid->setName(name);
  grid->setTransform(domainTransform(domain));
  std::vector<std::int64_t> leafBricks;
  openvdb::tree::ValueAccessor<Tree> accessor(grid->tree());
  for (const std::int64_t b : bricks.occupied()) {
    const Vec3i o = brickOrigin(bricks.brickCoord(b));
    if (!bricks.isConstant(b) || sticksOut(o, bricks.dims()))
      leafBricks.push_back(b);
    else
      accessor.addTile(1, openvdb::Coord(o[0], o[1], o[2]), toVdb(bricks.constant(b)), true);
  }
  const auto count = static_cast<std::int64_t>(leafBricks.size());
  std::vector<std::unique_ptr<typename Tree::LeafNodeType>> leaves(leafBricks.size());
  parallelFor(count, 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) leaves[i] = makeLeaf<Tree>(bricks, leafBricks[i]);
  });
  for (auto& leaf : leaves) accessor.addLeaf(leaf.release());
  withThreads(ctx, [&] { openvdb::tools::pruneTiles(grid->tree()); });
  return grid;
}

/// True when the voxels of a leaf that the domain has are not all equal.
template <class Leaf>
bool varies(const Leaf& leaf, const Vec3i& dims) {
  const openvdb::Coord o = leaf.origin();
  const auto* values = leaf.buffer().data();
  if (!sticksOut({o.x(), o.y(), o.z()}, dims))
    return std::any_of(values + 1, values + kBrickVoxels, [first = values[0]](const auto& v) { return v != first; });
  bool different = false;
  forEachVoxel({o.x(), o.y(), o.z()}, dims,
               [&](int offset, bool inside) { different |= inside && values[offset] != values[0]; });
  return different;
}

template <class T>
T fromVdb(const openvdb::Vec3s& v) {
  return {v[0], v[1], v[2]};
}
template <class T>
T fromVdb(float v) {
  return v;
}

/// The part of a brick grid that a node of a tree covers, or one of its tiles.
struct Bricks {
  Vec3i first, end;
  Bricks(const openvdb::Coord& origin, int log2, const Vec3i& brickDims) {
    for (int a = 0; a < 3; ++a) {
      const int brick = origin[a] >> kBrickLog2;
      first[a] = std::clamp(brick, 0, brickDims[a]);
      end[a] = std::clamp(brick + (1 << (log2 - kBrickLog2)), 0, brickDims[a]);
    }
  }
};

template <class T>
void setAll(BrickGrid<T>& bricks, const Bricks& part, const T& value) {
  for (int x = part.first[0]; x < part.end[0]; ++x)
    for (int y = part.first[1]; y < part.end[1]; ++y)
      for (int z = part.first[2]; z < part.end[2]; ++z) bricks.setConstant(bricks.brickIndex({x, y, z}), value);
}

/// The tiles of all nodes of one kind, but for those of the tree's background.
template <class Node, class Tree, class T>
void setTiles(BrickGrid<T>& bricks, const Tree& tree, const RunContext& ctx) {
  std::vector<const Node*> nodes;
  tree.getNodes(nodes);
  parallelFor(static_cast<std::int64_t>(nodes.size()), 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i)
      for (auto tile = nodes[i]->cbeginValueAll(); tile; ++tile)
        if (*tile != tree.background())
          setAll(bricks, Bricks(tile.getCoord(), Node::ChildNodeType::TOTAL, bricks.brickDims()), fromVdb<T>(*tile));
  });
}

template <class GridType, class T>
void setConstants(BrickGrid<T>& bricks, const GridType& grid, const RunContext& ctx) {
  using Root = typename GridType::TreeType::RootNodeType;
  using Upper = typename Root::ChildNodeType;
  if (const T background = fromVdb<T>(grid.background()); background != bricks.background())
    parallelFor(bricks.brickCount(), 4096, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t b = begin; b < end; ++b) bricks.setConstant(b, background);
    });
  for (auto tile = grid.tree().root().cbeginValueAll(); tile; ++tile)
    setAll(bricks, Bricks(tile.getCoord(), Upper::TOTAL, bricks.brickDims()), fromVdb<T>(*tile));
  setTiles<Upper>(bricks, grid.tree(), ctx);
  setTiles<typename Upper::ChildNodeType>(bricks, grid.tree(), ctx);
}

template <class T, class GridType>
BrickGrid<T> fromGrid(const GridType& grid, const Vec3i& dims, const T& background, const RunContext& ctx) {
  using Leaf = typename GridType::TreeType::LeafNodeType;
  BrickGrid<T> bricks(dims, background);
  setConstants(bricks, grid, ctx);
  std::vector<const Leaf*> leaves;
  grid.tree().getNodes(leaves);
  std::erase_if(leaves, [&](const Leaf* leaf) {
    const Bricks part(leaf->origin(), kBrickLog2, bricks.brickDims());
    return part.first[0] == part.end[0] || part.first[1] == part.end[1] || part.first[2] == part.end[2];
  });
  const auto count = static_cast<std::int64_t>(leaves.size());
  const auto brickOf = [&](const Leaf& leaf) {
    const openvdb::Coord& o = leaf.origin();
    return bricks.brickIndex({o.x() >> kBrickLog2, o.y() >> kBrickLog2, o.z() >> kBrickLog2});
  };
  std::vector<std::uint8_t> varying(leaves.size());
  parallelFor(count, 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      varying[i] = varies(*leaves[i], dims);
      if (!varying[i]) bricks.setConstant(brickOf(*leaves[i]), fromVdb<T>(leaves[i]->buffer().data()[0]));
    }
  });
  std::vector<std::int64_t> active;
  for (std::int64_t i = 0; i < count; ++i)
    if (varying[i]) active.push_back(brickOf(*leaves[i]));
  ctx.requireMemory(bricks.memoryBytes() + active.size() * kBrickVoxels * sizeof(T),
                    "reading grid '" + grid.getName() + "'");
  bricks.activate(active, Fill::Later);
  parallelFor(count, 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i)
      if (varying[i])
        std::memcpy(bricks.voxels(brickOf(*leaves[i])).data(), leaves[i]->buffer().data(), kBrickVoxels * sizeof(T));
  });
  return bricks;
}

} // namespace

openvdb::FloatGrid::Ptr toFloatGrid(const BrickGrid<float>& bricks, const Domain& domain, const char* name,
                                    const RunContext& ctx) {
  return toGrid<openvdb::FloatGrid>(bricks, domain, name, ctx);
}
openvdb::Vec3SGrid::Ptr toVec3Grid(const BrickGrid<Vec3f>& bricks, const Domain& domain, const char* name,
                                   const RunContext& ctx) {
  return toGrid<openvdb::Vec3SGrid>(bricks, domain, name, ctx);
}

BrickGrid<float> fromFloatGrid(const openvdb::FloatGrid& grid, const Vec3i& dims, const RunContext& ctx) {
  return fromGrid<float>(grid, dims, grid.background(), ctx);
}
BrickGrid<Vec3f> fromVec3Grid(const openvdb::Vec3SGrid& grid, const Vec3i& dims, const RunContext& ctx) {
  return fromGrid<Vec3f>(grid, dims, fromVdb<Vec3f>(grid.background()), ctx);
}
BrickGrid<float> fromFloatGrid(const openvdb::FloatGrid& grid, const Vec3i& dims, float background,
                               const RunContext& ctx) {
  return fromGrid<float>(grid, dims, background, ctx);
}
BrickGrid<Vec3f> fromVec3Grid(const openvdb::Vec3SGrid& grid, const Vec3i& dims, const Vec3f& background,
                              const RunContext& ctx) {
  return fromGrid<Vec3f>(grid, dims, background, ctx);
}

} // namespace volcaustic
