#include "volume/volume_optics.h"

#include "core/parallel.h"
#include "volcaustic/error.h"
#include "volume/foreign_grids.h"
#include "volume/volume_grids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <openvdb/tools/Interpolation.h>
#include <optional>

namespace volcaustic {

namespace {

constexpr float kLeastIndex = 0.1f, kGreatestIndex = 10; ///< as in a scene file
constexpr float kRounding = 1 + 1e-5f;

Vec3f toFloat(const Rgb& c) { return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])}; }
float sum(const Vec3f& c) { return c[0] + c[1] + c[2]; }

Vec3f grey(float value) { return {value, value, value}; }
Vec3f toSample(float value) { return grey(value); }
Vec3f toSample(const openvdb::Vec3s& value) { return {value[0], value[1], value[2]}; }

using Samples = std::array<Vec3f, kBrickVoxels>;

/// A grid on the domain's voxels.
struct Source {
  const VolumeGrids::Grid* grid;
  bool asVectors;
  VoxelPlaces places;

  [[nodiscard]] Vec3f background() const {
    return asVectors ? toSample(grid->vectors->background()) : toSample(grid->numbers->background());
  }
};

/// Samples of a source, brick by brick; one for each thread.
class Sampler {
public:
  explicit Sampler(const Source& source)
      : mPlaces(source.places)
      , mLow(source.grid->active.min().asVec3d() - 2.0)
      , mHigh(source.grid->active.max().asVec3d() + 2.0) {
    if (source.asVectors)
      mVectors.emplace(source.grid->vectors->getConstAccessor());
    else
      mNumbers.emplace(source.grid->numbers->getConstAccessor());
  }

  void run(const Vec3i& brick, Samples& out) {
    if (mVectors)
      run(*mVectors, brick, out);
    else
      run(*mNumbers, brick, out);
  }

private:
  template <class Voxels>
  void run(const Voxels& voxels, const Vec3i& brick, Samples& out) const {
    for (int v = 0; v < kBrickVoxels; ++v)
      out[v] = toSample(mean(voxels, brick[0] * kBrickSize + (v >> 6), brick[1] * kBrickSize + (v >> 3 & 7),
                             brick[2] * kBrickSize + (v & 7)));
  }
  /// In differences from the first, so that equal samples have their own value for a mean.
  template <class Voxels>
  auto mean(const Voxels& voxels, int x, int y, int z) const {
    const int i = mPlaces.samples(0), j = mPlaces.samples(1), k = mPlaces.samples(2), count = i * j * k;
    const auto at = [&](int n) {
      const openvdb::Vec3d p =
          mPlaces.at(x + (n / (j * k) + 0.5) / i - 0.5, y + (n / k % j + 0.5) / j - 0.5, z + (n % k + 0.5) / k - 0.5);
      return openvdb::tools::BoxSampler::sample(
          voxels, openvdb::math::maxComponent(mLow, openvdb::math::minComponent(mHigh, p)));
    };
    const auto first = at(0);
    auto rest = first - first;
    for (int n = 1; n < count; ++n) rest += at(n) - first;
    return first + rest * (1 / static_cast<float>(count));
  }

  const VoxelPlaces& mPlaces;
  openvdb::Vec3d mLow, mHigh; ///< beyond them is background, and where whole numbers end
  std::optional<openvdb::FloatGrid::ConstAccessor> mNumbers;
  std::optional<openvdb::Vec3SGrid::ConstAccessor> mVectors;
};

/// The medium in the voxels of a brick while volumes are added to it.
struct Mixture {
  std::array<float, kBrickVoxels> index;
  Samples attenuation, scattering;
  std::array<float, kBrickVoxels> turned; ///< asymmetry times the sum of scattering
};

const char* nameOf(OpticalProperty property) {
  constexpr std::array<const char*, 4> kNames{"index", "attenuation", "scattering", "asymmetry"};
  return kNames[static_cast<std::size_t>(property)];
}

/// One volume on a domain, and what it met there.
class PlacedVolume {
public:
  PlacedVolume(const MediumVolume& volume, const Ambient& ambient, const Domain& domain)
      : mPlace(volume.name.empty() ? "volume" : volume.name), mAmbient(ambient) {
    if (!volume.grids || volume.properties.empty())
      throw Error(ErrorKind::Usage, mPlace + ": no grid is mapped; name one for the index, attenuation or scattering");
    for (const PropertyGrid& p : volume.properties) addPart(volume, p, domain);
    if (part(OpticalProperty::Asymmetry) && !part(OpticalProperty::Scattering))
      throw Error(ErrorKind::Usage, mPlace + ": asymmetry is that of what scatters; map a grid to scattering too");
  }

