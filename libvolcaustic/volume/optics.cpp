#include "volume/optics.h"

#include "core/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

namespace volcaustic {

namespace {

Vec3f toFloat(const Rgb& c) { return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])}; }

/// Exact at both ends, and where both ends are equal.
float mix(float from, float to, float t) { return t == 1.0f ? to : from + t * (to - from); }
Vec3f mix(const Vec3f& from, const Vec3f& to, float t) {
  return {mix(from[0], to[0], t), mix(from[1], to[1], t), mix(from[2], to[2], t)};
}

template <class T>
std::uint64_t tableBytes(const Domain& domain) {
  std::uint64_t bricks = 1;
  for (const int d : domain.dims) bricks *= static_cast<std::uint64_t>((d + 7) / 8);
  return bricks * (sizeof(T) + sizeof(std::int32_t));
}

/// Replaces the grid's values under the patch by change(value, coverage).
template <class T, class Change>
void paint(BrickGrid<T>& grid, const CoveragePatch& patch, const RunContext& ctx, Change&& change) {
  const BrickGrid<float>& coverage = patch.coverage;
  const auto target = [&](std::int64_t brick) {
    const Vec3i c = coverage.brickCoord(brick);
    return grid.brickIndex({c[0] + patch.firstBrick[0], c[1] + patch.firstBrick[1], c[2] + patch.firstBrick[2]});
  };
  std::vector<std::int64_t> varying;
  for (std::int64_t b = 0; b < coverage.brickCount(); ++b)
    if (!coverage.isConstant(b) && grid.isConstant(target(b))) varying.push_back(target(b));
  ctx.requireMemory(grid.memoryBytes() + varying.size() * kBrickVoxels * sizeof(T), "blending the bodies");
  grid.activate(varying);

  parallelFor(coverage.brickCount(), 512, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t b = begin; b < end; ++b) {
      const bool constant = coverage.isConstant(b);
      if (constant && coverage.constant(b) == 0.0f) continue;
      const std::int64_t to = target(b);
      if (constant && grid.isConstant(to)) {
        grid.setConstant(to, change(grid.constant(to), coverage.constant(b)));
        continue;
      }
      const std::span<T> values = grid.voxels(to);
      for (int v = 0; v < kBrickVoxels; ++v)
        values[v] = change(values[v], constant ? coverage.constant(b) : coverage.voxels(b)[v]);
    }
  });
}

template <class T>
bool uniform(std::span<const T> values) {
  return std::all_of(values.begin() + 1, values.end(), [&](const T& v) { return v == values[0]; });
}

template <class T>
void collapse(BrickGrid<T>& grid, const RunContext& ctx) {
  std::vector<std::uint8_t> isUniform(static_cast<std::size_t>(grid.brickCount()), 0);
  parallelFor(grid.brickCount(), 512, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t b = begin; b < end; ++b)
      if (!grid.isConstant(b)) isUniform[b] = uniform(std::span<const T>(grid.voxels(b)));
  });
  if (std::find(isUniform.begin(), isUniform.end(), 1) == isUniform.end()) return;
  BrickGrid<T> result(grid.dims(), grid.background());
  std::vector<std::int64_t> kept;
  for (std::int64_t b = 0; b < grid.brickCount(); ++b) {
    if (grid.isConstant(b))
      result.setConstant(b, grid.constant(b));
    else if (isUniform[b])
      result.setConstant(b, grid.voxels(b)[0]);
    else
      kept.push_back(b);
  }
  result.activate(kept);
  for (const std::int64_t b : kept) std::copy(grid.voxels(b).begin(), grid.voxels(b).end(), result.voxels(b).begin());
  grid = std::move(result);
}

/// Weights of the taps at distance 1, 2, ... of a normalised Gaussian; the one at 0 is what they leave of 1.
template <int Radius>
std::array<float, Radius> tapWeights() {
  const double sigma = (2 * Radius + 1) / 6.0;
  std::array<double, Radius> w{};
  double sum = 1;
  for (int t = 0; t < Radius; ++t) {
    w[t] = std::exp(-0.5 * (t + 1) * (t + 1) / (sigma * sigma));
    sum += 2 * w[t];
  }
  std::array<float, Radius> result{};
  for (int t = 0; t < Radius; ++t) result[t] = static_cast<float>(w[t] / sum);
  return result;
}

/// out[i] = in[i] + sum over t of w_t ((in[i - t stride] + in[i + t stride]) - 2 in[i]): a convolution whose weights
/// sum to exactly 1, so that constants keep their bits. `in` points at the first centre.
template <int Radius, int Count>
void blurLine(const float* __restrict in, int stride, const std::array<float, Radius>& weights, float* __restrict out) {
  for (int i = 0; i < Count; ++i) out[i] = in[i];
  for (int t = 0; t < Radius; ++t) {
    const int reach = (t + 1) * stride;
    const float weight = weights[t];
    for (int i = 0; i < Count; ++i) out[i] += weight * ((in[i - reach] + in[i + reach]) - 2 * in[i]);
  }
}

