#include "volume/radiance_bricks.h"
#include "volume/result_grids.h"
#include "volume/vdb_file.h"

namespace volcaustic {

namespace {

openvdb::Vec3d toVdb(const Vec3d& v) { return {v[0], v[1], v[2]}; }

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

} // namespace

void writeVdb(const std::filesystem::path& path, const Medium& medium, const VdbWriteOptions& options,
              const RunContext& ctx) {
  initialiseOpenVdb();
  writeVdbFile(path, grids(medium), fileMetadata(medium), options, ctx);
}

void writeVdb(const std::filesystem::path& path, const PhotonResult& photons, const Medium& medium,
              const VdbWriteOptions& options, const RunContext& ctx) {
  initialiseOpenVdb();
  const RadianceVolume& radiance = photons.radiance;
  if (radiance.domain().dims != medium.domain().dims)
    throw Error(ErrorKind::Usage, path.string() + ": the radiance volume and the medium have different domains");
  // All grids at once, and bricks of two of them.
  const std::size_t parts = options.parts ? 3 : 1;
  ctx.requireMemory(radiance.bricks().varyingBricks().size() * kBrickVoxels * sizeof(Vec3f) *
                        (5 + parts * (1 + photons.lights.size())),
                    path.string());
  openvdb::GridPtrVec list;
  LightGrids light(photons, medium, options.exposure, ctx);
  for (const std::string& name : LightGrids::names(photons, options.parts)) list.push_back(light.make(name));
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
