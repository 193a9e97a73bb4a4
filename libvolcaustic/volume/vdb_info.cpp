#include "volume/lattice.h"
#include "volume/vdb_file.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volcaustic {

namespace {

template <class T>
double magnitude(const T& value) {
  if constexpr (openvdb::VecTraits<T>::IsVec)
    return openvdb::Vec3d(value).length();
  else
    return static_cast<double>(value);
}

/// Range and mean over the active values that are finite; a tile counts as all of its voxels.
template <class GridType>
void addValueRange(const GridType& grid, GridInfo& info) {
  double minimum = std::numeric_limits<double>::infinity(), maximum = -minimum, sum = 0, count = 0;
  for (auto value = grid.cbeginValueOn(); value; ++value) {
    const double v = magnitude(*value);
    if (!std::isfinite(v)) continue;
    const auto voxels = static_cast<double>(value.getVoxelCount());
    minimum = std::min(minimum, v);
    maximum = std::max(maximum, v);
    sum += v * voxels;
    count += voxels;
  }
  if (count == 0) return;
  info.minimum = minimum;
  info.maximum = maximum;
  info.mean = sum / count;
}

Box worldBox(const openvdb::GridBase& grid, const openvdb::CoordBBox& box) {
  const openvdb::BBoxd world =
      grid.transform().indexToWorld(openvdb::BBoxd(box.min().asVec3d() - 0.5, box.max().asVec3d() + 0.5));
  return {{world.min()[0], world.min()[1], world.min()[2]}, {world.max()[0], world.max()[1], world.max()[2]}};
}

std::map<std::string, std::string> asText(const openvdb::MetaMap& map) {
  std::map<std::string, std::string> text;
  for (auto item = map.beginMeta(); item != map.endMeta(); ++item)
    if (item->second) text[item->first] = item->second->str();
  return text;
}

GridInfo describe(const openvdb::GridBase& grid) {
  GridInfo info;
  info.name = grid.getName();
  info.type = grid.type();
  info.gridClass = openvdb::GridBase::gridClassToString(grid.getGridClass());
  info.vectorType = openvdb::GridBase::vecTypeToString(grid.getVectorType());
  info.activeVoxels = grid.activeVoxelCount();
  info.leafNodes = grid.baseTree().leafCount();
  info.activeTiles = grid.baseTree().activeTileCount();
  info.memoryBytes = grid.memUsage();
  info.metadata = asText(grid);
  info.mirrored = isMirrored(grid);
  const openvdb::Vec3d h = grid.voxelSize();
  info.voxelSize = {h[0], h[1], h[2]};
  if (const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox(); !box.empty()) {
    for (int a = 0; a < 3; ++a) {
      info.indexMin[a] = box.min()[a];
      info.indexMax[a] = box.max()[a];
    }
    info.world = worldBox(grid, box);
  }
  grid.apply<openvdb::GridTypes>([&](const auto& typed) {
    using Value = typename std::decay_t<decltype(typed)>::ValueType;
    if constexpr (openvdb::VecTraits<Value>::IsVec || std::is_arithmetic_v<Value>) addValueRange(typed, info);
  });
  return info;
}

} // namespace

VdbInfo inspectVdb(const std::filesystem::path& path, const RunContext& ctx) {
  const VdbFile file = readVdbFile(path, ctx);
  VdbInfo info;
  info.metadata = asText(file.metadata);
  for (const auto& grid : file.grids) info.grids.push_back(describe(*grid));
  return info;
}

} // namespace volcaustic