template <int Radius>
class BrickBlur {
public:
  explicit BrickBlur(const BrickGrid<float>& grid)
      : mGrid(grid)
      , mWeights(tapWeights<Radius>())
      , mIn(kSide * kSide * kSide)
      , mX(kBrickSize * kSide * kSide)
      , mY(kBrickSize * kBrickSize * kSide) {}

  /// True when the blurred voxels of a brick differ. What is in reach of a constant brick may be too little to show.
  bool varies(const Vec3i& brick) {
    gather(brick);
    if (uniform(std::span<const float>(mIn))) return false;
    if (!mGrid.isConstant(mGrid.brickIndex(brick))) return true;
    std::array<float, kBrickVoxels> out;
    blurGathered(out);
    return !uniform(std::span<const float>(out));
  }

  void run(const Vec3i& brick, std::span<float> out) {
    gather(brick);
    blurGathered(out);
  }

private:
  static constexpr int kSide = kBrickSize + 2 * Radius;

  void blurGathered(std::span<float> out) {
    constexpr int kPlane = kSide * kSide;
    for (int x = 0; x < kBrickSize; ++x)
      blurLine<Radius, kPlane>(&mIn[(x + Radius) * kPlane], kPlane, mWeights, &mX[x * kPlane]);
    for (int x = 0; x < kBrickSize; ++x)
      for (int y = 0; y < kBrickSize; ++y)
        blurLine<Radius, kSide>(&mX[x * kPlane + (y + Radius) * kSide], kSide, mWeights,
                                &mY[(x * kBrickSize + y) * kSide]);
    for (int row = 0; row < kBrickSize * kBrickSize; ++row)
      blurLine<Radius, kBrickSize>(&mY[row * kSide + Radius], 1, mWeights, &out[row * kBrickSize]);
  }

  void gather(const Vec3i& brick) {
    const Vec3i& dims = mGrid.dims();
    std::array<std::array<int, kSide>, 3> at{}; // coordinates, clamped into the domain
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < kSide; ++i) at[a][i] = std::clamp(brick[a] * kBrickSize + i - Radius, 0, dims[a] - 1);
    float* to = mIn.data();
    for (const int x : at[0])
      for (const int y : at[1]) {
        for (int i = 0; i < kSide;) { // a run of a brick's voxels at a time
          const int z = at[2][i], last = std::min({kBrickSize - (z & 7), kSide - i, dims[2] - z});
          const int run = z == at[2][kSide - 1] || at[2][i + 1] == z ? 1 : last; // a clamped voxel comes again
          const std::int64_t b = mGrid.brickIndex({x >> 3, y >> 3, z >> 3});
          if (mGrid.isConstant(b))
            std::fill_n(to, run, mGrid.constant(b));
          else
            std::copy_n(&mGrid.voxels(b)[brickOffset(x, y, z)], run, to);
          to += run;
          i += run;
        }
      }
  }

  const BrickGrid<float>& mGrid;
  std::array<float, Radius> mWeights;
  std::vector<float> mIn, mX, mY;
};

/// Bricks whose voxels a blur of less than a brick's reach can change: those with a neighbour that differs.
std::vector<std::int64_t> bricksInReach(const BrickGrid<float>& grid, const RunContext& ctx) {
  const Vec3i dims = grid.brickDims();
  std::vector<std::uint8_t> inReach(static_cast<std::size_t>(grid.brickCount()), 0);
  parallelFor(dims[0], 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (int x = static_cast<int>(begin); x < end; ++x)
      for (int y = 0; y < dims[1]; ++y)
        for (int z = 0; z < dims[2]; ++z) {
          const std::int64_t self = grid.brickIndex({x, y, z});
          bool differs = !grid.isConstant(self);
          for (int i = std::max(x - 1, 0); i <= std::min(x + 1, dims[0] - 1) && !differs; ++i)
            for (int j = std::max(y - 1, 0); j <= std::min(y + 1, dims[1] - 1) && !differs; ++j)
              for (int k = std::max(z - 1, 0); k <= std::min(z + 1, dims[2] - 1) && !differs; ++k) {
                const std::int64_t other = grid.brickIndex({i, j, k});
                differs = !grid.isConstant(other) || grid.constant(other) != grid.constant(self);
              }
          inReach[self] = differs;
        }
  });
  std::vector<std::int64_t> bricks;
  for (std::int64_t b = 0; b < grid.brickCount(); ++b)
    if (inReach[b]) bricks.push_back(b);
  return bricks;
}

