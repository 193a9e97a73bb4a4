#include "volume/grids.h"

#include "core/parallel.h"

#include <openvdb/tools/Prune.h>

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
  auto leaf = std::make_unique<Leaf>(openvdb::Coord(o[0], o[1], o[2]), toVdb(bricks.constant(brick)), true);
  if (!bricks.isConstant(brick))
    std::memcpy(static_cast<void*>(leaf->buffer().data()), bricks.voxels(brick).data(), kBrickVoxels * sizeof(T));
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
  for (std::int64_t b = 0; b < bricks.brickCount(); ++b) {
    if (bricks.isConstant(b) && bricks.constant(b) == bricks.background()) continue;
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

template <class T, class GridType>
BrickGrid<T> fromGrid(const GridType& grid, const Vec3i& dims, const RunContext& ctx) {
  using Leaf = typename GridType::TreeType::LeafNodeType;
  BrickGrid<T> bricks(dims, fromVdb<T>(grid.background()));
  std::vector<const Leaf*> leaves(static_cast<std::size_t>(bricks.brickCount()), nullptr);
  parallelFor(bricks.brickCount(), 4096, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    const auto accessor = grid.getConstAccessor();
    for (std::int64_t b = begin; b < end; ++b) {
      const Vec3i o = brickOrigin(bricks.brickCoord(b));
      const openvdb::Coord origin(o[0], o[1], o[2]);
      const Leaf* leaf = accessor.probeConstLeaf(origin);
      if (leaf && varies(*leaf, dims))
        leaves[b] = leaf;
      else
        bricks.setConstant(b, fromVdb<T>(accessor.getValue(origin)));
    }
  });
  std::vector<std::int64_t> varying;
  for (std::int64_t b = 0; b < bricks.brickCount(); ++b)
    if (leaves[b]) varying.push_back(b);
  ctx.requireMemory(bricks.memoryBytes() + varying.size() * kBrickVoxels * sizeof(T),
                    "reading grid '" + grid.getName() + "'");
  bricks.activate(varying);
  parallelFor(static_cast<std::int64_t>(varying.size()), 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i)
      std::memcpy(bricks.voxels(varying[i]).data(), leaves[varying[i]]->buffer().data(), kBrickVoxels * sizeof(T));
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
  return fromGrid<float>(grid, dims, ctx);
}
BrickGrid<Vec3f> fromVec3Grid(const openvdb::Vec3SGrid& grid, const Vec3i& dims, const RunContext& ctx) {
  return fromGrid<Vec3f>(grid, dims, ctx);
}

} // namespace volcaustic
