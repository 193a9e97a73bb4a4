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

/// Applies `change` to every value in place.
void changeAll(BrickGrid<Vec3f>& bricks, const RunContext& ctx, const std::function<Vec3f(const Vec3f&)>& change) {
  parallelFor(bricks.brickCount(), kGrain, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t b = begin; b < end; ++b) {
      if (bricks.isConstant(b))
        bricks.setConstant(b, change(bricks.constant(b)));
      else
        for (Vec3f& v : bricks.voxels(b)) v = change(v);
    }
  });
}

} // namespace

float radianceOf(float fluence, double factor) { return static_cast<float>(fluence / kSphere * factor); }

float fluenceOf(float radiance, double factor) {
  const auto fluence = static_cast<float>(radiance * kSphere / factor);
  for (const float candidate : {fluence, std::nextafter(fluence, INFINITY), std::nextafter(fluence, -INFINITY)})
    if (radianceOf(candidate, factor) == radiance) return candidate;
  return fluence;
}

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

BrickGrid<Vec3f> radianceBricks(BrickGrid<Vec3f> fluence, double factor, const RunContext& ctx) {
  changeAll(fluence, ctx, [factor](const Vec3f& f) {
    return Vec3f{radianceOf(f[0], factor), radianceOf(f[1], factor), radianceOf(f[2], factor)};
  });
  return fluence;
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

BrickGrid<Vec3f> fluenceBricks(const openvdb::Vec3SGrid& radiance, const Vec3i& dims, double factor,
                               const RunContext& ctx) {
  BrickGrid<Vec3f> bricks = fromVec3Grid(radiance, dims, ctx);
  changeAll(bricks, ctx, [factor](const Vec3f& r) {
    return Vec3f{fluenceOf(r[0], factor), fluenceOf(r[1], factor), fluenceOf(r[2], factor)};
  });
  return bricks;
}

RadianceGrids radianceGrids(const RadianceVolume& radiance, bool parts) {
  const RunContext ctx;
  const Domain& domain = radiance.domain();
  const RadianceBricks& light = radiance.bricks();
  RadianceGrids grids;
  const auto sum = combined(light.direct, light.caustic, ctx, [](const Vec3f& d, const Vec3f& c) {
    return Vec3f{d[0] + c[0], d[1] + c[1], d[2] + c[2]};
  });
  grids.radiance = lightGrid(radianceBricks(sum, 1, ctx), domain, "radiance");
  grids.direction = directionGrid(light.direction, domain);
  if (parts) {
    grids.caustic = lightGrid(radianceBricks(light.caustic, 1, ctx), domain, "caustic");
    grids.direct = lightGrid(radianceBricks(light.direct, 1, ctx), domain, "direct");
  }
  return grids;
}

} // namespace volcaustic
