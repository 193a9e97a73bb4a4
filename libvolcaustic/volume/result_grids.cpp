#include "volume/result_grids.h"

#include "volume/grids.h"
#include "volume/radiance_grids.h"
#include "volume/vdb_file.h"

#include <cmath>

namespace volcaustic {

namespace {

constexpr GridMeaning kMeanings[] = {
    {"index", "n", "1", 1},
    {"attenuation", "sigma_t", "1/world", 3},
    {"scattering", "sigma_s", "1/world", 3},
    {"asymmetry", "g", "1", 1},
    {"coverage", "c", "1", 1},
    {"radiance", "L", "W/(m2 sr)", 3},
    {"caustic", "L_caustic", "W/(m2 sr)", 3},
    {"direct", "L_direct", "W/(m2 sr)", 3},
    {"direction", "d", "1", 3},
    {"emission", "sigma_s L", "W/(m3 sr)", 3},
    {"density", "Y(sigma_t)", "1/world", 1},
};

/// Shares the tree under our name and class, and says what the values mean.
template <class GridType>
openvdb::GridBase::Ptr described(const std::shared_ptr<GridType>& grid, const char* name,
                                 openvdb::GridClass gridClass) {
  auto copy = std::const_pointer_cast<std::remove_const_t<GridType>>(grid)->copyGrid();
  copy->setName(name);
  copy->setGridClass(gridClass);
  if (grid->template isType<openvdb::Vec3SGrid>())
    copy->setVectorType(std::string_view(name) == "direction" ? openvdb::VEC_CONTRAVARIANT_RELATIVE
                                                              : openvdb::VEC_INVARIANT);
  if (const GridMeaning* meaning = meaningOf(name)) {
    copy->insertMeta("symbol", openvdb::StringMetadata(meaning->symbol));
    copy->insertMeta("unit", openvdb::StringMetadata(meaning->unit));
  }
  return copy;
}

/// Isotropically re-emitted light, scattering times radiance.
BrickGrid<Vec3f> emissionBricks(const BrickGrid<Vec3f>& radiance, const Medium& medium, const RunContext& ctx) {
  const BrickGrid<Vec3f> scattering = fromVec3Grid(*medium.grids().scattering, radiance.dims(), ctx);
  return combined(scattering, radiance, ctx, [](const Vec3f& s, const Vec3f& l) {
    return Vec3f{s[0] * l[0], s[1] * l[1], s[2] * l[2]};
  });
}

/// Luminance of the attenuation, active wherever it is not zero: also where it is the ambient one.
openvdb::FloatGrid::Ptr densityGrid(const Medium& medium, const RunContext& ctx) {
  const auto luminance = [](const Vec3f& c) {
    return static_cast<float>(0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]);
  };
  const BrickGrid<Vec3f> attenuation = fromVec3Grid(*medium.grids().attenuation, medium.domain().dims, ctx);
  BrickGrid<float> density(attenuation.dims(), 0);
  for (std::int64_t b = 0; b < attenuation.brickCount(); ++b) {
    if (attenuation.isConstant(b)) {
      density.setConstant(b, luminance(attenuation.constant(b)));
      continue;
    }
    const std::span<float> out = density.allocate(b);
    for (int v = 0; v < kBrickVoxels; ++v) out[v] = luminance(attenuation.voxels(b)[v]);
  }
  return toFloatGrid(density, medium.domain(), "density");
}

} // namespace

const GridMeaning* meaningOf(std::string_view grid) {
  const std::string_view kind = grid.substr(0, grid.find('_')); // of which light
  for (const GridMeaning& meaning : kMeanings)
    if (meaning.name == kind) return &meaning;
  return nullptr;
}

openvdb::GridPtrVec grids(const Medium& medium) {
  const MediumGrids& grids = medium.grids();
  openvdb::GridPtrVec list{described(grids.index, "index", openvdb::GRID_UNKNOWN),
                           described(grids.attenuation, "attenuation", openvdb::GRID_FOG_VOLUME),
                           described(grids.scattering, "scattering", openvdb::GRID_FOG_VOLUME),
                           described(grids.coverage, "coverage", openvdb::GRID_FOG_VOLUME)};
  if (grids.asymmetry) list.push_back(described(grids.asymmetry, "asymmetry", openvdb::GRID_UNKNOWN));
  return list;
}

LightGrids::LightGrids(const PhotonResult& photons, const Medium& medium, double exposure, const RunContext& ctx)
    : mPhotons(photons), mMedium(medium), mExposure(exposure), mFactor(std::exp2(exposure)), mCtx(ctx) {}

std::vector<std::string> LightGrids::names(const PhotonResult& photons, bool parts) {
  std::vector<std::string> names{"radiance", "direction", "emission", "density"};
  if (parts) names.insert(names.end(), {"caustic", "direct"});
  for (const PhotonResult& one : photons.lights) {
    names.push_back("radiance_" + one.light);
    if (parts) names.insert(names.end(), {"caustic_" + one.light, "direct_" + one.light});
  }
  return names;
}

openvdb::GridBase::Ptr LightGrids::light(const BrickGrid<Vec3f>& values, const std::string& name) const {
  auto grid =
      described(lightGrid(values, mPhotons.radiance.domain(), name.c_str()), name.c_str(), openvdb::GRID_FOG_VOLUME);
  grid->insertMeta(metadata_key::kExposure, openvdb::DoubleMetadata(mExposure));
  return grid;
}

const BrickGrid<Vec3f>& LightGrids::total() {
  if (!mTotal) mTotal = radianceBricks(mPhotons.radiance.bricks(), mFactor, mCtx);
  return *mTotal;
}

openvdb::GridBase::Ptr LightGrids::make(const std::string& name) {
  const RadianceVolume& all = mPhotons.radiance;
  if (name == "radiance") return light(total(), name);
  if (name == "emission") return light(emissionBricks(total(), mMedium, mCtx), name);
  if (name == "density") return described(densityGrid(mMedium, mCtx), "density", openvdb::GRID_FOG_VOLUME);
  if (name == "direction")
    return described(directionGrid(directionBricks(all.bricks(), mCtx), all.domain()), "direction",
                     openvdb::GRID_UNKNOWN);
  const std::size_t split = name.find('_');
  const std::string kind = name.substr(0, split);
  const RadianceBricks* bricks = split == std::string::npos ? &all.bricks() : nullptr;
  for (const PhotonResult& one : mPhotons.lights)
    if (split != std::string::npos && name.substr(split + 1) == one.light) bricks = &one.radiance.bricks();
  if (!bricks) return nullptr;
  if (kind == "radiance") return light(radianceBricks(*bricks, mFactor, mCtx), name);
  if (kind == "caustic") return light(causticBricks(*bricks, mFactor, mCtx), name);
  if (kind == "direct") return light(directBricks(*bricks, mFactor, mCtx), name);
  return nullptr;
}

} // namespace volcaustic
