#include "transport/direct.h"

#include "backends/lanes.h"
#include "core/parallel.h"
#include "transport/footprint.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace volcaustic {

namespace {

using kernels::dot;
using kernels::Double3;
using kernels::EmissionFrame;
using kernels::Int3;

constexpr int kTile = 8; // raster cells along a tile's edge

/// Nearest and farthest first bend over the cells of each tile.
struct TileDepths {
  int columns, rows;
  std::vector<float> nearest, farthest;
};

TileDepths tileDepths(const EmissionFrame& frame, std::span<const float> entry, const RunContext& ctx) {
  TileDepths t{(frame.columns + kTile - 1) / kTile, (frame.rows + kTile - 1) / kTile, {}, {}};
  t.nearest.resize(std::size_t(t.columns) * t.rows);
  t.farthest.resize(t.nearest.size());
  parallelFor(t.rows, 4, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (auto ty = begin; ty < end; ++ty)
      for (int tx = 0; tx < t.columns; ++tx) {
        float low = kernels::kNeverBends, high = 0;
        for (auto y = ty * kTile; y < std::min<std::int64_t>((ty + 1) * kTile, frame.rows); ++y)
          for (int x = tx * kTile; x < std::min((tx + 1) * kTile, frame.columns); ++x) {
            const float d = entry[y * frame.columns + x];
            low = std::min(low, d);
            high = std::max(high, d);
          }
        t.nearest[ty * t.columns + tx] = low;
        t.farthest[ty * t.columns + tx] = high;
      }
  });
  return t;
}

class DirectEvaluator {
public:
  DirectEvaluator(const FlatMediumStorage& flat, const Domain& domain, const Light& light, const EmissionFrame& frame,
                  std::span<const float> entry, const RunContext& ctx)
      : mFlat(flat)
      , mFrame(frame)
      , mEntry(entry)
      , mTiles(tileDepths(frame, entry, ctx))
      , mVoxelSize(domain.voxelSize)
      , mStrength(light.type == LightType::Point
                      ? Double3(light.intensity[0], light.intensity[1], light.intensity[2])
                      : Double3(light.irradiance[0], light.irradiance[1], light.irradiance[2]))
      , mClear(kernels::maxComponent(flat.optics[0].attenuation) == 0)
      , mRegular(!frame.jitter && frame.depth0 < 1e5 && frame.cells() <= std::numeric_limits<std::int32_t>::max()) {}

  enum class Cover { Shadow, Lit, Mixed };

  /// Whether a cube of voxels lies wholly before the first bends, wholly behind them, or neither.
  [[nodiscard]] Cover cover(const Int3& low, int size) const {
    const Footprint f = footprint(mFrame, Double3(low), size);
    if (f.empty()) return Cover::Shadow; // another face of the cube around the light sees it
    bool lit = true, shadow = !frameEdgeCuts(low, size);
    for (int ty = f.v0 / kTile; ty <= (f.v1 - 1) / kTile && (lit || shadow); ++ty)
      for (int tx = f.u0 / kTile; tx <= (f.u1 - 1) / kTile; ++tx) {
        lit = lit && mTiles.nearest[ty * mTiles.columns + tx] >= f.farthest;
        shadow = shadow && mTiles.farthest[ty * mTiles.columns + tx] <= f.nearest;
      }
    if (lit && !frameEdgeCuts(low, size)) return Cover::Lit;
    return shadow ? Cover::Shadow : Cover::Mixed;
  }

  /// Fraction of the voxel's light that has not met a bend: over the raster's rays that cross it, lit length by length.
  [[nodiscard]] double litFraction(const Int3& v) const {
    const Footprint f = footprint(mFrame, Double3(v), 1);
    if (f.empty()) return centreLit(v);
    const kernels::LitLengths<double> l = mRegular ? regularLengths(v, f) : anyLengths(v, f);
    return l.all > 0 ? l.lit / l.all : centreLit(v);
  }

  /// Fluence of unobstructed light at the voxel's centre.
  [[nodiscard]] Double3 fluence(const Int3& v, Double3& direction) const {
    const Double3 p = Double3(v) + Double3(0.5);
    Double3 strength = mStrength, origin = p - mFrame.axisW * 1e9;
    direction = mFrame.axisW;
    double reach = 1e9;
    if (mFrame.point) {
      const Double3 r = p - mFrame.origin;
      reach = kernels::length(r);
      direction = reach > 0 ? r * (1 / reach) : mFrame.axisW;
      origin = mFrame.origin;
      const double distance = std::max(reach, 0.5) * mVoxelSize; // inside the light's own voxel: at half a voxel
      strength *= 1 / (distance * distance);
    }
    if (mClear) return strength;
    const kernels::Span s = kernels::clipToBox(mFlat.dims, origin, direction);
    const double start = mFrame.point ? std::max(s.entry, 0.0) : s.entry;
    return strength * kernels::transmittance(mFlat.optics[0], std::max(0.0, reach - start));
  }

