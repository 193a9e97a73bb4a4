// Volumes made by others as media.
#include "volume/foreign_grids.h"
#include "volume/grid_values.h"
#include "volume/grids.h"
#include "volume/lattice.h"
#include "volume/optics.h"
#include "volume/scalar_grid.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace volcaustic {

namespace {

using openvdb::FloatGrid;
using openvdb::Vec3SGrid;

constexpr int kMaxDims = 1 << 15;

[[noreturn]] void fail(const std::string& place, const std::string& what) {
  throw Error(ErrorKind::Input, place + ": " + what);
}

void requireMappings(const MediumImport& import) {
  if (!import.index && !import.attenuation && !import.scattering && !import.body)
    throw Error(ErrorKind::Usage,
                "import: no grid is mapped; name one for the index, attenuation, scattering or a body");
  if (import.body && import.coverage)
    throw Error(ErrorKind::Usage, "import: coverage is the body's; map one of the two");
  if (!(import.voxelSize >= 0) || !std::isfinite(import.voxelSize))
    throw Error(ErrorKind::Usage, "import: the voxel size must be positive and finite, or 0 for the grids' own");
  if (import.padding < 0 || import.padding > kMaxDims)
    throw Error(ErrorKind::Usage, "import: " + std::to_string(import.padding) + " voxels of padding are not possible");
  for (const auto* mapping :
       {&import.index, &import.attenuation, &import.scattering, &import.asymmetry, &import.coverage})
    if (*mapping) requireFinite(**mapping, "import");
}

std::vector<std::string> mappedNames(const MediumImport& import) {
  std::vector<std::string> names;
  for (const auto* mapping :
       {&import.index, &import.attenuation, &import.scattering, &import.asymmetry, &import.coverage})
    if (*mapping) names.push_back((*mapping)->grid);
  if (import.body) names.push_back(*import.body);
  return names;
}

double smallestEdge(const openvdb::GridBase& grid) {
  const openvdb::Vec3d h = grid.voxelSize();
  return std::min({h[0], h[1], h[2]});
}

/// Around the active voxels of a grid, in the index space of `transform`; of another grid's lattice or of its own.
openvdb::BBoxd boxIn(const openvdb::math::Transform& transform, const openvdb::GridBase& grid,
                     const openvdb::CoordBBox& active) {
  const openvdb::BBoxd own(active.min().asVec3d() - 0.5, active.max().asVec3d() + 0.5);
  return transform.worldToIndex(grid.transform().indexToWorld(own));
}

/// The lattice that everything is brought to: the finest grid's own where that is upright, else of cubes of its
/// smallest edge.
Domain domainOf(const openvdb::GridPtrVec& grids, const MediumImport& import, const std::string& place) {
  const auto finest = std::min_element(
      grids.begin(), grids.end(), [](const auto& a, const auto& b) { return smallestEdge(*a) < smallestEdge(*b); });
  Domain domain;
  domain.voxelSize = import.voxelSize > 0 ? import.voxelSize : smallestEdge(**finest);
  if (domain.voxelSize < kSmallestVoxel)
    fail(place,
         "voxels under 1.45e-5 world units cannot be in a transform of OpenVDB; choose larger ones, or another unit");
  auto lattice = openvdb::math::Transform::createLinearTransform(domain.voxelSize);
  if (import.voxelSize == 0 && isUpright((*finest)->transform())) lattice = (*finest)->transformPtr();

  openvdb::BBoxd box;
  for (const auto& grid : grids)
    if (const openvdb::CoordBBox active = grid->evalActiveVoxelBoundingBox(); !active.empty())
      box.expand(boxIn(*lattice, *grid, active));
  if (box.empty()) fail(place, "the mapped grids have no active voxel, so there is no box");
  openvdb::Vec3d first;
  for (int a = 0; a < 3; ++a) {
    // A side of whole voxels must not become one more by rounding.
    const double low = std::floor(box.min()[a] + 0.5 + 1e-3) - import.padding;
    const double voxels = std::ceil(box.max()[a] + 0.5 - 1e-3) + import.padding - low;
    if (!(voxels >= 1 && voxels <= kMaxDims))
      fail(place, "more than 32768 voxels of " + std::to_string(domain.voxelSize) +
                      " along an axis; choose a larger voxel size");
    first[a] = low;
    domain.dims[a] = static_cast<int>(voxels);
  }
  const openvdb::Vec3d corner = lattice->indexToWorld(first - 0.5);
  domain.minCorner = {corner[0], corner[1], corner[2]};
  return domain;
}

/// The mapped grids of one file, each on the domain's voxels.
class Source {
public:
  Source(const VdbFile& file, const MediumImport& import, const std::string& place, const RunContext& ctx)
      : mFile(file), mPlace(place), mCtx(ctx) {
    for (const auto& grid : file.grids) requireLinear(*grid, place);
    mDomain = domainOf(file.grids, import, place);
    for (const auto& grid : file.grids)
      if (!liesOnLattice(*grid, mDomain)) tellResampled(*grid);
  }

