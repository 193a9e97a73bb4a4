#include "volume/radiance_grids.h"

#include "core/parallel.h"
#include "volume/grids.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace volcaustic {

namespace {

constexpr double kSphere = 4 * std::numbers::pi;
constexpr std::int64_t kGrain = 256; // bricks

/// Radiance of the light that `part` chooses.
template <class Part>
BrickGrid<Vec3f> radianceOfPart(const RadianceBricks& light, double factor, const RunContext& ctx, const Part& part) {
  return valuesOf(
      light,
      [&](const kernels::Light& direct, const kernels::Light& caustic) {
        const kernels::Float3 f = part(direct.fluence, caustic.fluence);
        return Vec3f{radianceOf(f.x, factor), radianceOf(f.y, factor), radianceOf(f.z, factor)};
      },
      ctx);
}

} // namespace

float radianceOf(float fluence, double factor) { return static_cast<float>(fluence / kSphere * factor); }

BrickGrid<Vec3f> combined(const BrickGrid<Vec3f>& a, const BrickGrid<Vec3f>& b, const RunContext& ctx,
                          const std::function<Vec3f(const Vec3f&, const Vec3f&)>& combine) {
  assert(a.dims() == b.dims());
  BrickGrid<Vec3f> result(a.dims(), combine(a.background(), b.background()));
  std::vector<std::int64_t> varying;
  for (std::int64_t i = 0; i < a.brickCount(); ++i) {
    if (a.isConstant(i) && b.isConstant(i))
      result.setConstant(i, combine(a.constant(i), b.constant(i)));
    else
      varying.push_back(i);
  }
  result.activate(varying);
  parallelFor(static_cast<std::int64_t>(varying.size()), kGrain, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t n = begin; n < end; ++n) {
      const std::int64_t brick = varying[n];
      const std::span<Vec3f> out = result.voxels(brick);
      for (int v = 0; v < kBrickVoxels; ++v)
        out[v] = combine(a.isConstant(brick) ? a.constant(brick) : a.voxels(brick)[v],
                         b.isConstant(brick) ? b.constant(brick) : b.voxels(brick)[v]);
    }
  });
  return result;
}

BrickGrid<Vec3f> radianceBricks(const RadianceBricks& light, double factor, const RunContext& ctx) {
  return radianceOfPart(light, factor, ctx, [](const auto& direct, const auto& caustic) { return direct + caustic; });
}
BrickGrid<Vec3f> causticBricks(const RadianceBricks& light, double factor, const RunContext& ctx) {
  return radianceOfPart(light, factor, ctx, [](const auto&, const auto& caustic) { return caustic; });
}
BrickGrid<Vec3f> directBricks(const RadianceBricks& light, double factor, const RunContext& ctx) {
  return radianceOfPart(light, factor, ctx, [](const auto& direct, const auto&) { return direct; });
}

BrickGrid<Vec3f> directionBricks(const RadianceBricks& light, const RunContext& ctx) {
  return valuesOf(
      light,
      [](const kernels::Light& direct, const kernels::Light& caustic) {
        kernels::Light all = direct;
        all += caustic;
        const kernels::Float3 d = all.meanDirection();
        return Vec3f{d.x, d.y, d.z};
      },
      ctx);
}

openvdb::Vec3SGrid::Ptr lightGrid(const BrickGrid<Vec3f>& values, const Domain& domain, const char* name) {
  auto grid = toVec3Grid(values, domain, name);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setVectorType(openvdb::VEC_INVARIANT);
  return grid;
}

openvdb::Vec3SGrid::Ptr directionGrid(const BrickGrid<Vec3f>& direction, const Domain& domain) {
  auto grid = toVec3Grid(direction, domain, "direction");
  grid->setGridClass(openvdb::GRID_UNKNOWN);
  grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
  return grid;
}

void fillFluence(FluenceGrid& light, const openvdb::Vec3SGrid& radiance, const BrickGrid<Vec3f>& direction,
                 double factor, const RunContext& ctx) {
  const BrickGrid<Vec3f> values = fromVec3Grid(radiance, light.dims(), ctx);
  const auto lightOf = [factor](const Vec3f& r, const Vec3f& d) {
    const auto fluence = kernels::Float3(kernels::Double3(r[0], r[1], r[2]) * (kSphere / factor));
    return kernels::Light{fluence, kernels::Float3(d[0], d[1], d[2]) * kernels::luminance(fluence)};
  };
  std::vector<std::int64_t> varying;
  for (std::int64_t b = 0; b < values.brickCount(); ++b)
    if (values.isConstant(b) && (direction.isConstant(b) || values.constant(b) == Vec3f{0, 0, 0}))
      light.setConstant(b, lightOf(values.constant(b), direction.isConstant(b) ? direction.constant(b) : Vec3f{}));
    else
      varying.push_back(b);
  light.reserve(static_cast<std::int64_t>(varying.size()), ctx);
  const std::int32_t first = light.claim(static_cast<std::int32_t>(varying.size()));
  parallelFor(static_cast<std::int64_t>(varying.size()), kGrain, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      const std::int64_t b = varying[i];
      const auto slot = first + static_cast<std::int32_t>(i);
      const auto voxels = light.slot(slot);
      for (int k = 0; k < kBrickVoxels; ++k)
        voxels[k] = kernels::pack(lightOf(values.isConstant(b) ? values.constant(b) : values.voxels(b)[k],
                                          direction.isConstant(b) ? direction.constant(b) : direction.voxels(b)[k]));
      light.assign(b, slot);
    }
  });
}

RadianceGrids radianceGrids(const RadianceVolume& radiance, bool parts) {
  const RunContext ctx;
  const Domain& domain = radiance.domain();
  const RadianceBricks& light = radiance.bricks();
  RadianceGrids grids;
  grids.radiance = lightGrid(radianceBricks(light, 1, ctx), domain, "radiance");
  grids.direction = directionGrid(directionBricks(light, ctx), domain);
  if (parts) {
    grids.caustic = lightGrid(causticBricks(light, 1, ctx), domain, "caustic");
    grids.direct = lightGrid(directBricks(light, 1, ctx), domain, "direct");
  }
  return grids;
}

} // namespace volcaustic