  /// Adds the unobstructed light to a brick.
  void lightBrick(const Int3& low, std::span<Vec3f> fluence, std::span<Vec3f> direction) const {
    const auto single = [](const Double3& a) { return kernels::Float3(a); };
    kernels::LampView lamp{single(Double3(low)),
                           single(Double3(low) - mFrame.origin),
                           single(mFrame.axisW),
                           single(mStrength * (mFrame.point ? 1 / (mVoxelSize * mVoxelSize) : 1)),
                           mFlat.optics[0].attenuation,
                           kernels::Float3(mFlat.dims),
                           mFrame.point,
                           mClear};
    mLanes.lightBrick(lamp, fluence.data()->data(), direction.data()->data());
  }

  [[nodiscard]] bool uniformOverBrick() const { return mClear && !mFrame.point; }

private:
  /// Rays at the middles of their cells, in lanes.
  [[nodiscard]] kernels::LitLengths<double> regularLengths(const Int3& v, const Footprint& f) const {
    const Double3 r = Double3(v) + Double3(0.5) - mFrame.origin;
    const double depth = dot(r, mFrame.axisW), distance = mFrame.point ? kernels::length(r) : depth;
    const auto single = [](const Double3& a) { return kernels::Float3(a); };
    kernels::LitView view{
        single(mFrame.axisU), single(mFrame.axisV), single(mFrame.axisW), {}, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
        mFrame.point};
    if (mFrame.point) {
      view.towards = single(r * (1 / distance));
      view.distance = static_cast<float>(distance);
    }
    view.u0 = static_cast<float>(mFrame.u0 + (f.u0 + 0.5) * mFrame.du - (mFrame.point ? 0 : dot(r, mFrame.axisU)));
    view.v0 = static_cast<float>(mFrame.v0 + (f.v0 + 0.5) * mFrame.dv - (mFrame.point ? 0 : dot(r, mFrame.axisV)));
    view.du = static_cast<float>(mFrame.du);
    view.dv = static_cast<float>(mFrame.dv);
    view.shift = static_cast<float>(mFrame.depth0 - distance);
    view.columns = f.u1 - f.u0;
    view.cells = view.columns * (f.v1 - f.v0);
    view.first = f.v0 * mFrame.columns + f.u0;
    view.mapStride = mFrame.columns;
    const kernels::LitLengths<float> l = mLanes.litLengths(view, mEntry.data());
    return {l.all, l.lit};
  }

  /// Rays anywhere in their cells, in double precision.
  [[nodiscard]] kernels::LitLengths<double> anyLengths(const Int3& v, const Footprint& f) const {
    kernels::LitLengths<double> sum{0, 0};
    for (int y = f.v0; y < f.v1; ++y)
      for (int x = f.u0; x < f.u1; ++x) {
        const std::int64_t cell = std::int64_t{y} * mFrame.columns + x;
        const kernels::EmissionRay ray = mFrame.ray(cell);
        const kernels::Span s = kernels::clipToBox({1, 1, 1}, ray.origin - Double3(v), ray.direction);
        const double in = mFrame.point ? std::max(s.entry, 0.0) : s.entry;
        if (!(s.exit > in)) continue;
        const double bend = mEntry[cell] == kernels::kNeverBends ? 1e300 : mEntry[cell] + mFrame.depth0;
        sum.all += s.exit - in;
        sum.lit += kernels::clampTo(bend - in, 0.0, s.exit - in);
      }
    return sum;
  }

  /// Whether a cube of voxels reaches into another face of the cube around the light.
  [[nodiscard]] bool frameEdgeCuts(const Int3& low, int size) const {
    if (!mFrame.cubeFace) return false;
    for (int i = 0; i < 8; ++i)
      if (!owns(Double3(low.x + (i & 1 ? size : 0), low.y + (i & 2 ? size : 0), low.z + (i & 4 ? size : 0))))
        return true;
    return false;
  }

  /// Whether this face sees the point: the one along the largest coordinate, the first of equals.
  [[nodiscard]] bool owns(const Double3& p) const {
    const Double3 r = p - mFrame.origin, size{std::abs(r.x), std::abs(r.y), std::abs(r.z)};
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    return r[axis] * mFrame.axisW[axis] > 0;
  }

