#include "transport/direct.h"

#include "core/parallel.h"
#include "transport/emission.h"
#include "transport/lit_raster.h"
#include "transport/many_lamps.h"

#include <algorithm>
#include <map>

namespace volcaustic {

namespace {

using kernels::Double3;
using kernels::Float3;
using kernels::Int3;
using kernels::Lamp;
using Cover = LitRaster::Cover;

constexpr int kTileBricks = 8; // along an axis: what is looked at as a whole first

Lamp lampOf(const Light& light, const FlatMediumStorage& flat, const Domain& domain) {
  const bool point = light.type != LightType::Directional;
  const Rgb& power = point ? light.intensity : light.irradiance;
  const double h = domain.voxelSize;
  Lamp lamp;
  lamp.point = point;
  lamp.strength = Float3(Double3(power[0], power[1], power[2]) * (point ? 1 / (h * h) : 1));
  lamp.cone = coneOf(light);
  if (point)
    lamp.origin = Float3(toGrid(domain, light.position));
  else
    lamp.direction = Float3(kernels::normalize(Double3(light.direction[0], light.direction[1], light.direction[2])));
  lamp.attenuation = flat.optics[0].attenuation;
  lamp.clear = kernels::maxComponent(lamp.attenuation) == 0;
  lamp.box = Float3(flat.dims);
  return lamp;
}

/// Light of a voxel in the order of kernels::LightSums.
struct EdgeVoxel {
  float sums[8];
};

/// Sets of lamps, each with a number. Set 0 is all of them.
class LampSets {
public:
  explicit LampSets(std::int32_t lamps) {
    mSets.emplace_back();
    for (std::int32_t i = 0; i < lamps; ++i) mSets[0].push_back(i);
    mNumbers[mSets[0]] = 0;
  }
  /// The set without one of its lamps.
  std::int32_t without(std::int32_t set, std::int32_t lamp) {
    const auto [known, isNew] = mWithout.try_emplace({set, lamp}, 0);
    if (!isNew) return known->second;
    std::vector<std::int32_t> rest = mSets[set];
    std::erase(rest, lamp);
    const auto [number, added] = mNumbers.try_emplace(rest, static_cast<std::int32_t>(mSets.size()));
    if (added) mSets.push_back(std::move(rest));
    return known->second = number->second;
  }
  [[nodiscard]] const std::vector<std::int32_t>& operator[](std::int32_t set) const { return mSets[set]; }
  [[nodiscard]] std::size_t size() const { return mSets.size(); }

private:
  std::vector<std::vector<std::int32_t>> mSets;
  std::map<std::vector<std::int32_t>, std::int32_t> mNumbers;
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> mWithout;
};

} // namespace

class DirectLightBuilder::Impl {
public:
  Impl(const FlatMediumStorage& flat, const Domain& domain, std::span<const LightPart> lights, const RunContext& ctx)
      : mDims(flat.dims), mBricks(flat.brickDims), mCtx(ctx), mSets(static_cast<std::int32_t>(lights.size())) {
    for (const LightPart& part : lights) mLamps.push_back(lampOf(part.light, flat, domain));
    const auto bricks = static_cast<std::size_t>(mBricks.x) * mBricks.y * mBricks.z;
    mSetOf = ZeroedTable<std::int32_t>(bricks);
    mEdgeOf = ZeroedTable<std::int32_t>(bricks);
  }

