#include "transport/lit_raster.h"

#include "core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volcaustic {

using kernels::dot;
using kernels::Double3;
using kernels::EmissionFrame;
using kernels::Int3;

namespace {

/// Raster cells along a tile's edge: fewer where cells of parallel light are large, so that tiles are not much wider
/// than voxels.
int tileEdge(const EmissionFrame& frame) {
  constexpr int kMost = 4;
  return frame.point ? kMost : std::clamp(static_cast<int>(2 / std::max(frame.du, frame.dv)), 1, kMost);
}

Double3 centreOf(const Int3& voxel) { return Double3(voxel) + Double3(0.5); }

} // namespace

int cubeFaceTowards(const Double3& r) {
  const Double3 size{std::abs(r.x), std::abs(r.y), std::abs(r.z)};
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return 2 * axis + (r[axis] > 0);
}
bool isCubeFace(const EmissionFrame& frame, int face) { return frame.axisW[face / 2] * (face % 2 == 0 ? -1 : 1) > 0.5; }

LitRaster::LitRaster(const EmissionFrame& frame, std::span<const float> entry, const RunContext& ctx)
    : mFrame(frame)
    , mEntry(entry)
    , mTiles(tileDepths(frame, entry, ctx))
    , mRegular(!frame.jitter && frame.depth0 < 1e5 && frame.cells() <= std::numeric_limits<std::int32_t>::max()) {}

LitRaster::TileDepths LitRaster::tileDepths(const EmissionFrame& frame, std::span<const float> entry,
                                            const RunContext& ctx) {
  const int edge = tileEdge(frame);
  TileDepths t{edge, (frame.columns + edge - 1) / edge, (frame.rows + edge - 1) / edge, {}, {}};
  t.nearest.assign(std::size_t(t.columns) * t.rows, kernels::kNeverBends);
  t.farthest.assign(t.nearest.size(), 0);
  parallelFor(t.rows, 4, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (auto y = begin * edge; y < std::min<std::int64_t>(end * edge, frame.rows); ++y) {
      const float* row = entry.data() + y * frame.columns;
      float* nearest = t.nearest.data() + y / edge * t.columns;
      float* farthest = t.farthest.data() + y / edge * t.columns;
      for (int x = 0; x < frame.columns; ++x) {
        nearest[x / edge] = std::min(nearest[x / edge], row[x]);
        farthest[x / edge] = std::max(farthest[x / edge], row[x]);
      }
    }
  });
  return t;
}

LitRaster::Bends LitRaster::bends(const Footprint& f) const {
  Bends b{kernels::kNeverBends, 0};
  const int edge = mTiles.edge;
  for (int ty = f.v0 / edge; ty <= (f.v1 - 1) / edge; ++ty)
    for (int tx = f.u0 / edge; tx <= (f.u1 - 1) / edge; ++tx) {
      b.nearest = std::min(b.nearest, mTiles.nearest[ty * mTiles.columns + tx]);
      b.farthest = std::max(b.farthest, mTiles.farthest[ty * mTiles.columns + tx]);
    }
  return b;
}

LitRaster::Cover LitRaster::cover(const Int3& low, int size) const {
  const Footprint f = footprint(mFrame, Double3(low), size);
  if (mFrame.cubeFace) {
    const Seen seen = seenPart(low, size);
    if (seen == Seen::Nothing || f.empty()) return Cover::Elsewhere;
    if (seen == Seen::Part) return Cover::Mixed;
  }
  if (f.empty()) return Cover::Shadow;
  const Bends b = bends(f);
  return b.nearest >= f.farthest ? Cover::Lit : b.farthest <= f.nearest ? Cover::Shadow : Cover::Mixed;
}