  [[nodiscard]] double centreLit(const Int3& v) const {
    const Double3 r = Double3(v) + Double3(0.5) - mFrame.origin;
    double u = dot(r, mFrame.axisU), w = dot(r, mFrame.axisV), depth = dot(r, mFrame.axisW);
    if (mFrame.point) {
      if (depth <= 0) return 0;
      u /= depth;
      w /= depth;
      depth = kernels::length(r);
    }
    const double column = std::floor((u - mFrame.u0) / mFrame.du), row = std::floor((w - mFrame.v0) / mFrame.dv);
    if (column < 0 || row < 0 || column >= mFrame.columns || row >= mFrame.rows) return 0;
    return mEntry[static_cast<std::int64_t>(row) * mFrame.columns + static_cast<std::int64_t>(column)] >=
           depth - mFrame.depth0;
  }

public:
  /// The part of a voxel that this raster sees, in sixty-fourths; over the faces of a cube around a light they add up
  /// to one.
  [[nodiscard]] double share(const Int3& v) const {
    if (!frameEdgeCuts(v, 1)) return 1;
    int seen = 0;
    for (int i = 0; i < 64; ++i)
      seen += owns(Double3(v) + Double3((i & 3) + 0.5, (i >> 2 & 3) + 0.5, (i >> 4) + 0.5) * 0.25);
    return seen / 64.0;
  }

private:
  const FlatMediumStorage& mFlat;
  const EmissionFrame& mFrame;
  std::span<const float> mEntry;
  TileDepths mTiles;
  double mVoxelSize;
  Double3 mStrength;
  bool mClear;
  bool mRegular; ///< rays at the middles of their cells, near enough for single precision, numbered with 32 bits
  const LaneSet& mLanes = laneSet("");
};

Vec3f plus(const Vec3f& a, const Double3& b) {
  return {static_cast<float>(a[0] + b.x), static_cast<float>(a[1] + b.y), static_cast<float>(a[2] + b.z)};
}

} // namespace

void addDirectLight(DirectLight& direct, const FlatMediumStorage& flat, const Domain& domain, const Light& light,
                    const EmissionFrame& frame, std::span<const float> entry, const RunContext& ctx) {
  using Cover = DirectEvaluator::Cover;
  const DirectEvaluator evaluator(flat, domain, light, frame, entry, ctx);
  const auto lowOf = [&](std::int64_t b) {
    const Vec3i c = direct.fluence.brickCoord(b);
    return Int3{c[0] * kBrickSize, c[1] * kBrickSize, c[2] * kBrickSize};
  };

  // Whole bricks first; only bricks that vary get voxels.
  std::vector<Cover> covers(direct.fluence.brickCount());
  parallelFor(direct.fluence.brickCount(), 256, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t b = begin; b < end; ++b) covers[b] = evaluator.cover(lowOf(b), kBrickSize);
  });
  // A number for each sequence of covers, however many rasters there are.
  direct.covers.resize(covers.size());
  for (std::size_t b = 0; b < covers.size(); ++b)
    direct.covers[b] = covers[b] == Cover::Mixed || direct.covers[b] == DirectLight::kEdge
                           ? DirectLight::kEdge
                           : direct.covers[b] * 0x100000001b3ull + (covers[b] == Cover::Lit);
  std::vector<std::int64_t> varying;
  for (std::int64_t b = 0; b < direct.fluence.brickCount(); ++b) {
    if (covers[b] == Cover::Shadow) continue;
    const bool uniform = covers[b] == Cover::Lit && evaluator.uniformOverBrick() && direct.fluence.isConstant(b);
    if (!uniform) {
      varying.push_back(b);
      continue;
    }
    Double3 d;
    const Double3 f = evaluator.fluence(lowOf(b), d);
    direct.fluence.setConstant(b, plus(direct.fluence.constant(b), f));
    direct.direction.setConstant(b, plus(direct.direction.constant(b), d * kernels::luminance(f)));
  }
  ctx.requireMemory(varying.size() * 2 * kBrickVoxels * sizeof(Vec3f), "photons: direct light");
  std::vector<std::int64_t> fresh;
  std::copy_if(varying.begin(), varying.end(), std::back_inserter(fresh),
               [&](std::int64_t b) { return direct.fluence.isConstant(b); });
  std::vector<char> isFresh(covers.size());
  for (const std::int64_t b : fresh) isFresh[b] = 1;
  direct.fluence.activate(fresh, Fill::Later);
  direct.direction.activate(fresh, Fill::Later);

  parallelFor(static_cast<std::int64_t>(varying.size()), 8, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      const std::int64_t b = varying[i];
      const auto fluence = direct.fluence.voxels(b), direction = direct.direction.voxels(b);
      const Int3 low = lowOf(b);
      if (isFresh[b]) {
        std::fill(fluence.begin(), fluence.end(), direct.fluence.constant(b));
        std::fill(direction.begin(), direction.end(), direct.direction.constant(b));
      }
      if (covers[b] == Cover::Lit) {
        evaluator.lightBrick(low, fluence, direction);
        continue;
      }
      for (int k = 0; k < kBrickVoxels; ++k) {
        const Int3 v{low.x + (k >> 6), low.y + ((k >> 3) & 7), low.z + (k & 7)};
        const double share = evaluator.share(v);
        if (share == 0) continue;
        const double lit = share * evaluator.litFraction(v);
        if (lit == 0) continue;
        Double3 d;
        const Double3 f = evaluator.fluence(v, d) * lit;
        fluence[k] = plus(fluence[k], f);
        direction[k] = plus(direction[k], d * kernels::luminance(f));
      }
    }
  });
}

} // namespace volcaustic