  void add(std::int32_t lamp, const kernels::EmissionFrame& frame, std::span<const float> entry) {
    const LitRaster raster(frame, entry, mCtx);
    const std::vector<std::int64_t> mixed = classify(raster, lamp);
    const auto known = static_cast<std::int32_t>(mEdges.size() / kBrickVoxels);
    std::int32_t count = known;
    for (const std::int64_t b : mixed)
      if (mEdgeOf[b] == 0) mEdgeOf[b] = ++count;
    mCtx.requireMemory(std::uint64_t(count) * 2 * kBrickVoxels * sizeof(EdgeVoxel), "photons: direct light");
    mEdges.resize(std::size_t(count) * kBrickVoxels);
    parallelFor(static_cast<std::int64_t>(mixed.size()), 4, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) {
        EdgeVoxel* voxels = mEdges.data() + std::size_t(mEdgeOf[mixed[i]] - 1) * kBrickVoxels;
        if (mEdgeOf[mixed[i]] > known) std::fill_n(voxels, kBrickVoxels, EdgeVoxel{});
        const Int3 low = firstVoxel(mixed[i]);
        std::array<float, kBrickVoxels> parts;
        raster.litParts(low, parts);
        for (int k = 0; k < kBrickVoxels; ++k) {
          if (parts[k] == 0) continue;
          const Int3 v{low.x + (k >> 6), low.y + ((k >> 3) & 7), low.z + (k & 7)};
          const kernels::LampLight<float> l = kernels::lampLight<float>(mLamps[lamp], Float3(v) + Float3(0.5f));
          const Float3 fluence = l.fluence * parts[k], towards = l.direction * kernels::luminance(fluence);
          for (int c = 0; c < 3; ++c) {
            voxels[k].sums[c] += fluence[c];
            voxels[k].sums[4 + c] += towards[c];
          }
        }
      }
    });
  }

  void finish(bool smooth, DirectLight& direct) {
    const std::vector<std::int64_t> stored = smooth ? besideEdges() : edges();
    direct.stored.reserve(static_cast<std::int64_t>(stored.size()), mCtx);
    const std::int32_t first = direct.stored.claim(static_cast<std::int32_t>(stored.size()));
    parallelFor(static_cast<std::int64_t>(stored.size()), 4, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      Neighbourhood around(*this);
      for (std::int64_t i = begin; i < end; ++i) {
        const auto slot = first + static_cast<std::int32_t>(i);
        around.finish(stored[i], smooth, direct.stored.slot(slot).data());
        direct.stored.assign(stored[i], slot);
      }
    });
    direct.lamps = std::move(mLamps);
    direct.sets = std::move(mSetOf);
    direct.setBegins = {0};
    direct.setLamps.clear();
    for (std::size_t s = 0; s < mSets.size(); ++s) {
      const auto& lamps = mSets[static_cast<std::int32_t>(s)];
      direct.setLamps.insert(direct.setLamps.end(), lamps.begin(), lamps.end());
      direct.setBegins.push_back(static_cast<std::int32_t>(direct.setLamps.size()));
    }
  }

