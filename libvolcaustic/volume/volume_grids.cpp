#include "volume/volume_grids.h"

#include "volume/foreign_grids.h"
#include "volume/grid_values.h"
#include "volume/scalar_grid.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace volcaustic {

namespace {

openvdb::Vec3d toVdb(const Vec3d& v) { return {v[0], v[1], v[2]}; }

bool isFinite(float v) { return std::isfinite(v); }
bool isFinite(const openvdb::Vec3s& v) { return v.isFinite(); }

/// With everything active that is not the background: the inside of a level set is not.
template <class GridType>
typename GridType::Ptr plainGrid(const GridType& grid, const std::string& place, const RunContext& ctx) {
  std::atomic<bool> finite{true};
  const auto plain = mappedGrid<GridType>(grid, Active::OtherThanNothing, ctx, [&](const auto& value) {
    if (!isFinite(value)) finite = false;
    return value;
  });
  if (!finite)
    throw Error(ErrorKind::Input, place + ": grid '" + grid.getName() + "' holds values that are not finite");
  return plain;
}

/// Linear part and shift of an affine placement, in OpenVDB's types but for columns.
openvdb::Mat3R linearPart(const Affine& m) {
  return {m[0][0], m[0][1], m[0][2], m[1][0], m[1][1], m[1][2], m[2][0], m[2][1], m[2][2]};
}
openvdb::Vec3d shiftOf(const Affine& m) { return {m[0][3], m[1][3], m[2][3]}; }

} // namespace

VolumeGrids::VolumeGrids(const std::filesystem::path& path, const std::vector<std::string>& names,
                         const RunContext& ctx) {
  const std::string place = path.string();
  const VdbFile file = readVdbFile(path, ctx, mappableGrids(place, names));
  for (const auto& grid : file.grids) {
    if (find(grid->getName())) continue;
    requireLinear(*grid, place);
    Grid made{grid->getName(), nullptr, nullptr, {}};
    if (isVectorType(grid->type())) made.vectors = plainGrid(*asVec3Grid(grid, ctx), place, ctx);
    made.numbers = plainGrid(*asFloatGrid(grid, ctx), place, ctx);
    made.active = made.numbers->evalActiveVoxelBoundingBox();
    if (made.vectors) made.active.expand(made.vectors->evalActiveVoxelBoundingBox());
    constexpr int kFarthest = 1 << 30; // so that neighbours have coordinates
    if (!made.active.empty() &&
        !openvdb::CoordBBox(openvdb::Coord(-kFarthest), openvdb::Coord(kFarthest)).isInside(made.active))
      throw Error(ErrorKind::Input, place + ": grid '" + made.name + "' has voxels beyond 2^30 along an axis");
    mGrids.push_back(std::move(made));
  }
}

const VolumeGrids::Grid* VolumeGrids::find(const std::string& name) const {
  const auto found = std::find_if(mGrids.begin(), mGrids.end(), [&](const Grid& g) { return g.name == name; });
  return found == mGrids.end() ? nullptr : &*found;
}

std::shared_ptr<const VolumeGrids> readVolumeGrids(const std::filesystem::path& path,
                                                   const std::vector<std::string>& names, const RunContext& ctx) {
  return std::make_shared<const VolumeGrids>(path, names, ctx);
}

std::optional<Box> bounds(const VolumeGrids& grids, const Affine& placement) {
  openvdb::BBoxd box;
  for (const VolumeGrids::Grid& grid : grids.all()) {
    if (grid.active.empty()) continue;
    const openvdb::Vec3d low = grid.active.min().asVec3d() - 0.5, high = grid.active.max().asVec3d() + 0.5;
    for (int corner = 0; corner < 8; ++corner) {
      const openvdb::Vec3d at(corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1],
                              corner & 4 ? high[2] : low[2]);
      box.expand(linearPart(placement) * grid.numbers->transform().indexToWorld(at) + shiftOf(placement));
    }
  }
  if (box.empty()) return {};
  return Box{{box.min()[0], box.min()[1], box.min()[2]}, {box.max()[0], box.max()[1], box.max()[2]}};
}

VoxelPlaces::VoxelPlaces(const openvdb::math::Transform& grid, const Affine& placement, const Domain& domain,
                         const std::string& place) {
  const openvdb::Mat3R linear = linearPart(placement);
  if (!std::isfinite(linear.det()) || linear.det() == 0)
    throw Error(ErrorKind::Usage, place + ": the placement flattens it; give scales other than 0");
  const openvdb::Mat3R unplaced = linear.inverse(0);
  const auto indexOf = [&](const openvdb::Vec3d& world) {
    return grid.worldToIndex(unplaced * (world - shiftOf(placement)));
  };
  const openvdb::Vec3d centre = toVdb(domain.minCorner) + 0.5 * domain.voxelSize;
  mOrigin = indexOf(centre);
  openvdb::Mat3R steps;
  for (int a = 0; a < 3; ++a) {
    // Across the whole domain, so that rounding of far coordinates does not add up.
    openvdb::Vec3d far = centre;
    far[a] += domain.voxelSize * domain.dims[a];
    mSteps[a] = (indexOf(far) - mOrigin) / domain.dims[a];
    const double length = std::max({std::abs(mSteps[a][0]), std::abs(mSteps[a][1]), std::abs(mSteps[a][2])});
    mSamples[a] = static_cast<int>(std::lround(std::clamp(length, 1.0, 8.0)));
    steps.setCol(a, mSteps[a]);
  }
  mBack = steps.inverse(0);
}

void VoxelPlaces::markReach(const openvdb::CoordBBox& box, const Vec3i& brickDims, BrickSet& reach) const {
  // A voxel shows up to one voxel away, and samples lie up to half a voxel of the domain from its centres.
  openvdb::BBoxd seen;
  const openvdb::Vec3d low = box.min().asVec3d() - 1, high = box.max().asVec3d() + 1;
  for (int corner = 0; corner < 8; ++corner)
    seen.expand(mBack * (openvdb::Vec3d(corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1],
                                        corner & 4 ? high[2] : low[2]) -
                         mOrigin));
  Vec3i first, last;
  for (int a = 0; a < 3; ++a) {
    const double bricks = brickDims[a];
    first[a] = static_cast<int>(std::clamp(std::floor((seen.min()[a] - 0.5) / kBrickSize), 0.0, bricks));
    last[a] = static_cast<int>(std::clamp(std::floor((seen.max()[a] + 0.5) / kBrickSize), -1.0, bricks - 1));
  }
  reach.insertBox(first, last);
}

} // namespace volcaustic
