#include "volume/lattice.h"

#include "core/parallel.h"

#include <cmath>
#include <openvdb/tools/GridTransformer.h>

namespace volcaustic {

namespace {

/// Where the domain's index space has the origin of the grid's.
openvdb::Vec3d offsetOf(const openvdb::GridBase& grid, const Domain& domain) {
  return domainTransform(domain)->worldToIndex(grid.indexToWorld(openvdb::Vec3d(0)));
}

} // namespace

bool isMirrored(const openvdb::GridBase& grid) {
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  const openvdb::Vec3d at = box.empty() ? openvdb::Vec3d(0) : box.getCenter();
  const openvdb::Vec3d o = grid.indexToWorld(at), x = grid.indexToWorld(at + openvdb::Vec3d(1, 0, 0)) - o,
                       y = grid.indexToWorld(at + openvdb::Vec3d(0, 1, 0)) - o,
                       z = grid.indexToWorld(at + openvdb::Vec3d(0, 0, 1)) - o;
  return x.cross(y).dot(z) < 0;
}

bool isUpright(const openvdb::math::Transform& transform) {
  const openvdb::Vec3d h = transform.voxelSize(), origin = transform.indexToWorld(openvdb::Vec3d(0));
  bool upright = transform.isLinear() && h.isFinite() && origin.isFinite() && h[0] > 0;
  for (int a = 0; upright && a < 3; ++a) {
    openvdb::Vec3d unit(0.0), index(0.0);
    unit[a] = h[0];
    index[a] = 1;
    upright = (transform.indexToWorld(index) - origin).eq(unit, 1e-6 * h[0] + 1e-12 * origin.length());
  }
  return upright;
}

bool liesOnLattice(const openvdb::GridBase& grid, const Domain& domain) {
  if (!isUpright(grid.transform()) || std::abs(grid.voxelSize()[0] / domain.voxelSize - 1) > 1e-6) return false;
  const openvdb::Vec3d offset = offsetOf(grid, domain);
  return offset.eq(openvdb::Coord::round(offset).asVec3d(), 1e-3);
}

template <class GridType>
typename GridType::Ptr shiftedOnto(const typename GridType::Ptr& grid, const Domain& domain) {
  const openvdb::Coord shift = openvdb::Coord::round(offsetOf(*grid, domain));
  auto result = grid;
  if (shift != openvdb::Coord(0)) {
    result = GridType::create(grid->background());
    result->insertMeta(*grid);
    auto voxels = result->getAccessor();
    for (auto value = grid->cbeginValueOn(); value; ++value) {
      openvdb::CoordBBox box = value.getBoundingBox();
      box.translate(shift);
      if (value.isVoxelValue())
        voxels.setValueOn(box.min(), *value);
      else
        result->sparseFill(box, *value, true);
    }
  }
  result->setTransform(domainTransform(domain));
  return result;
}

template <class GridType>
typename GridType::Ptr resampledOnto(const GridType& grid, const Domain& domain, const std::string& place,
                                     const RunContext& ctx) {
  const openvdb::Vec3d h = grid.voxelSize();
  const double voxels = static_cast<double>(grid.activeVoxelCount()) * h.product() / std::pow(domain.voxelSize, 3);
  ctx.requireMemory(static_cast<std::uint64_t>(std::min(2 * voxels * sizeof(typename GridType::ValueType), 1e19)),
                    place + ": resampled");
  auto result = GridType::create(grid.background());
  result->insertMeta(grid);
  result->setTransform(domainTransform(domain));
  withThreads(ctx, [&] { openvdb::tools::resampleToMatch<openvdb::tools::BoxSampler>(grid, *result); });
  return result;
}

template openvdb::FloatGrid::Ptr shiftedOnto<openvdb::FloatGrid>(const openvdb::FloatGrid::Ptr&, const Domain&);
template openvdb::Vec3SGrid::Ptr shiftedOnto<openvdb::Vec3SGrid>(const openvdb::Vec3SGrid::Ptr&, const Domain&);
template openvdb::FloatGrid::Ptr resampledOnto(const openvdb::FloatGrid&, const Domain&, const std::string&,
                                               const RunContext&);
template openvdb::Vec3SGrid::Ptr resampledOnto(const openvdb::Vec3SGrid&, const Domain&, const std::string&,
                                               const RunContext&);

} // namespace volcaustic