  [[nodiscard]] const Domain& domain() const { return mDomain; }
  [[nodiscard]] const std::string& place() const { return mPlace; }

  [[nodiscard]] FloatGrid::Ptr scalar(const std::string& name) const {
    return placed<FloatGrid>(*asFloatGrid(mFile.find(name), mCtx));
  }
  [[nodiscard]] bool isVector(const std::string& name) const { return isVectorType(mFile.find(name)->type()); }
  [[nodiscard]] Vec3SGrid::Ptr vector(const std::string& name) const {
    return placed<Vec3SGrid>(*asVec3Grid(mFile.find(name), mCtx));
  }

private:
  template <class GridType>
  [[nodiscard]] typename GridType::Ptr placed(const GridType& grid) const {
    // What is inside a level set is not active, and resampling looks at active values only. The new grid is no level
    // set by name, or it would be rebuilt as one.
    const auto plain =
        mappedGrid<GridType>(grid, Active::OtherThanNothing, mCtx, [](const auto& value) { return value; });
    return liesOnLattice(grid, mDomain)
               ? shiftedOnto<GridType>(plain, mDomain)
               : resampledOnto(*plain, mDomain, mPlace + ": grid '" + grid.getName() + "'", mCtx);
  }

  void tellResampled(const openvdb::GridBase& grid) const {
    const openvdb::Vec3d h = grid.voxelSize();
    std::ostringstream line;
    line << mPlace << ": grid '" << grid.getName() << "' with voxels of " << h[0] << " x " << h[1] << " x " << h[2]
         << (isUpright(grid.transform()) ? "" : ", rotated or no cubes,") << " is resampled to cubes of "
         << mDomain.voxelSize;
    mCtx.log(LogLevel::Info, line.str());
  }

