#include "volume/grids.h"
#include "volume/lattice.h"
#include "volume/radiance_grids.h"
#include "volume/scalar_grid.h"
#include "volume/vdb_file.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

constexpr int kMaxDims = 1 << 15;

[[noreturn]] void fail(const std::string& place, const std::string& what) {
  throw Error(ErrorKind::Input, place + ": " + what);
}

bool isFinite(float v) { return std::isfinite(v); }
bool isFinite(const openvdb::Vec3s& v) { return v.isFinite(); }

/// The grid as one of floats; doubles are rounded. \throws Error(Input) for another type or values that are not finite.
template <class GridType>
typename GridType::Ptr asFloats(const openvdb::GridBase::Ptr& grid, const std::string& place, const RunContext& ctx) {
  constexpr bool kScalar = std::is_same_v<GridType, openvdb::FloatGrid>;
  using Doubles = std::conditional_t<kScalar, openvdb::DoubleGrid, openvdb::Vec3DGrid>;
  if (!grid->isType<GridType>() && !grid->isType<Doubles>())
    fail(place, "grid '" + grid->getName() + "' is of type " + grid->type() + "; expected " + GridType::gridType());
  typename GridType::Ptr result;
  if constexpr (kScalar)
    result = asFloatGrid(grid, ctx);
  else
    result = asVec3Grid(grid, ctx);
  if (!isFinite(result->background()))
    fail(place, "grid '" + grid->getName() + "' has a background that is not finite");
  for (auto value = result->cbeginValueOn(); value; ++value)
    if (!isFinite(*value)) fail(place, "grid '" + grid->getName() + "' holds values that are not finite");
  return result;
}

void requireUpright(const openvdb::GridBase& grid, const std::string& place) {
  if (!isUpright(grid.transform()))
    fail(place, "grid '" + grid.getName() +
                    "' is rotated, sheared, mirrored or has voxels that are no cubes; resample it with volcaustic "
                    "convert");
}

/// The file's own box where it has one that fits the grid, else the active voxels of the grid.
Domain domainOf(const VdbFile& file, const openvdb::GridBase& grid, const std::string& place) {
  requireUpright(grid, place);
  const openvdb::CoordBBox active = grid.evalActiveVoxelBoundingBox();
  Domain domain;
  domain.voxelSize = grid.voxelSize()[0];
  openvdb::Coord first(0);
  if (const auto dims = file.metadata.getMetadata<openvdb::Vec3IMetadata>(metadata_key::kDims)) {
    for (int a = 0; a < 3; ++a) domain.dims[a] = dims->value()[a];
  } else {
    if (active.empty()) fail(place, "grid '" + grid.getName() + "' has no active voxel, so its box is unknown");
    first = active.min();
    for (int a = 0; a < 3; ++a)
      domain.dims[a] =
          static_cast<int>(std::min<std::int64_t>(std::int64_t{active.max()[a]} - active.min()[a] + 1, kMaxDims + 1));
  }
  for (int a = 0; a < 3; ++a) {
    if (domain.dims[a] < 1 || domain.dims[a] > kMaxDims)
      fail(place, "a box of " + std::to_string(domain.dims[a]) + " voxels along an axis; 1 to 32768 are possible");
    if (!active.empty() && (active.min()[a] < first[a] || std::int64_t{active.max()[a]} - first[a] >= domain.dims[a]))
      fail(place, "grid '" + grid.getName() + "' has voxels outside the file's box (" + metadata_key::kDims + ")");
  }
  const openvdb::Vec3d corner = grid.indexToWorld(first.asVec3d() - 0.5);
  domain.minCorner = {corner[0], corner[1], corner[2]};

  // A transform keeps only the centre of the first voxel; the corner itself is exact in the metadata.
  const auto exactCorner = file.metadata.getMetadata<openvdb::Vec3DMetadata>(metadata_key::kMinCorner);
  const auto exactSize = file.metadata.getMetadata<openvdb::DoubleMetadata>(metadata_key::kVoxelSize);
  const double tolerance = 1e-6 * domain.voxelSize;
  if (exactCorner && exactSize && exactCorner->value().eq(corner, tolerance) &&
      std::abs(exactSize->value() - domain.voxelSize) <= tolerance) {
    domain.voxelSize = exactSize->value();
    for (int a = 0; a < 3; ++a) domain.minCorner[a] = exactCorner->value()[a];
  }
  return domain;
}

/// The grid with the domain's transform. \throws Error(Input) when its voxels are not the domain's.
template <class GridType>
typename GridType::Ptr onDomain(const typename GridType::Ptr& grid, const Domain& domain, const std::string& place) {
  requireUpright(*grid, place);
  if (!liesOnLattice(*grid, domain))
    fail(place, "the voxels of grid '" + grid->getName() +
                    "' do not lie on those of the volume; resample it with volcaustic convert");
  return shiftedOnto<GridType>(grid, domain);
}

template <class MetadataType, class T>
T metadataOr(const VdbFile& file, const char* key, const T& otherwise) {
  const auto metadata = file.metadata.getMetadata<MetadataType>(key);
  return metadata ? metadata->value() : otherwise;
}

/// The ambient value as a double from the metadata, where it agrees with the (possibly half) background.
double ambientValue(double stored, double background) {
  return std::abs(stored - background) <= 1e-3 * std::abs(background) ? stored : background;
}

