// Frames of a mixing as .vdb files.
#include "simulation/mixing_state.h"
#include "volume/vdb_file.h"

#include <openvdb/tools/Dense.h>

namespace volcaustic {

namespace {

using Dense = openvdb::tools::Dense<const float, openvdb::tools::LayoutXYZ>;

/// A fluid that is not there is background, so the tree holds the plume and little else.
openvdb::FloatGrid::Ptr concentrationGrid(const Flow& flow, const openvdb::math::Transform::Ptr& transform) {
  auto grid = openvdb::FloatGrid::create(0);
  const Vec3i& n = flow.cells;
  const Dense dense(openvdb::CoordBBox({0, 0, 0}, {n[0] - 1, n[1] - 1, n[2] - 1}),
                    flow.concentration.values().data() + flow.concentration.index(0, 0, 1));
  openvdb::tools::copyFromDense(dense, *grid, 0.0f);
  grid->setName("concentration");
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setTransform(transform);
  return grid;
}

/// Component a of the value at (i, j, k) belongs to the lower face of that cell along a: OpenVDB's staggered grids.
openvdb::Vec3SGrid::Ptr velocityGrid(const Flow& flow, const openvdb::math::Transform::Ptr& transform,
                                     const RunContext& ctx) {
  auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  auto accessor = grid->getAccessor();
  for (int k = 0; k <= flow.cells[2]; ++k) {
    ctx.throwIfCancelled();
    for (int j = 0; j <= flow.cells[1]; ++j)
      for (int i = 0; i <= flow.cells[0]; ++i) {
        openvdb::Vec3s value(0);
        for (int a = 0; a < 3; ++a) {
          const Lattice& faces = flow.velocity.component[a];
          if (i < faces.dims()[0] && j < faces.dims()[1] && k < faces.dims()[2]) value[a] = faces.at(i, j, k);
        }
        accessor.setValueOn({i, j, k}, value);
      }
  }
  grid->setName("velocity");
  grid->setGridClass(openvdb::GRID_STAGGERED);
  grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
  grid->setTransform(transform);
  return grid;
}

} // namespace

void MixingSimulation::write(const std::filesystem::path& path) const {
  initialiseOpenVdb();
  const Domain& domain = mState->domain;
  auto transform = openvdb::math::Transform::createLinearTransform(domain.voxelSize);
  openvdb::Vec3d first;
  for (int a = 0; a < 3; ++a) first[a] = domain.minCorner[a] + .5 * domain.voxelSize;
  transform->postTranslate(first);
  openvdb::MetaMap metadata;
  metadata.insertMeta("frame", openvdb::Int32Metadata(mState->frame));
  writeVdbFile(path, {concentrationGrid(mState->flow, transform), velocityGrid(mState->flow, transform, mState->ctx)},
               metadata, {}, mState->ctx);
}

} // namespace volcaustic
