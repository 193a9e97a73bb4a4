#include "volume/radiance_bricks.h"

#include "core/parallel.h"

namespace volcaustic {

DirectLight::DirectLight(const Vec3i& dims)
    : sets(std::size_t((dims[0] + 7) / 8) * ((dims[1] + 7) / 8) * ((dims[2] + 7) / 8)), stored(dims) {}

kernels::DirectField DirectLight::view() const {
  return {stored.view(), sets.data(), setBegins.data(), setLamps.data(), lamps.data()};
}

bool DirectLight::isConstant(std::int64_t brick) const {
  if (!stored.isDark(brick)) return stored.isConstant(brick);
  const std::int32_t set = sets[brick];
  return std::all_of(setLamps.begin() + setBegins[set], setLamps.begin() + setBegins[set + 1],
                     [this](std::int32_t lamp) { return lamps[lamp].uniform(); });
}

std::vector<std::int64_t> RadianceBricks::varyingBricks() const {
  std::vector<std::int64_t> varying;
  for (std::int64_t b = 0; b < caustic.brickCount(); ++b)
    if (!direct.isConstant(b) || !caustic.isConstant(b)) varying.push_back(b);
  return varying;
}

BrickGrid<Vec3f> valuesOf(const RadianceBricks& light, const LightValue& value, const RunContext& ctx) {
  BrickGrid<Vec3f> values(light.caustic.dims(), {0, 0, 0});
  const kernels::DirectField direct = light.direct.view();
  const kernels::FluenceField caustic = light.caustic.view();
  const auto at = [&](std::int64_t b, int k) {
    const Vec3i c = light.caustic.brickCoord(b);
    const kernels::Int3 v(8 * c[0] + (k >> 6), 8 * c[1] + (k >> 3 & 7), 8 * c[2] + (k & 7));
    return value(direct.at(v), caustic.at(v));
  };
  const std::vector<std::int64_t> varying = light.varyingBricks();
  ctx.requireMemory(varying.size() * kBrickVoxels * sizeof(Vec3f), "light volume");
  for (std::int64_t b = 0, next = 0; b < values.brickCount(); ++b) {
    if (next < static_cast<std::int64_t>(varying.size()) && varying[next] == b)
      ++next;
    else
      values.setConstant(b, at(b, 0));
  }
  values.activate(varying, Fill::Later);
  parallelFor(static_cast<std::int64_t>(varying.size()), 32, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      const auto out = values.voxels(varying[i]);
      for (int k = 0; k < kBrickVoxels; ++k) out[k] = at(varying[i], k);
    }
  });
  return values;
}

} // namespace volcaustic