  [[nodiscard]] const std::deque<Source>& sources() const { return mSources; }
  /// Whether it changes a property. Scattering alone is taken for attenuation too.
  [[nodiscard]] bool changes(OpticalProperty property) const {
    return part(property) || (property == OpticalProperty::Attenuation && part(OpticalProperty::Scattering));
  }

  void markReach(const Vec3i& brickDims, BrickSet& reach) const {
    for (const Source& source : mSources) {
      const auto mark = [&](const openvdb::CoordBBox& box) { source.places.markReach(box, brickDims, reach); };
      if (source.asVectors)
        forEachActiveBox(source.grid->vectors->tree(), mark);
      else
        forEachActiveBox(source.grid->numbers->tree(), mark);
    }
  }

  /// Of the first `count` voxels; samples of each source. Safe from several threads.
  void addTo(Mixture& mix, std::span<const Samples> samples, int count) {
    if (auto& n = part(OpticalProperty::Index)) addIndex(mix, *n, samples, count);
    auto &t = part(OpticalProperty::Attenuation), &s = part(OpticalProperty::Scattering);
    auto& g = part(OpticalProperty::Asymmetry);
    for (int v = 0; v < count && (t || s); ++v) {
      Vec3f scattering = s ? spectrum(*s, samples, v) : grey(0);
      const Vec3f attenuation = t ? spectrum(*t, samples, v) : scattering;
      for (int c = 0; c < 3; ++c) {
        if (scattering[c] > attenuation[c] * kRounding) mScattersTooMuch = true;
        scattering[c] = std::min(scattering[c], attenuation[c]);
        mix.attenuation[v][c] += attenuation[c];
        mix.scattering[v][c] += scattering[c];
      }
      const float turn = g ? g->range(g->mapping, 0, samples[g->source][v][0]) : static_cast<float>(mAmbient.asymmetry);
      mix.turned[v] += turn * sum(scattering);
    }
  }

  /// Warns of what was clamped. \throws Error(Input) for what cannot be
  void report(const RunContext& ctx) const {
    if (mIndexBeyond)
      throw Error(ErrorKind::Input, mPlace + ": grid '" + part(OpticalProperty::Index)->mapping.grid +
                                        "' becomes an index beyond 0.1 to 10 somewhere; see its scale and offset, and "
                                        "its background");
    if (mScattersTooMuch)
      throw Error(ErrorKind::Input, mPlace + ": scattering is more than attenuation somewhere, which includes it; "
                                             "lower its scale or raise the other's");
    for (std::size_t p = 0; p < mParts.size(); ++p)
      if (mParts[p])
        mParts[p]->range.report(nameOf(static_cast<OpticalProperty>(p)), mParts[p]->mapping.grid, mPlace, ctx);
  }

private:
  struct Part {
    Part(const GridMapping& m, std::size_t s, float low, float high) : mapping(m), source(s), range(low, high) {}
    GridMapping mapping;
    std::size_t source;
    MappedRange range;
  };

  void addPart(const MediumVolume& volume, const PropertyGrid& p, const Domain& domain) {
    requireFinite(p.mapping, mPlace);
    const VolumeGrids::Grid* grid = volume.grids->find(p.mapping.grid);
    if (!grid) throw Error(ErrorKind::Usage, mPlace + ": grid '" + p.mapping.grid + "' was not read from the file");
    std::optional<Part>& made = mParts[static_cast<std::size_t>(p.property)];
    if (made) throw Error(ErrorKind::Usage, mPlace + ": " + nameOf(p.property) + " has two grids; name one");
    const bool isIndex = p.property == OpticalProperty::Index, isAsymmetry = p.property == OpticalProperty::Asymmetry;
    const std::size_t source = sourceOf({grid,
                                         grid->vectors && !isIndex && !isAsymmetry,
                                         {grid->numbers->transform(), volume.placement, domain, mPlace}});
    constexpr float kAny = std::numeric_limits<float>::max();
    made.emplace(p.mapping, source,
                 isIndex       ? -kAny
                 : isAsymmetry ? -kForwardMost
                               : 0,
                 isIndex       ? kAny
                 : isAsymmetry ? kForwardMost
                               : kLargestCoefficient);
  }
  std::size_t sourceOf(Source source) {
    const auto found = std::find_if(mSources.begin(), mSources.end(), [&](const Source& s) {
      return s.grid == source.grid && s.asVectors == source.asVectors;
    });
    if (found != mSources.end()) return static_cast<std::size_t>(found - mSources.begin());
    mSources.push_back(std::move(source));
    return mSources.size() - 1;
  }

