#include "volcaustic/dense.h"

#include "core/nearest_word.h"
#include "core/parallel.h"
#include "volume/result_grids.h"
#include "volume/vdb_file.h"

#include <cstdlib>
#include <openvdb/tools/Dense.h>

namespace volcaustic {

namespace {

constexpr int kMost = 1 << 20; ///< voxels along an axis, so that their number fits 64 bits

GridSummary summary(const std::string& name) {
  const GridMeaning* meaning = meaningOf(name);
  return {name, meaning->unit, meaning->components};
}

[[noreturn]] void refuse(const std::string& grid, const std::vector<GridSummary>& there) {
  std::vector<std::string> names;
  for (const GridSummary& one : there) names.push_back(one.name);
  throw Error(ErrorKind::Usage, grid + ": there is no such grid; the nearest is " + nearestWord(grid, names));
}

template <class GridType>
void copy(const openvdb::GridBase& grid, const VoxelBox& box, std::span<float> out, const RunContext& ctx) {
  using Value = typename GridType::ValueType;
  const openvdb::Coord first(box.first[0], box.first[1], box.first[2]);
  const openvdb::CoordBBox inclusive(first, first.offsetBy(box.size[0] - 1, box.size[1] - 1, box.size[2] - 1));
  openvdb::tools::Dense<Value, openvdb::tools::LayoutXYZ> dense(inclusive, reinterpret_cast<Value*>(out.data()));
  withThreads(ctx, [&] { openvdb::tools::copyToDense(static_cast<const GridType&>(grid), dense); });
}

void copyBox(const openvdb::GridBase& grid, const VoxelBox& box, std::span<float> out, const RunContext& ctx) {
  const bool vectors = grid.isType<openvdb::Vec3SGrid>();
  std::uint64_t values = vectors ? 3 : 1;
  for (int a = 0; a < 3; ++a) {
    if (box.size[a] < 1 || box.size[a] > kMost || std::abs(std::int64_t{box.first[a]}) > kMost)
      throw Error(ErrorKind::Usage, grid.getName() + ": a box of voxels is 1 to 2^20 long and wide and high");
    values *= static_cast<std::uint64_t>(box.size[a]);
  }
  if (out.size() != values)
    throw Error(ErrorKind::Usage, grid.getName() + ": the box has " + std::to_string(values) + " values, the array " +
                                      std::to_string(out.size()));
  if (vectors)
    copy<openvdb::Vec3SGrid>(grid, box, out, ctx);
  else
    copy<openvdb::FloatGrid>(grid, box, out, ctx);
}

} // namespace

std::vector<GridSummary> gridsOf(const Medium& medium) {
  std::vector<GridSummary> list;
  for (const auto& grid : grids(medium)) list.push_back(summary(grid->getName()));
  return list;
}

std::vector<GridSummary> gridsOf(const PhotonResult& photons) {
  std::vector<GridSummary> list;
  for (const std::string& name : LightGrids::names(photons, true)) list.push_back(summary(name));
  return list;
}

void readVoxels(const Medium& medium, const std::string& grid, const VoxelBox& box, std::span<float> out,
                const RunContext& ctx) {
  initialiseOpenVdb();
  for (const auto& one : grids(medium))
    if (one->getName() == grid) return copyBox(*one, box, out, ctx);
  refuse(grid, gridsOf(medium));
}

void readVoxels(const PhotonResult& photons, const Medium& medium, const std::string& grid, const VoxelBox& box,
                std::span<float> out, const RunContext& ctx) {
  initialiseOpenVdb();
  const auto made = LightGrids(photons, medium, 0, ctx).make(grid);
  if (!made) refuse(grid, gridsOf(photons));
  copyBox(*made, box, out, ctx);
}

} // namespace volcaustic
