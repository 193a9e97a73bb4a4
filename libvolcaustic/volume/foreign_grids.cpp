#include "volume/foreign_grids.h"

#include "volume/scalar_grid.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace volcaustic {

GridSelection mappableGrids(const std::string& place, const std::vector<std::string>& names) {
  return [=](std::span<const GridName> grids) {
    for (const std::string& name : names) {
      const auto found = std::find_if(grids.begin(), grids.end(), [&](const GridName& g) { return g.name == name; });
      if (found == grids.end())
        throw Error(ErrorKind::Input, place + ": holds no grid '" + name + "'; it holds " + listGrids(grids));
      if (!isScalarType(found->type) && !isVectorType(found->type))
        throw Error(ErrorKind::Input, place + ": grid '" + name + "' is of type " + found->type +
                                          ", which holds no field of numbers or vectors");
    }
    return gridsNamed(names)(grids);
  };
}

void requireLinear(const openvdb::GridBase& grid, const std::string& place) {
  if (!grid.transform().isLinear())
    throw Error(ErrorKind::Input,
                place + ": grid '" + grid.getName() +
                    "' has a frustum for a transform; resample it to a box in the program that made it");
}

void requireFinite(const GridMapping& mapping, const std::string& place) {
  for (int c = 0; c < 3; ++c)
    if (!std::isfinite(mapping.scale[c]) || !std::isfinite(mapping.offset[c]))
      throw Error(ErrorKind::Usage, place + ": scale and offset of grid '" + mapping.grid + "' must be finite");
}

float MappedRange::operator()(float value) {
  if (!std::isfinite(value)) mNotFinite = true;
  const float kept = std::clamp(value, mLow, mHigh);
  if (kept != value) mClamped = true;
  return kept;
}

float MappedRange::operator()(const GridMapping& mapping, int channel, float value) {
  const double mapped = mapping.offset[channel] + mapping.scale[channel] * value;
  const double rounding = 1e-6 * std::abs(mapping.offset[channel]);
  if (mapped < mLow && mapped >= mLow - rounding) return mLow;
  if (mapped > mHigh && mapped <= mHigh + rounding) return mHigh;
  return (*this)(static_cast<float>(mapped));
}

void MappedRange::report(const std::string& property, const std::string& grid, const std::string& place,
                         const RunContext& ctx) const {
  if (mNotFinite) throw Error(ErrorKind::Input, place + ": grid '" + grid + "' holds values that are not finite");
  if (!mClamped) return;
  std::ostringstream line;
  line << place << ": " << property << ": values of grid '" << grid << "' beyond " << mLow << " to " << mHigh
       << " were clamped; see its scale and offset";
  ctx.warn(line.str());
}

} // namespace volcaustic
