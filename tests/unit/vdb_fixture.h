// A small medium and its light, made by hand: values of every kind that the files have to carry.
#pragma once

#include "volcaustic/openvdb.h"
#include "volume/radiance_bricks.h"

#include <cmath>
#include <memory>

namespace volcaustic::test {

inline Domain ballDomain() { return {{-0.7, 0.1, 3.3}, 0.03, {45, 40, 50}}; }

/// A ball of index 1.5 with a soft rim in fog of attenuation (0.1, 0.2, 0.3); asymmetry varies.
inline Medium ballMedium(const Domain& domain = ballDomain()) {
  Ambient ambient;
  ambient.index = 1.000293;
  ambient.attenuation = {0.1, 0.2, 0.3};
  ambient.scattering = {0.05, 0.1, 0.15};
  ambient.asymmetry = 0.25;
  auto index = openvdb::FloatGrid::create(static_cast<float>(ambient.index));
  auto attenuation = openvdb::Vec3SGrid::create({0.1F, 0.2F, 0.3F});
  auto scattering = openvdb::Vec3SGrid::create({0.05F, 0.1F, 0.15F});
  auto coverage = openvdb::FloatGrid::create(0);
  auto asymmetry = openvdb::FloatGrid::create(0.25F);
  const double radius = 12;
  for (int x = 0; x < domain.dims[0]; ++x)
    for (int y = 0; y < domain.dims[1]; ++y)
      for (int z = 0; z < domain.dims[2]; ++z) {
        const double r = std::sqrt((x - 22.0) * (x - 22) + (y - 20.0) * (y - 20) + (z - 25.0) * (z - 25));
        const auto solid = static_cast<float>(std::clamp(radius + 0.5 - r, 0.0, 1.0));
        if (solid == 0) continue;
        const openvdb::Coord ijk(x, y, z);
        index->tree().setValueOn(ijk, static_cast<float>(ambient.index + solid * 0.5));
        attenuation->tree().setValueOn(ijk, {solid, 2 * solid, 0.3F});
        scattering->tree().setValueOn(ijk, {0.5F * solid, solid / 3, 0.1F});
        coverage->tree().setValueOn(ijk, solid);
        asymmetry->tree().setValueOn(ijk, 0.25F + solid * 0.5F);
      }
  for (const openvdb::GridBase::Ptr& grid : openvdb::GridPtrVec{index, attenuation, scattering, coverage, asymmetry})
    grid->setTransform(domainTransform(domain));
  return mediumFromGrids(domain, ambient, {index, attenuation, scattering, coverage, asymmetry});
}

/// Direct light as one tile-wise constant with a shadow, a caustic of awkward values in a cone.
inline RadianceVolume ballLight(const Domain& domain = ballDomain()) {
  auto light = std::make_shared<RadianceBricks>(domain.dims);
  FluenceGrid &direct = light->direct.stored, &caustic = light->caustic;
  const auto going = [](const kernels::Float3& fluence, const kernels::Float3& direction) {
    return kernels::Light{fluence, direction * kernels::luminance(fluence)};
  };
  caustic.reserve(caustic.brickCount(), {});
  for (std::int64_t b = 0; b < direct.brickCount(); ++b) {
    const Vec3i c = direct.brickCoord(b);
    if (c[2] != 0) direct.setConstant(b, going({1, 0.9F, 0.7F}, {0, 0, -1}));
    if (c[0] != 2 || c[1] != 2) continue;
    const std::int32_t slot = caustic.claim(1);
    const auto voxels = caustic.slot(slot);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const auto t = static_cast<float>(std::sin(0.37 * i + double(b)) * 0.5 + 0.5);
      voxels[i] = kernels::pack(going({t * 3.7F, t * t * 0.11F, t / 7}, {0.1F * t, -0.2F * t, -0.9F * t}));
    }
    caustic.assign(b, slot);
  }
  return {domain, light};
}

} // namespace volcaustic::test
