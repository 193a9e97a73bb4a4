#include "volume/vdb_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace volcaustic {

namespace {

/// Sums over values that stand for several voxels.
class Accumulator {
public:
  void add(double a, double b, double voxels) {
    double difference = std::abs(a - b);
    if (a == b || (std::isnan(a) && std::isnan(b)))
      difference = 0;
    else if (!std::isfinite(difference))
      difference = std::numeric_limits<double>::infinity();
    mAbsolute += difference * voxels;
    mSquare += difference * difference * voxels;
    mMaximum = std::max(mMaximum, difference);
    mA += a * voxels;
    mB += b * voxels;
    mCount += voxels;
  }
  [[nodiscard]] Difference finish(std::string name) const {
    if (mCount == 0) return {.name = std::move(name)};
    return {std::move(name), mAbsolute / mCount, std::sqrt(mSquare / mCount), mMaximum, mA / mCount, mB / mCount};
  }

private:
  double mAbsolute = 0, mSquare = 0, mMaximum = 0, mA = 0, mB = 0, mCount = 0;
};

template <class T>
void addValue(Accumulator& sums, const T& a, const T& b, double voxels) {
  if constexpr (openvdb::VecTraits<T>::IsVec)
    for (int c = 0; c < openvdb::VecTraits<T>::Size; ++c) sums.add(double(a[c]), double(b[c]), voxels);
  else
    sums.add(double(a), double(b), voxels);
}

template <class GridType>
Difference compareGrids(const GridType& a, const GridType& b) {
  // Where either tree has a node below, so has the union: each of its tiles is one value in both.
  openvdb::MaskTree both(a.tree(), false, openvdb::TopologyCopy());
  both.topologyUnion(b.tree());
  const auto accessA = a.getConstAccessor(), accessB = b.getConstAccessor();
  Accumulator sums;
  for (auto mask = both.cbeginValueOn(); mask; ++mask) {
    const openvdb::Coord at = mask.getBoundingBox().min();
    addValue(sums, accessA.getValue(at), accessB.getValue(at), static_cast<double>(mask.getVoxelCount()));
  }
  return sums.finish(a.getName());
}

bool sameTransform(const openvdb::math::Transform& a, const openvdb::math::Transform& b) {
  if (a == b) return true;
  if (!a.isLinear() || !b.isLinear()) return false;
  const double tolerance = 1e-6 * a.voxelSize().length();
  for (const openvdb::Vec3d corner :
       {openvdb::Vec3d(0, 0, 0), openvdb::Vec3d(1, 0, 0), openvdb::Vec3d(0, 1, 0), openvdb::Vec3d(0, 0, 1)})
    if (!a.indexToWorld(corner).eq(b.indexToWorld(corner), tolerance)) return false;
  return true;
}

void requireGridsOf(const VdbFile& have, const VdbFile& want, const std::string& place, const std::string& other) {
  for (const auto& grid : want.grids)
    if (!have.find(grid->getName()))
      throw Error(ErrorKind::Input, place + ": has no grid '" + grid->getName() + "', which " + other + " has");
}

} // namespace

std::vector<Difference> compareVdb(const std::filesystem::path& a, const std::filesystem::path& b,
                                   const RunContext& ctx) {
  const VdbFile fileA = readVdbFile(a, ctx), fileB = readVdbFile(b, ctx);
  requireGridsOf(fileA, fileB, a.string(), b.string());
  requireGridsOf(fileB, fileA, b.string(), a.string());
  std::vector<Difference> differences;
  for (const auto& gridA : fileA.grids) {
    const auto gridB = fileB.find(gridA->getName());
    const std::string place = b.string() + ": grid '" + gridA->getName() + "'";
    if (gridA->type() != gridB->type())
      throw Error(ErrorKind::Input,
                  place + " is of type " + gridB->type() + ", in " + a.string() + " of type " + gridA->type());
    if (!sameTransform(gridA->transform(), gridB->transform()))
      throw Error(ErrorKind::Input, place + " has another transform than in " + a.string() + "; resample one of them");
    const bool known = gridA->apply<openvdb::GridTypes>([&](const auto& typed) {
      using GridType = std::decay_t<decltype(typed)>;
      using Value = typename GridType::ValueType;
      if constexpr (openvdb::VecTraits<Value>::IsVec || std::is_arithmetic_v<Value>)
        differences.push_back(compareGrids(typed, static_cast<const GridType&>(*gridB)));
      else
        throw Error(ErrorKind::Input, place + " is of type " + gridA->type() + ", whose values cannot be subtracted");
    });
    if (!known) throw Error(ErrorKind::Input, place + " is of type " + gridA->type() + ", which cannot be compared");
  }
  return differences;
}

} // namespace volcaustic