  const VdbFile& mFile;
  const std::string& mPlace;
  const RunContext& mCtx;
  Domain mDomain;
};

FloatGrid::Ptr mappedScalar(const Source& source, const char* property, const GridMapping& mapping, float low,
                            float high, const RunContext& ctx) {
  MappedRange range(low, high);
  auto result = mappedGrid<FloatGrid>(*source.scalar(mapping.grid), Active::OtherThanNothing, ctx,
                                      [&](float value) { return range(mapping, 0, value); });
  range.report(property, mapping.grid, source.place(), ctx);
  return result;
}

Vec3SGrid::Ptr mappedSpectrum(const Source& source, const char* property, const GridMapping& mapping,
                              const RunContext& ctx) {
  MappedRange range(0, kLargestCoefficient);
  const auto rgb = [&](float r, float g, float b) {
    return openvdb::Vec3s(range(mapping, 0, r), range(mapping, 1, g), range(mapping, 2, b));
  };
  Vec3SGrid::Ptr result;
  if (source.isVector(mapping.grid))
    result = mappedGrid<Vec3SGrid>(*source.vector(mapping.grid), Active::OtherThanNothing, ctx,
                                   [&](const openvdb::Vec3s& v) { return rgb(v[0], v[1], v[2]); });
  else
    result = mappedGrid<Vec3SGrid>(*source.scalar(mapping.grid), Active::OtherThanNothing, ctx,
                                   [&](float v) { return rgb(v, v, v); });
  range.report(property, mapping.grid, source.place(), ctx);
  return result;
}

/// Of a level set half a voxel on either side of the surface is a ramp; a fog volume is coverage itself.
FloatGrid::Ptr bodyCoverage(const Source& source, const std::string& name, bool isLevelSet, const RunContext& ctx) {
  const auto h = static_cast<float>(source.domain().voxelSize);
  MappedRange finite(-std::numeric_limits<float>::max(), std::numeric_limits<float>::max());
  auto result = mappedGrid<FloatGrid>(*source.scalar(name), Active::OtherThanNothing, ctx, [&](float value) {
    finite(value);
    return std::clamp(isLevelSet ? 0.5f - value / h : value, 0.0f, 1.0f);
  });
  finite.report("body", name, source.place(), ctx);
  return result;
}

Rgb backgroundOf(const Vec3SGrid& grid) { return {grid.background()[0], grid.background()[1], grid.background()[2]}; }

openvdb::Vec3s blend(const Rgb& outside, const Rgb& inside, float coverage) {
  openvdb::Vec3s value;
  for (int c = 0; c < 3; ++c) value[c] = static_cast<float>(outside[c] + coverage * (inside[c] - outside[c]));
  return value;
}

/// What the body is made of, for every property that has no grid yet.
void addBody(MediumGrids& grids, const FloatGrid& coverage, const MediumImport& import, const Domain& domain,
             const RunContext& ctx) {
  const Material& inside = import.material;
  const Ambient& outside = import.ambient;
  if (!grids.index) {
    const auto sharp = mappedGrid<FloatGrid>(coverage, Active::OtherThanNothing, ctx, [&](float c) {
      return static_cast<float>(outside.index + c * (inside.index - outside.index));
    });
    const BrickGrid<float> bricks = fromFloatGrid(*sharp, domain.dims, ctx);
    grids.index = toFloatGrid(gaussianBlur(bricks, import.blur, ctx), domain, "index", ctx);
  }
  const auto spectrum = [&](const Rgb& from, const Rgb& to) {
    return mappedGrid<Vec3SGrid>(coverage, Active::OtherThanNothing, ctx, [&](float c) { return blend(from, to, c); });
  };
  if (!grids.attenuation) grids.attenuation = spectrum(outside.attenuation, inside.attenuation);
  if (!grids.scattering) grids.scattering = spectrum(outside.scattering, inside.scattering);
  if (!grids.asymmetry && inside.asymmetry != outside.asymmetry)
    grids.asymmetry = mappedGrid<FloatGrid>(coverage, Active::OtherThanNothing, ctx, [&](float c) {
      return static_cast<float>(outside.asymmetry + c * (inside.asymmetry - outside.asymmetry));
    });
}

/// \throws Error(Input) where more is scattered than is attenuated.
void requireScatteringBelow(const Vec3SGrid& attenuation, const Vec3SGrid& scattering, const std::string& place) {
  const auto limit = attenuation.getConstAccessor();
  const auto within = [](const openvdb::Vec3s& s, const openvdb::Vec3s& t) {
    constexpr float kRounding = 1 + 1e-5f;
    return s[0] <= t[0] * kRounding && s[1] <= t[1] * kRounding && s[2] <= t[2] * kRounding;
  };
  bool fits = within(scattering.background(), attenuation.background());
  for (auto value = scattering.cbeginValueOn(); value && fits; ++value)
    fits = within(*value, limit.getValue(value.getCoord()));
  if (!fits)
    fail(place,
         "scattering is more than attenuation somewhere, which includes it; lower its scale or raise the other's");
}

/// The properties that a grid is named for, and the ambient values that their backgrounds are.
MediumGrids mappedProperties(const Source& source, const MediumImport& import, Ambient& ambient,
                             const RunContext& ctx) {
  MediumGrids grids;
  if (import.index) {
    const auto index = mappedScalar(source, "index", *import.index, -std::numeric_limits<float>::max(),
                                    std::numeric_limits<float>::max(), ctx);
    bool positive = index->background() > 0;
    for (auto value = index->cbeginValueOn(); value && positive; ++value) positive = *value > 0;
    if (!positive)
      fail(source.place(), "grid '" + import.index->grid +
                               "' becomes an index that is not above zero somewhere; see its scale and offset");
    ambient.index = index->background();
    grids.index = index;
  }
  const auto& attenuation = import.attenuation ? import.attenuation : import.body ? std::nullopt : import.scattering;
  if (attenuation) {
    grids.attenuation = mappedSpectrum(source, "attenuation", *attenuation, ctx);
    ambient.attenuation = backgroundOf(*grids.attenuation);
  }
  if (import.scattering) {
    grids.scattering = mappedSpectrum(source, "scattering", *import.scattering, ctx);
    ambient.scattering = backgroundOf(*grids.scattering);
  }
  if (import.asymmetry) {
    const auto asymmetry = mappedScalar(source, "asymmetry", *import.asymmetry, -kForwardMost, kForwardMost, ctx);
    ambient.asymmetry = asymmetry->background();
    grids.asymmetry = asymmetry;
  }
  if (import.coverage) grids.coverage = mappedScalar(source, "coverage", *import.coverage, 0, 1, ctx);
  return grids;
}

} // namespace

Medium importMedium(const std::filesystem::path& path, const MediumImport& import, const RunContext& ctx) {
  requireMappings(import);
  const std::string place = path.string();
  const VdbFile file = readVdbFile(path, ctx, mappableGrids(place, mappedNames(import)));
  const Source source(file, import, place, ctx);
  ctx.progress("map", 0);
  Ambient ambient = import.ambient;
  MediumGrids grids = mappedProperties(source, import, ambient, ctx);
  if (import.body) {
    const bool isLevelSet = file.find(*import.body)->getGridClass() == openvdb::GRID_LEVEL_SET;
    const auto coverage = bodyCoverage(source, *import.body, isLevelSet, ctx);
    grids.coverage = coverage;
    addBody(grids, *coverage, import, source.domain(), ctx);
  }
  if (!grids.index) {
    auto index = FloatGrid::create(static_cast<float>(ambient.index));
    index->setTransform(domainTransform(source.domain()));
    grids.index = index;
  }
  if (grids.attenuation && grids.scattering) requireScatteringBelow(*grids.attenuation, *grids.scattering, place);
  ctx.progress("map", 1);
  return mediumFromGrids(source.domain(), ambient, std::move(grids));
}

} // namespace volcaustic