private:
  [[nodiscard]] std::int64_t brickIndex(const Int3& b) const {
    return (std::int64_t{b.x} * mBricks.y + b.y) * mBricks.z + b.z;
  }
  [[nodiscard]] Int3 brickCoord(std::int64_t b) const {
    const std::int64_t rest = b / mBricks.z;
    return {static_cast<std::int32_t>(rest / mBricks.y), static_cast<std::int32_t>(rest % mBricks.y),
            static_cast<std::int32_t>(b % mBricks.z)};
  }
  [[nodiscard]] Int3 firstVoxel(std::int64_t brick) const {
    const Int3 c = brickCoord(brick);
    return {c.x * kBrickSize, c.y * kBrickSize, c.z * kBrickSize};
  }
  [[nodiscard]] bool inside(const Int3& brick) const {
    const auto in = [](std::int32_t c, std::int32_t n) { return c >= 0 && c < n; };
    return in(brick.x, mBricks.x) && in(brick.y, mBricks.y) && in(brick.z, mBricks.z);
  }
  /// Calls visit(number, i) for the bricks around and at `brick` that are inside the domain; i counts 3x3x3, z fastest.
  template <class Visit>
  void forAround(const Int3& brick, const Visit& visit) const {
    for (int i = 0; i < 27; ++i) {
      const Int3 c(brick.x + i / 9 - 1, brick.y + i / 3 % 3 - 1, brick.z + i % 3 - 1);
      if (inside(c)) visit(brickIndex(c), i);
    }
  }

  /// Takes the lamp from the bricks that this raster does not light as a whole, and returns those that it lights in
  /// part. Tiles of bricks first.
  std::vector<std::int64_t> classify(const LitRaster& raster, std::int32_t lamp) {
    const auto tiles = [](std::int32_t n) { return (n + kTileBricks - 1) / kTileBricks; };
    const Int3 n(tiles(mBricks.x), tiles(mBricks.y), tiles(mBricks.z));
    struct Found {
      std::vector<std::int64_t> shadow, mixed;
    };
    std::vector<Found> found(std::size_t(n.x) * n.y * n.z);
    parallelFor(static_cast<std::int64_t>(found.size()), 1, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t t = begin; t < end; ++t) {
        const std::int64_t rest = t / n.z;
        const Int3 first(static_cast<std::int32_t>(rest / n.y) * kTileBricks,
                         static_cast<std::int32_t>(rest % n.y) * kTileBricks,
                         static_cast<std::int32_t>(t % n.z) * kTileBricks);
        const Cover whole = raster.cover({first.x * 8, first.y * 8, first.z * 8}, kTileBricks * 8);
        if (whole == Cover::Lit || whole == Cover::Elsewhere) continue;
        for (int x = first.x; x < std::min(first.x + kTileBricks, mBricks.x); ++x)
          for (int y = first.y; y < std::min(first.y + kTileBricks, mBricks.y); ++y)
            for (int z = first.z; z < std::min(first.z + kTileBricks, mBricks.z); ++z) {
              const Cover c = whole == Cover::Shadow ? whole : raster.cover({8 * x, 8 * y, 8 * z}, 8);
              if (c == Cover::Shadow) found[t].shadow.push_back(brickIndex({x, y, z}));
              if (c == Cover::Mixed) found[t].mixed.push_back(brickIndex({x, y, z}));
            }
      }
    });
    std::vector<std::int64_t> mixed;
    for (const Found& f : found) {
      for (const auto* list : {&f.shadow, &f.mixed})
        for (const std::int64_t b : *list) {
          if (mSetOf[b] == 0 && mEdgeOf[b] == 0) mShaded.push_back(b);
          mSetOf[b] = mSets.without(mSetOf[b], lamp);
        }
      mixed.insert(mixed.end(), f.mixed.begin(), f.mixed.end());
    }
    return mixed;
  }

  [[nodiscard]] std::vector<std::int64_t> edges() const {
    std::vector<std::int64_t> edges;
    for (const std::int64_t b : mShaded)
      if (mEdgeOf[b] != 0) edges.push_back(b);
    return edges;
  }
  /// Bricks in which light has an edge, bricks beside them, and bricks beside others with other lamps: all that the
  /// Gaussian changes. Elsewhere light is smooth by itself.
  [[nodiscard]] std::vector<std::int64_t> besideEdges() const {
    ZeroedTable<std::uint8_t> known(mSetOf.size());
    std::vector<std::int64_t> bricks;
    const auto take = [&](std::int64_t b) {
      if (!known[b]) bricks.push_back(b);
      known[b] = 1;
    };
    for (const std::int64_t b : mShaded)
      forAround(brickCoord(b), [&](std::int64_t other, int) {
        if (mEdgeOf[b] == 0 && mEdgeOf[other] == 0 && mSetOf[b] == mSetOf[other]) return;
        take(b);
        take(other);
      });
    return bricks;
  }

  /// A brick's light and that of one voxel around it.
  class Neighbourhood {
  public:
    explicit Neighbourhood(const Impl& impl)
        : mImpl(impl), mBricksOf(impl.mLamps.size()), mParts(kAroundPadded), mSums(kAroundVoxels * 8) {}

    void finish(std::int64_t brick, bool smooth, kernels::FluenceVoxel* out) {
      std::fill(mSums.begin(), mSums.end(), 0.0f);
      const Int3 c = mImpl.brickCoord(brick), low = mImpl.firstVoxel(brick);
      addLamps(c, low);
      mImpl.forAround(c, [&](std::int64_t other, int i) { addEdges(other, i); });
      kernels::LightSums<float> sums{mSums.data(), nullptr, 0, {}, {}, 1, smooth};
      for (int a = 0; a < 3; ++a) {
        sums.from[a] = low[a] == 0 ? 1 : 0;
        sums.to[a] = std::min(10, mImpl.mDims[a] - low[a] + 1);
        if (sums.to[a] < 9) std::fill(out, out + kBrickVoxels, kernels::FluenceVoxel{});
      }
      mLanes.finishBrick(sums, out);
    }

  private:
    /// Voxels of neighbour i of 3x3x3 along an axis: [begin, end) of 0 to 10.
    struct Range {
      int begin, end;
      explicit Range(int i) : begin(i == 0 ? 0 : i == 1 ? 1 : 9), end(i == 0 ? 1 : i == 1 ? 9 : 10) {}
    };
    template <class Visit>
    static void forVoxels(int i, const Visit& visit) {
      const Range xs(i / 9), ys(i / 3 % 3), zs(i % 3);
      for (int x = xs.begin; x < xs.end; ++x)
        for (int y = ys.begin; y < ys.end; ++y)
          for (int z = zs.begin; z < zs.end; ++z) visit(x, y, z);
    }

    /// Light of lamps in the bricks that they light as a whole.
    void addLamps(const Int3& brick, const Int3& low) {
      std::fill(mBricksOf.begin(), mBricksOf.end(), 0u);
      std::uint32_t inside = 0; // bits of the bricks around
      mImpl.forAround(brick, [&](std::int64_t b, int i) {
        inside |= 1u << i;
        for (const std::int32_t lamp : mImpl.mSets[mImpl.mSetOf[b]]) mBricksOf[lamp] |= 1u << i;
      });
      const auto isSmooth = [&](std::size_t lamp) {
        return mBricksOf[lamp] == inside && ManyLamps::takes(mImpl.mLamps[lamp]);
      };
      std::size_t smooth = 0;
      for (std::size_t lamp = 0; lamp < mBricksOf.size(); ++lamp) smooth += isSmooth(lamp);
      ManyLamps many(low, mImpl.mDims);
      for (std::size_t lamp = 0; lamp < mBricksOf.size(); ++lamp) {
        if (smooth >= ManyLamps::kFewest && isSmooth(lamp))
          many.add(mImpl.mLamps[lamp]);
        else if (mBricksOf[lamp] != 0)
          addLamp(mImpl.mLamps[lamp], inside & ~mBricksOf[lamp], low);
      }
      if (smooth >= ManyLamps::kFewest) many.spread(mSums.data());
    }
    void addLamp(const Lamp& lamp, std::uint32_t dark, const Int3& low) {
      std::fill(mParts.begin(), mParts.end(), 1.0f);
      for (int i = 0; i < 27; ++i)
        if (dark >> i & 1) forVoxels(i, [&](int x, int y, int z) { mParts[(x * 10 + y) * 10 + z] = 0; });
      mLanes.lightAround(lamp, {low.x - 1, low.y - 1, low.z - 1}, mImpl.mDims, mParts.data(), mSums.data());
    }

    void addEdges(std::int64_t other, int i) {
      if (mImpl.mEdgeOf[other] == 0) return;
      const EdgeVoxel* voxels = mImpl.mEdges.data() + std::size_t(mImpl.mEdgeOf[other] - 1) * kBrickVoxels;
      forVoxels(i, [&](int x, int y, int z) {
        const EdgeVoxel& voxel = voxels[brickOffset(x - 1, y - 1, z - 1)];
        float* sums = &mSums[(std::size_t(x * 10 + y) * 10 + z) * 8];
        for (int n = 0; n < 8; ++n) sums[n] += voxel.sums[n];
      });
    }

    const Impl& mImpl;
    const LaneSet& mLanes = laneSet("");
    std::vector<std::uint32_t> mBricksOf; ///< of each lamp: bits of the bricks around that it lights as a whole
    std::vector<float> mParts, mSums;
  };

  Int3 mDims, mBricks;
  const RunContext& mCtx;
  std::vector<Lamp> mLamps;
  LampSets mSets;
  ZeroedTable<std::int32_t> mSetOf;  ///< of each brick: the lamps whose light it has as a whole
  ZeroedTable<std::int32_t> mEdgeOf; ///< of each brick: where in mEdges it is, from 1 on
  LargeVector<EdgeVoxel> mEdges;     ///< 512 for each brick with an edge: what lamps light of it in part
  std::vector<std::int64_t> mShaded; ///< bricks that some lamp does not light as a whole
};

DirectLightBuilder::DirectLightBuilder(const FlatMediumStorage& flat, const Domain& domain,
                                       std::span<const LightPart> lights, const RunContext& ctx)
    : mImpl(std::make_unique<Impl>(flat, domain, lights, ctx)) {}
DirectLightBuilder::~DirectLightBuilder() = default;
void DirectLightBuilder::add(int light, const kernels::EmissionFrame& frame, std::span<const float> entry) {
  mImpl->add(light, frame, entry);
}
void DirectLightBuilder::finish(bool smooth, DirectLight& direct) { mImpl->finish(smooth, direct); }

} // namespace volcaustic