  template <class Tree, class Visit>
  static void forEachActiveBox(const Tree& tree, const Visit& visit) {
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) visit(leaf->getNodeBoundingBox());
    auto tile = tree.cbeginValueOn();
    tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1);
    for (; tile; ++tile) visit(tile.getBoundingBox());
  }

  void addIndex(Mixture& mix, Part& p, std::span<const Samples> samples, int count) {
    const auto ambient = static_cast<float>(mAmbient.index);
    for (int v = 0; v < count; ++v) {
      const float n = p.range(p.mapping, 0, samples[p.source][v][0]);
      if (!(n >= kLeastIndex && n <= kGreatestIndex)) mIndexBeyond = true;
      mix.index[v] += n - ambient;
    }
  }
  static Vec3f spectrum(Part& p, std::span<const Samples> samples, int v) {
    Vec3f value;
    for (int c = 0; c < 3; ++c) value[c] = p.range(p.mapping, c, samples[p.source][v][c]);
    return value;
  }

  [[nodiscard]] const std::optional<Part>& part(OpticalProperty property) const {
    return mParts[static_cast<std::size_t>(property)];
  }
  [[nodiscard]] std::optional<Part>& part(OpticalProperty property) {
    return mParts[static_cast<std::size_t>(property)];
  }

  std::string mPlace;
  const Ambient& mAmbient;
  std::deque<Source> mSources;
  std::array<std::optional<Part>, 4> mParts; ///< by property
  std::atomic<bool> mIndexBeyond{false}, mScattersTooMuch{false};
};

/// All volumes of a domain on its bricks.
class VolumeBlend {
public:
  VolumeBlend(OpticsBricks& optics, std::span<const MediumVolume> volumes, const Ambient& ambient, const Domain& domain,
              const RunContext& ctx)
      : mOptics(optics), mAmbient(ambient), mDomain(domain), mCtx(ctx) {
    for (const MediumVolume& volume : volumes) mVolumes.emplace_back(volume, ambient, domain);
  }

  void run() {
    addGrids();
    const std::vector<std::int64_t> bricks = bricksInReach();
    if (static_cast<std::int64_t>(bricks.size()) < mOptics.index.brickCount()) fillBackground();
    makeRoom(bricks);
    const auto count = static_cast<std::int64_t>(bricks.size());
    parallelFor(
        count, 32, mCtx,
        [&](std::int64_t begin, std::int64_t end, int) {
          std::vector<Sampler> samplers;
          for (const PlacedVolume& volume : mVolumes)
            for (const Source& source : volume.sources()) samplers.emplace_back(source);
          std::vector<Samples> samples(samplers.size());
          Mixture mix;
          for (std::int64_t i = begin; i < end; ++i) {
            const Vec3i brick = mOptics.index.brickCoord(bricks[i]);
            for (std::size_t s = 0; s < samplers.size(); ++s) samplers[s].run(brick, samples[s]);
            blend(mix, samples, kBrickVoxels);
            store(mix, bricks[i]);
          }
        },
        "volumes");
    for (const PlacedVolume& volume : mVolumes) volume.report(mCtx);
    if (mIndexBeyond)
      throw Error(ErrorKind::Input, "volumes: together they make an index beyond 0.1 to 10 somewhere; see their "
                                    "scales and offsets, and the ambient index");
  }

private:
  [[nodiscard]] bool changes(OpticalProperty property) const {
    return std::any_of(mVolumes.begin(), mVolumes.end(), [&](const PlacedVolume& v) { return v.changes(property); });
  }