template <int Radius>
BrickGrid<float> blurBy(const BrickGrid<float>& grid, const RunContext& ctx) {
  std::vector<std::int64_t> bricks = bricksInReach(grid, ctx);
  const auto forEachBrick = [&](std::string_view stage, auto&& visit) {
    parallelFor(
        static_cast<std::int64_t>(bricks.size()), 32, ctx,
        [&](std::int64_t begin, std::int64_t end, int) {
          BrickBlur<Radius> blur(grid);
          for (std::int64_t i = begin; i < end; ++i) visit(blur, i);
        },
        stage);
  };
  std::vector<std::uint8_t> varies(bricks.size());
  forEachBrick({},
               [&](BrickBlur<Radius>& blur, std::int64_t i) { varies[i] = blur.varies(grid.brickCoord(bricks[i])); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i)
    if (varies[i]) bricks[kept++] = bricks[i];
  bricks.resize(kept);

  BrickGrid<float> result(grid.dims(), grid.background());
  for (std::int64_t b = 0; b < grid.brickCount(); ++b)
    if (grid.isConstant(b)) result.setConstant(b, grid.constant(b));
  ctx.requireMemory(grid.memoryBytes() + result.memoryBytes() + kept * kBrickVoxels * sizeof(float),
                    "smoothing the index");
  result.activate(bricks);
  forEachBrick("blur", [&](BrickBlur<Radius>& blur, std::int64_t i) {
    blur.run(grid.brickCoord(bricks[i]), result.voxels(bricks[i]));
  });
  return result;
}

} // namespace

OpticsBricks ambientOptics(const Domain& domain, const Ambient& ambient, std::span<const Body> bodies,
                           const RunContext& ctx) {
  const auto anyBody = [&](auto&& differs) {
    return std::any_of(bodies.begin(), bodies.end(), [&](const Body& b) { return differs(b.material); });
  };
  const bool attenuates = anyBody([&](const Material& m) { return m.attenuation != ambient.attenuation; });
  const bool scatters = anyBody([&](const Material& m) { return m.scattering != ambient.scattering; });
  const bool turns = anyBody([&](const Material& m) { return m.asymmetry != ambient.asymmetry; });
  ctx.requireMemory((2 + turns) * tableBytes<float>(domain) + (int{attenuates} + scatters) * tableBytes<Vec3f>(domain),
                    "the medium's bricks");
  OpticsBricks optics;
  optics.index = BrickGrid<float>(domain.dims, static_cast<float>(ambient.index));
  optics.coverage = BrickGrid<float>(domain.dims, 0.0f);
  if (attenuates) optics.attenuation.emplace(domain.dims, toFloat(ambient.attenuation));
  if (scatters) optics.scattering.emplace(domain.dims, toFloat(ambient.scattering));
  if (turns) optics.asymmetry.emplace(domain.dims, static_cast<float>(ambient.asymmetry));
  return optics;
}

void paintBody(OpticsBricks& optics, const CoveragePatch& patch, const Material& material, const RunContext& ctx) {
  const auto towards = [](const auto& end) { return [end](const auto& value, float c) { return mix(value, end, c); }; };
  paint(optics.index, patch, ctx, towards(static_cast<float>(material.index)));
  paint(optics.coverage, patch, ctx, [](float value, float c) { return 1.0f - (1.0f - value) * (1.0f - c); });
  if (optics.attenuation) paint(*optics.attenuation, patch, ctx, towards(toFloat(material.attenuation)));
  if (optics.scattering) paint(*optics.scattering, patch, ctx, towards(toFloat(material.scattering)));
  if (optics.asymmetry) paint(*optics.asymmetry, patch, ctx, towards(static_cast<float>(material.asymmetry)));
}

void collapseUniform(OpticsBricks& optics, const RunContext& ctx) {
  collapse(optics.index, ctx);
  collapse(optics.coverage, ctx);
  if (optics.attenuation) collapse(*optics.attenuation, ctx);
  if (optics.scattering) collapse(*optics.scattering, ctx);
  if (optics.asymmetry) collapse(*optics.asymmetry, ctx);
}

BrickGrid<float> gaussianBlur(const BrickGrid<float>& grid, int width, const RunContext& ctx) {
  switch (width) {
  case 3:
    return blurBy<1>(grid, ctx);
  case 5:
    return blurBy<2>(grid, ctx);
  case 7:
    return blurBy<3>(grid, ctx);
  case 9:
    return blurBy<4>(grid, ctx);
  case 11:
    return blurBy<5>(grid, ctx);
  default:
    return grid;
  }
}

} // namespace volcaustic
