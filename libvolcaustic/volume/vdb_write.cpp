#include "volume/grids.h"
#include "volume/radiance_grids.h"
#include "volume/vdb_file.h"

#include <cmath>
#include <functional>

namespace volcaustic {

namespace {

struct GridMeaning {
  const char *name, *symbol, *unit;
};
constexpr GridMeaning kMeanings[] = {
    {"index", "n", "1"},
    {"attenuation", "sigma_t", "1/world"},
    {"scattering", "sigma_s", "1/world"},
    {"asymmetry", "g", "1"},
    {"coverage", "c", "1"},
    {"radiance", "L", "W/(m2 sr)"},
    {"caustic", "L_caustic", "W/(m2 sr)"},
    {"direct", "L_direct", "W/(m2 sr)"},
    {"direction", "d", "1"},
    {"emission", "sigma_s L", "W/(m3 sr)"},
    {"density", "Y(sigma_t)", "1/world"},
};

openvdb::Vec3d toVdb(const Vec3d& v) { return {v[0], v[1], v[2]}; }

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
  const std::string_view kind = std::string_view(name).substr(0, std::string_view(name).find('_')); // of which light
  for (const GridMeaning& meaning : kMeanings)
    if (meaning.name == kind) {
      copy->insertMeta("symbol", openvdb::StringMetadata(meaning.symbol));
      copy->insertMeta("unit", openvdb::StringMetadata(meaning.unit));
    }
  return copy;
}

openvdb::MetaMap fileMetadata(const Medium& medium) {
  const Domain& domain = medium.domain();
  const Ambient& ambient = medium.ambient();
  openvdb::MetaMap map;
  map.insertMeta(metadata_key::kDims, openvdb::Vec3IMetadata({domain.dims[0], domain.dims[1], domain.dims[2]}));
  map.insertMeta(metadata_key::kMinCorner, openvdb::Vec3DMetadata(toVdb(domain.minCorner)));
  map.insertMeta(metadata_key::kVoxelSize, openvdb::DoubleMetadata(domain.voxelSize));
  map.insertMeta(metadata_key::kAmbientIndex, openvdb::DoubleMetadata(ambient.index));
  map.insertMeta(metadata_key::kAmbientAttenuation, openvdb::Vec3DMetadata(toVdb(ambient.attenuation)));
  map.insertMeta(metadata_key::kAmbientScattering, openvdb::Vec3DMetadata(toVdb(ambient.scattering)));
  map.insertMeta(metadata_key::kAmbientAsymmetry, openvdb::DoubleMetadata(ambient.asymmetry));
  return map;
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

void writeVdb(const std::filesystem::path& path, const Medium& medium, const VdbWriteOptions& options,
              const RunContext& ctx) {
  initialiseOpenVdb();
  const MediumGrids& grids = medium.grids();
  openvdb::GridPtrVec list{described(grids.index, "index", openvdb::GRID_UNKNOWN),
                           described(grids.attenuation, "attenuation", openvdb::GRID_FOG_VOLUME),
                           described(grids.scattering, "scattering", openvdb::GRID_FOG_VOLUME),
                           described(grids.coverage, "coverage", openvdb::GRID_FOG_VOLUME)};
  if (grids.asymmetry) list.push_back(described(grids.asymmetry, "asymmetry", openvdb::GRID_UNKNOWN));
  writeVdbFile(path, list, fileMetadata(medium), options, ctx);
}

void writeVdb(const std::filesystem::path& path, const PhotonResult& photons, const Medium& medium,
              const VdbWriteOptions& options, const RunContext& ctx) {
  initialiseOpenVdb();
  const RadianceVolume& radiance = photons.radiance;
  const Domain& domain = radiance.domain();
  if (domain.dims != medium.domain().dims)
    throw Error(ErrorKind::Usage, path.string() + ": the radiance volume and the medium have different domains");
  const RadianceBricks& light = radiance.bricks();
  const double factor = std::exp2(options.exposure);
  // All grids at once, and bricks of two of them.
  const std::size_t parts = options.parts ? 3 : 1;
  ctx.requireMemory(light.varyingBricks().size() * kBrickVoxels * sizeof(Vec3f) *
                        (5 + parts * (1 + photons.lights.size())),
                    path.string());

  openvdb::GridPtrVec list;
  const auto addLight = [&](const BrickGrid<Vec3f>& values, const std::string& name) {
    list.push_back(described(lightGrid(values, domain, name.c_str()), name.c_str(), openvdb::GRID_FOG_VOLUME));
    list.back()->insertMeta(metadata_key::kExposure, openvdb::DoubleMetadata(options.exposure));
  };
  const BrickGrid<Vec3f> total = radianceBricks(light, factor, ctx);
  addLight(total, "radiance");
  list.push_back(described(directionGrid(directionBricks(light, ctx), domain), "direction", openvdb::GRID_UNKNOWN));
  addLight(emissionBricks(total, medium, ctx), "emission");
  list.push_back(described(densityGrid(medium, ctx), "density", openvdb::GRID_FOG_VOLUME));
  const auto addParts = [&](const RadianceBricks& of, const std::string& suffix) {
    if (!options.parts) return;
    addLight(causticBricks(of, factor, ctx), "caustic" + suffix);
    addLight(directBricks(of, factor, ctx), "direct" + suffix);
  };
  addParts(light, "");
  for (const PhotonResult& one : photons.lights) {
    addLight(radianceBricks(one.radiance.bricks(), factor, ctx), "radiance_" + one.light);
    addParts(one.radiance.bricks(), "_" + one.light);
  }
  openvdb::MetaMap metadata = fileMetadata(medium);
  metadata.insertMeta(metadata_key::kExposure, openvdb::DoubleMetadata(options.exposure));
  writeVdbFile(path, list, metadata, options, ctx);
}

void writeVdb(const std::filesystem::path& path, const RadianceVolume& radiance, const Medium& medium,
              const VdbWriteOptions& options, const RunContext& ctx) {
  PhotonResult photons;
  photons.radiance = radiance;
  writeVdb(path, photons, medium, options, ctx);
}

} // namespace volcaustic