namespace {

/// footprint() for all voxels of a brick, in single precision: corners are shared, and the rest runs over rows of
/// numbers that compilers turn into lanes.
class BrickFootprints {
public:
  BrickFootprints(const EmissionFrame& frame, const Int3& low) : mFrame(frame) {
    const kernels::Float3 base(Double3(low) - frame.origin), axisU(frame.axisU), axisV(frame.axisV), axisW(frame.axisW);
    float depths[kCorners];
    for (int k = 0; k < kCorners; ++k) {
      const kernels::Float3 r(base.x + static_cast<float>(k / 81), base.y + static_cast<float>(k / 9 % 9),
                              base.z + static_cast<float>(k % 9));
      const float u = dot(r, axisU), v = dot(r, axisV), depth = dot(r, axisW);
      const float scale = frame.point ? 1 / depth : 1;
      mLow[0][k] = u * scale, mLow[1][k] = v * scale;
      mLow[2][k] = frame.point ? kernels::length(r) : depth;
      depths[k] = depth;
    }
    mAhead = !frame.point || *std::min_element(depths, depths + kCorners) > 0.5f;
    for (int n = 0; n < 3; ++n) {
      std::copy_n(mLow[n], kCorners, mHigh[n]);
      narrow(mLow[n], [](float a, float b) { return std::min(a, b); });
      narrow(mHigh[n], [](float a, float b) { return std::max(a, b); });
    }
    for (int n = 0; n < 2; ++n) {
      const auto first = static_cast<float>(n == 0 ? frame.u0 : frame.v0);
      const auto inverse = static_cast<float>(1 / (n == 0 ? frame.du : frame.dv));
      const auto count = static_cast<float>(n == 0 ? frame.columns : frame.rows);
      const auto cell = [=](float at) {
        return static_cast<std::int32_t>(std::min(std::max((at - first) * inverse, 0.0f), count));
      };
      for (int k = 0; k < kBrickVoxels; ++k) mCells[n][k] = cell(mLow[n][k]);
      for (int k = 0; k < kBrickVoxels; ++k) mCells[2 + n][k] = cell(mHigh[n][k] + 1 / inverse);
    }
  }

  /// Whether the light stands clear of the brick; only then are footprints right.
  [[nodiscard]] bool ahead() const { return mAhead; }
  [[nodiscard]] Footprint of(int k) const {
    return {mCells[0][k],
            mCells[2][k],
            mCells[1][k],
            mCells[3][k],
            (mFrame.point ? std::max(0.0f, mLow[2][k] - 1) : mLow[2][k]) - mFrame.depth0 - kSlack,
            mHigh[2][k] - mFrame.depth0 + kSlack};
  }

private:
  static constexpr int kCorners = 9 * 9 * 9, kBrickVoxels = kernels::kStepVoxels;
  static constexpr double kSlack = 1e-3; // voxels, for rounding

  /// From values at corners to the least or greatest over the eight corners of each voxel.
  template <class Choose>
  static void narrow(float* v, const Choose& choose) {
    for (int row = 0; row < 81; ++row)
      for (int z = 0; z < 8; ++z) v[8 * row + z] = choose(v[9 * row + z], v[9 * row + z + 1]);
    for (int x = 0; x < 9; ++x)
      for (int i = 0; i < 64; ++i) v[64 * x + i] = choose(v[72 * x + i], v[72 * x + i + 8]);
    for (int i = 0; i < 512; ++i) v[i] = choose(v[i], v[i + 64]);
  }

  const EmissionFrame& mFrame;
  float mLow[3][kCorners], mHigh[3][kCorners]; ///< u, v, distance; of voxels in the end
  std::int32_t mCells[4][kBrickVoxels];        ///< first column and row of a voxel, and those beyond its last
  bool mAhead;
};

} // namespace