  void addGrids() {
    const auto spectrum = [&](std::optional<BrickGrid<Vec3f>>& grid, OpticalProperty property, const Rgb& value) {
      if (changes(property) && !grid) grid.emplace(mDomain.dims, toFloat(value));
    };
    spectrum(mOptics.attenuation, OpticalProperty::Attenuation, mAmbient.attenuation);
    spectrum(mOptics.scattering, OpticalProperty::Scattering, mAmbient.scattering);
    if (changes(OpticalProperty::Asymmetry) && !mOptics.asymmetry)
      mOptics.asymmetry.emplace(mDomain.dims, static_cast<float>(mAmbient.asymmetry));
  }

  [[nodiscard]] std::vector<std::int64_t> bricksInReach() const {
    BrickSet reach(mOptics.index.brickDims());
    for (const PlacedVolume& volume : mVolumes) volume.markReach(mOptics.index.brickDims(), reach);
    return reach.sorted();
  }

  /// Calls visit(grid, its part of a Mixture) for every grid that the volumes change.
  template <class Visit>
  void forEachGrid(const Visit& visit) const {
    if (changes(OpticalProperty::Index)) visit(mOptics.index, &Mixture::index);
    if (changes(OpticalProperty::Attenuation)) visit(*mOptics.attenuation, &Mixture::attenuation);
    if (changes(OpticalProperty::Scattering)) visit(*mOptics.scattering, &Mixture::scattering);
    if (changes(OpticalProperty::Asymmetry)) visit(*mOptics.asymmetry, &Mixture::turned);
  }

  /// What the backgrounds of all grids make of the ambient medium, in every brick.
  void fillBackground() {
    std::vector<Samples> samples;
    for (const PlacedVolume& volume : mVolumes)
      for (const Source& source : volume.sources()) samples.emplace_back()[0] = source.background();
    Mixture mix;
    blend(mix, samples, 1);
    forEachGrid([&](auto& grid, auto part) {
      const auto& value = (mix.*part)[0];
      if (value == grid.background()) return;
      for (std::int64_t b = 0; b < grid.brickCount(); ++b) grid.setConstant(b, value);
    });
  }

  void makeRoom(const std::vector<std::int64_t>& bricks) {
    std::uint64_t bytes = 0;
    forEachGrid([&](auto& grid, auto) {
      bytes += grid.memoryBytes() + bricks.size() * kBrickVoxels * sizeof grid.background();
    });
    mCtx.requireMemory(bytes, "volumes: at this resolution");
    forEachGrid([&](auto& grid, auto) { grid.activate(bricks, Fill::Later); });
  }

  /// The volumes in the ambient medium, in the first `count` voxels. Where nothing scatters the asymmetry is the
  /// ambient one.
  void blend(Mixture& mix, std::span<const Samples> samples, int count) {
    const Vec3f scattering = toFloat(mAmbient.scattering);
    const auto asymmetry = static_cast<float>(mAmbient.asymmetry);
    std::fill_n(mix.index.begin(), count, static_cast<float>(mAmbient.index));
    std::fill_n(mix.attenuation.begin(), count, toFloat(mAmbient.attenuation));
    std::fill_n(mix.scattering.begin(), count, scattering);
    std::fill_n(mix.turned.begin(), count, asymmetry * sum(scattering));
    for (PlacedVolume& volume : mVolumes) {
      volume.addTo(mix, samples.first(volume.sources().size()), count);
      samples = samples.subspan(volume.sources().size());
    }
    for (int v = 0; v < count; ++v) {
      const float all = sum(mix.scattering[v]);
      mix.turned[v] = all > 0 ? std::clamp(mix.turned[v] / all, -kForwardMost, kForwardMost) : asymmetry;
      if (!(mix.index[v] >= kLeastIndex && mix.index[v] <= kGreatestIndex)) mIndexBeyond = true;
    }
  }
  void store(const Mixture& mix, std::int64_t brick) {
    forEachGrid(
        [&](auto& grid, auto part) { std::copy((mix.*part).begin(), (mix.*part).end(), grid.voxels(brick).begin()); });
  }

  OpticsBricks& mOptics;
  const Ambient& mAmbient;
  const Domain& mDomain;
  const RunContext& mCtx;
  std::deque<PlacedVolume> mVolumes;
  std::atomic<bool> mIndexBeyond{false};
};

} // namespace

void addVolumes(OpticsBricks& optics, std::span<const MediumVolume> volumes, const Ambient& ambient,
                const Domain& domain, const RunContext& ctx) {
  if (!volumes.empty()) VolumeBlend(optics, volumes, ambient, domain, ctx).run();
}

} // namespace volcaustic