Rgb ambientRgb(const VdbFile& file, const char* key, const openvdb::Vec3SGrid::Ptr& grid) {
  const openvdb::Vec3d background = grid ? openvdb::Vec3d(grid->background()) : openvdb::Vec3d(0.0);
  const openvdb::Vec3d stored = metadataOr<openvdb::Vec3DMetadata>(file, key, background);
  Rgb value;
  for (int c = 0; c < 3; ++c) value[c] = ambientValue(stored[c], background[c]);
  return value;
}

template <class GridType>
typename GridType::Ptr gridOrNull(const VdbFile& file, const char* name, const Domain& domain, const std::string& place,
                                  const RunContext& ctx) {
  const auto grid = file.find(name);
  return grid ? onDomain<GridType>(asFloats<GridType>(grid, place, ctx), domain, place) : nullptr;
}

void requireIndexAboveZero(const openvdb::FloatGrid& index, const std::string& place) {
  bool positive = index.background() > 0;
  for (auto value = index.cbeginValueOn(); value && positive; ++value) positive = *value > 0;
  if (!positive) fail(place, "grid 'index' holds values that are not above zero; a refractive index is");
}

} // namespace

Medium readMedium(const std::filesystem::path& path, const RunContext& ctx) {
  const std::string place = path.string();
  const VdbFile file = readVdbFile(path, ctx, [&](std::span<const GridName> grids) {
    const auto found = gridsNamed({"index", "attenuation", "scattering", "coverage", "asymmetry"})(grids);
    if (std::none_of(found.begin(), found.end(), [&](std::size_t i) { return grids[i].name == "index"; }))
      fail(place, "holds no grid 'index'; it holds " + listGrids(grids));
    return found;
  });
  const auto index = asFloats<openvdb::FloatGrid>(file.find("index"), place, ctx);
  requireIndexAboveZero(*index, place);
  const Domain domain = domainOf(file, *index, place);

  MediumGrids grids;
  grids.index = onDomain<openvdb::FloatGrid>(index, domain, place);
  const auto attenuation = gridOrNull<openvdb::Vec3SGrid>(file, "attenuation", domain, place, ctx);
  const auto scattering = gridOrNull<openvdb::Vec3SGrid>(file, "scattering", domain, place, ctx);
  const auto asymmetry = gridOrNull<openvdb::FloatGrid>(file, "asymmetry", domain, place, ctx);
  grids.coverage = gridOrNull<openvdb::FloatGrid>(file, "coverage", domain, place, ctx);
  grids.attenuation = attenuation;
  grids.scattering = scattering;
  grids.asymmetry = asymmetry;

  Ambient ambient;
  const double background = index->background();
  ambient.index =
      ambientValue(metadataOr<openvdb::DoubleMetadata>(file, metadata_key::kAmbientIndex, background), background);
  ambient.attenuation = ambientRgb(file, metadata_key::kAmbientAttenuation, attenuation);
  ambient.scattering = ambientRgb(file, metadata_key::kAmbientScattering, scattering);
  const double g = metadataOr<openvdb::DoubleMetadata>(file, metadata_key::kAmbientAsymmetry, 0.0);
  ambient.asymmetry = asymmetry ? ambientValue(g, asymmetry->background()) : g;
  if (!(std::abs(ambient.asymmetry) < 1)) fail(place, "the ambient asymmetry is not between -1 and 1");
  return mediumFromGrids(domain, ambient, grids);
}

RadianceVolume readRadiance(const std::filesystem::path& path, const Domain& domain, const RunContext& ctx) {
  const std::string place = path.string();
  const VdbFile file = readVdbFile(path, ctx, [&](std::span<const GridName> grids) {
    const auto found = gridsNamed({"radiance", "direction", "caustic", "direct"})(grids);
    if (std::none_of(found.begin(), found.end(), [&](std::size_t i) { return grids[i].name == "radiance"; }))
      fail(place, "holds no grid 'radiance'; it holds " + listGrids(grids));
    return found;
  });
  if (const auto dims = file.metadata.getMetadata<openvdb::Vec3IMetadata>(metadata_key::kDims))
    if (Vec3i{dims->value()[0], dims->value()[1], dims->value()[2]} != domain.dims)
      fail(place, "was made for a volume of " + dims->str() + " voxels, the scene's has " +
                      std::to_string(domain.dims[0]) + " x " + std::to_string(domain.dims[1]) + " x " +
                      std::to_string(domain.dims[2]) + "; trace the scene again");
  const double factor = std::exp2(metadataOr<openvdb::DoubleMetadata>(file, metadata_key::kExposure, 0.0));
  if (!std::isfinite(factor) || factor <= 0) fail(place, "its exposure is not finite");

  std::uint64_t bytes = 0;
  for (const auto& grid : file.grids)
    bytes += grid->baseTree().leafCount() * kBrickVoxels * (sizeof(Vec3f) + sizeof(kernels::FluenceVoxel));
  ctx.requireMemory(bytes, place);

  const bool parts = file.find("caustic") && file.find("direct");
  const auto directions = gridOrNull<openvdb::Vec3SGrid>(file, "direction", domain, place, ctx);
  const BrickGrid<Vec3f> direction =
      directions ? fromVec3Grid(*directions, domain.dims, ctx) : BrickGrid<Vec3f>(domain.dims, {0, 0, 0});
  auto light = std::make_shared<RadianceBricks>(domain.dims);
  const auto fill = [&](FluenceGrid& part, const char* name) {
    fillFluence(part, *gridOrNull<openvdb::Vec3SGrid>(file, name, domain, place, ctx), direction, factor, ctx);
  };
  fill(light->caustic, parts ? "caustic" : "radiance");
  if (parts) fill(light->direct.stored, "direct");
  return {domain, std::move(light)};
}

} // namespace volcaustic