void LitRaster::litParts(const Int3& low, std::span<float, kernels::kStepVoxels> parts) const {
  const BrickFootprints footprints(mFrame, low);
  const bool whole = !mFrame.cubeFace || seenPart(low, 8) == Seen::All;
  for (int k = 0; k < kernels::kStepVoxels; ++k) {
    const Int3 voxel(low.x + (k >> 6), low.y + (k >> 3 & 7), low.z + (k & 7));
    const double seen = whole ? 1 : share(voxel);
    const auto part = [&] {
      return litPart(voxel, footprints.ahead() ? footprints.of(k) : footprint(mFrame, Double3(voxel), 1));
    };
    parts[k] = seen == 0 ? 0 : static_cast<float>(seen * part());
  }
}

double LitRaster::litPart(const Int3& voxel, const Footprint& f) const {
  if (f.empty()) return centreLit(voxel);
  // Most voxels of a mixed brick are wholly lit, or wholly not.
  const Bends b = bends(f);
  if (b.nearest >= f.farthest) return 1;
  if (b.farthest <= f.nearest) return 0;
  const kernels::LitLengths<double> l = mRegular ? regularLengths(voxel, f) : anyLengths(voxel, f);
  return l.all > 0 ? l.lit / l.all : centreLit(voxel);
}

/// Rays at the middles of their cells, in lanes.
kernels::LitLengths<double> LitRaster::regularLengths(const Int3& voxel, const Footprint& f) const {
  const Double3 r = centreOf(voxel) - mFrame.origin;
  const double depth = dot(r, mFrame.axisW), distance = mFrame.point ? kernels::length(r) : depth;
  const auto single = [](const Double3& a) { return kernels::Float3(a); };
  kernels::LitView view{
      single(mFrame.axisU), single(mFrame.axisV), single(mFrame.axisW), {}, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, mFrame.point};
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
kernels::LitLengths<double> LitRaster::anyLengths(const Int3& voxel, const Footprint& f) const {
  kernels::LitLengths<double> sum{0, 0};
  for (int y = f.v0; y < f.v1; ++y)
    for (int x = f.u0; x < f.u1; ++x) {
      const std::int64_t cell = std::int64_t{y} * mFrame.columns + x;
      const kernels::EmissionRay ray = mFrame.ray(cell);
      const kernels::Span s = kernels::clipToBox({1, 1, 1}, ray.origin - Double3(voxel), ray.direction);
      const double in = mFrame.point ? std::max(s.entry, 0.0) : s.entry;
      if (!(s.exit > in)) continue;
      const double bend = mEntry[cell] == kernels::kNeverBends ? 1e300 : mEntry[cell] + mFrame.depth0;
      sum.all += s.exit - in;
      sum.lit += kernels::clampTo(bend - in, 0.0, s.exit - in);
    }
  return sum;
}

/// What a face sees is convex: a cube of voxels is seen by one face if its corners are.
LitRaster::Seen LitRaster::seenPart(const Int3& low, int size) const {
  int first = -1;
  for (int i = 0; i < 8; ++i) {
    const Double3 corner(low.x + (i & 1 ? size : 0), low.y + (i & 2 ? size : 0), low.z + (i & 4 ? size : 0));
    const int face = cubeFaceTowards(corner - mFrame.origin);
    if (first >= 0 && face != first) return Seen::Part;
    first = face;
  }
  return isCubeFace(mFrame, first) ? Seen::All : Seen::Nothing;
}

double LitRaster::centreLit(const Int3& voxel) const {
  const Double3 r = centreOf(voxel) - mFrame.origin;
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

double LitRaster::share(const Int3& voxel) const {
  if (!mFrame.cubeFace) return 1;
  if (const Seen seen = seenPart(voxel, 1); seen != Seen::Part) return seen == Seen::All ? 1 : 0;
  int seen = 0;
  for (int i = 0; i < 64; ++i) {
    const Double3 p = Double3(voxel) + Double3((i & 3) + 0.5, (i >> 2 & 3) + 0.5, (i >> 4) + 0.5) * 0.25;
    seen += isCubeFace(mFrame, cubeFaceTowards(p - mFrame.origin));
  }
  return seen / 64.0;
}

} // namespace volcaustic
