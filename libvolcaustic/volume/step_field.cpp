// The step field as a VDB grid whose nodes are the octree's cubes where the two agree (Vyatkin and Dolgovesov,
// "Volume-oriented visualization of caustics ...", section 3).
#include "core/parallel.h"
#include "volume/medium_store.h"
#include "volume/step_labels.h"

#include <openvdb/tools/Prune.h>

#include <array>
#include <memory>

namespace volcaustic {

namespace {

using Leaf = openvdb::Int32Tree::LeafNodeType;

std::int32_t gridLabel(StepLabel label) {
  return (label & kernels::kStepLevelMask) + (label & kernels::kStepCappedBit ? kStepCapped : 0);
}

openvdb::Coord firstVoxel(const Vec3i& brick) {
  return {brick[0] * kBrickSize, brick[1] * kBrickSize, brick[2] * kBrickSize};
}

void addCubes(openvdb::Int32Grid::Accessor& accessor, const StepLabels& labels) {
  for (const StepLabels::Cube& cube : labels.cubes()) {
    const openvdb::CoordBBox box(firstVoxel(cube.first), firstVoxel(cube.last).offsetBy(kBrickSize - 1));
    if (cube.first == cube.last)
      accessor.addTile(1, box.min(), gridLabel(cube.label), true);
    else
      accessor.tree().fill(box, gridLabel(cube.label), true);
  }
}

void addLeaves(openvdb::Int32Grid::Accessor& accessor, const StepLabels& labels, const BrickGrid<float>& index,
               const RunContext& ctx) {
  const std::vector<std::int64_t>& mixed = labels.mixedBricks();
  std::vector<std::unique_ptr<Leaf>> leaves(mixed.size());
  parallelFor(static_cast<std::int64_t>(mixed.size()), 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    std::array<StepLabel, kBrickVoxels> ofVoxels;
    for (std::int64_t i = begin; i < end; ++i) {
      const Vec3i brick = index.brickCoord(mixed[i]);
      labels.ofVoxels(brick, ofVoxels);
      leaves[i] = std::make_unique<Leaf>(openvdb::PartialCreate(), firstVoxel(brick), 0, true);
      std::transform(ofVoxels.begin(), ofVoxels.end(), leaves[i]->buffer().data(), gridLabel);
    }
  });
  for (auto& leaf : leaves) accessor.addLeaf(leaf.release());
}

} // namespace

openvdb::Int32Grid::Ptr stepFieldGrid(const Medium& medium, const StepFieldOptions& options, const RunContext& ctx) {
  const Domain& domain = medium.domain();
  const std::shared_ptr<const OpticsBricks> bricks = bricksOf(medium, ctx);
  const BrickGrid<float>& index = bricks->index;
  const StepLabels labels(index, bricks->attenuation ? &*bricks->attenuation : nullptr, domain.voxelSize, options, ctx);
  auto grid = openvdb::Int32Grid::create(0);
  grid->setName("stepField");
  grid->setTransform(domainTransform(domain));
  auto accessor = grid->getAccessor();
  addCubes(accessor, labels);
  addLeaves(accessor, labels, index, ctx);
  withThreads(ctx, [&] { openvdb::tools::prune(grid->tree()); });
  return grid;
}

} // namespace volcaustic
