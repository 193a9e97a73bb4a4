#include "volume/optics.h"

#include "core/brick_set.h"
#include "core/parallel.h"
#include "core/simd_clones.h"
#include "volume/brick_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

namespace volcaustic {

namespace {

Vec3f toFloat(const Rgb& c) { return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])}; }

using kernels::mixTo;
Vec3f mixTo(const Vec3f& from, const Vec3f& to, float t) {
  return {mixTo(from[0], to[0], t), mixTo(from[1], to[1], t), mixTo(from[2], to[2], t)};
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
  const std::vector<std::int64_t> painted = coverage.occupied();
  struct Target {
    std::int64_t brick;
    bool wasConstant;
    T before;
  };
  std::vector<Target> targets(painted.size());
  std::vector<std::int64_t> varying;
  for (std::size_t i = 0; i < painted.size(); ++i) {
    const Vec3i c = coverage.brickCoord(painted[i]);
    Target& to = targets[i];
    to.brick = grid.brickIndex({c[0] + patch.firstBrick[0], c[1] + patch.firstBrick[1], c[2] + patch.firstBrick[2]});
    to.wasConstant = grid.isConstant(to.brick);
    if (to.wasConstant) to.before = grid.constant(to.brick);
    if (to.wasConstant && !coverage.isConstant(painted[i])) varying.push_back(to.brick);
  }
  ctx.requireMemory(grid.memoryBytes() + varying.size() * kBrickVoxels * sizeof(T), "blending the bodies");
  grid.activate(varying, Fill::Later);

  parallelFor(static_cast<std::int64_t>(painted.size()), 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      const Target& to = targets[i];
      if (coverage.isConstant(painted[i])) {
        const float c = coverage.constant(painted[i]);
        if (to.wasConstant)
          grid.setConstant(to.brick, change(to.before, c));
        else
          for (T& value : grid.voxels(to.brick)) value = change(value, c);
        continue;
      }
      const std::span<const float> c = coverage.voxels(painted[i]);
      const std::span<T> values = grid.voxels(to.brick);
      for (int v = 0; v < kBrickVoxels; ++v) values[v] = change(to.wasConstant ? to.before : values[v], c[v]);
    }
  });
}

template <class T>
bool uniform(std::span<const T> values) {
  return std::all_of(values.begin() + 1, values.end(), [&](const T& v) { return v == values[0]; });
}

template <class T>
void collapse(BrickGrid<T>& grid, const RunContext& ctx) {
  const std::vector<std::int64_t> occupied = grid.occupied();
  std::vector<std::uint8_t> isUniform(occupied.size(), 0);
  const auto forEach = [&](auto&& visit) {
    parallelFor(static_cast<std::int64_t>(occupied.size()), 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) visit(i, occupied[i]);
    });
  };
  forEach([&](std::int64_t i, std::int64_t b) {
    if (!grid.isConstant(b)) isUniform[i] = uniform(std::span<const T>(grid.voxels(b)));
  });
  if (std::find(isUniform.begin(), isUniform.end(), 1) == isUniform.end()) return;
  BrickGrid<T> result(grid.dims(), grid.background());
  std::vector<std::int64_t> kept;
  for (std::size_t i = 0; i < occupied.size(); ++i)
    if (!grid.isConstant(occupied[i]) && !isUniform[i]) kept.push_back(occupied[i]);
  result.activate(kept, Fill::Later);
  forEach([&](std::int64_t i, std::int64_t b) {
    if (grid.isConstant(b))
      result.setConstant(b, grid.constant(b));
    else if (isUniform[i])
      result.setConstant(b, grid.voxels(b)[0]);
    else
      std::copy(grid.voxels(b).begin(), grid.voxels(b).end(), result.voxels(b).begin());
  });
  grid = std::move(result);
}

/// Of Count places in a row; `in` points at the first.
template <int Radius, int Count, int Stride>
inline void blurLine(const float* __restrict in, const kernels::BlurWeights& weights, float* __restrict out) {
  for (int i = 0; i < Count; ++i) out[i] = kernels::blurTap<Radius, Stride>(in + i, weights.of);
}

template <int Radius>
class BrickBlur {
public:
  explicit BrickBlur(const BrickGrid<float>& grid) : mGrid(grid), mWeights(gaussianWeights(2 * Radius + 1)) {}

  /// True when the blurred voxels of a brick differ. What is in reach of a constant brick may be too little to show.
  bool varies(std::int64_t b) {
    const Vec3i brick = mGrid.brickCoord(b);
    if (!mGrid.isConstant(b) && !sticksOut(brick)) return true;
    mIn.gather(mGrid, brick);
    if (mIn.uniform()) return false;
    if (!mGrid.isConstant(b)) return true;
    std::array<float, kBrickVoxels> out;
    blur(out.data());
    return !uniform(std::span<const float>(out));
  }

  void run(std::int64_t b, std::span<float> out) {
    mIn.gather(mGrid, mGrid.brickCoord(b));
    blur(out.data());
  }

private:
  using Block = BrickBlock<float, Radius, Radius>;

  /// A brick that varies may do so beyond the domain only.
  [[nodiscard]] bool sticksOut(const Vec3i& brick) const {
    const Vec3i& dims = mGrid.dims();
    return (brick[0] + 1) * kBrickSize > dims[0] || (brick[1] + 1) * kBrickSize > dims[1] ||
           (brick[2] + 1) * kBrickSize > dims[2];
  }

  VOLCAUSTIC_SIMD_CLONES void blur(float* out) {
    constexpr int kRow = Block::kRow, kPlane = Block::kPlane;
    blurLine<Radius, kBrickSize * kPlane, kPlane>(mIn.data() + Radius * kPlane, mWeights, mX.data());
    for (int x = 0; x < kBrickSize; ++x)
      blurLine<Radius, kBrickSize * kRow, kRow>(&mX[x * kPlane + Radius * kRow], mWeights, &mY[x * kBrickSize * kRow]);
    for (int row = 0; row < kBrickSize * kBrickSize; ++row)
      blurLine<Radius, kBrickSize, 1>(&mY[row * kRow + Radius], mWeights, out + row * kBrickSize);
  }

  const BrickGrid<float>& mGrid;
  kernels::BlurWeights mWeights;
  Block mIn;
  std::array<float, kBrickSize * Block::kPlane> mX;
  std::array<float, kBrickSize * kBrickSize * Block::kRow> mY;
};

/// Bricks whose voxels a blur of less than a brick's reach can change: those with a neighbour that differs.
std::vector<std::int64_t> bricksInReach(const BrickGrid<float>& grid, const std::vector<std::int64_t>& occupied) {
  BrickSet around(grid.brickDims());
  around.insertAround(occupied);
  std::vector<std::int64_t> bricks = around.sorted();
  std::erase_if(bricks, [&](std::int64_t b) { return grid.uniformAround(b); });
  return bricks;
}

template <int Radius>
BrickGrid<float> blurBy(const BrickGrid<float>& grid, const RunContext& ctx) {
  const std::vector<std::int64_t> occupied = grid.occupied();
  std::vector<std::int64_t> bricks = bricksInReach(grid, occupied);
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
  forEachBrick({}, [&](BrickBlur<Radius>& blur, std::int64_t i) { varies[i] = blur.varies(bricks[i]); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i)
    if (varies[i]) bricks[kept++] = bricks[i];
  bricks.resize(kept);

  BrickGrid<float> result(grid.dims(), grid.background());
  // A brick whose voxels differ beyond the domain only has the value of those inside, of which the first is one.
  for (const std::int64_t b : occupied)
    result.setConstant(b, grid.isConstant(b) ? grid.constant(b) : grid.voxels(b)[0]);
  ctx.requireMemory(grid.memoryBytes() + result.memoryBytes() + kept * kBrickVoxels * sizeof(float),
                    "smoothing the index");
  result.activate(bricks, Fill::Later);
  forEachBrick("blur", [&](BrickBlur<Radius>& blur, std::int64_t i) { blur.run(bricks[i], result.voxels(bricks[i])); });
  return result;
}

} // namespace

kernels::BlurWeights gaussianWeights(int width) {
  const double sigma = width / 6.0;
  const int radius = width / 2;
  std::array<double, kernels::kMostBlurRadius> w{};
  double sum = 1;
  for (int t = 0; t < radius; ++t) {
    w[t] = std::exp(-0.5 * (t + 1) * (t + 1) / (sigma * sigma));
    sum += 2 * w[t];
  }
  kernels::BlurWeights weights{};
  for (int t = 0; t < radius; ++t) weights.of[t] = static_cast<float>(w[t] / sum);
  return weights;
}

std::uint8_t changedGrids(const Ambient& ambient, std::span<const Body> bodies) {
  std::uint8_t grids = kernels::kIndexBit | kernels::kCoverageBit;
  for (const Body& body : bodies) {
    const Material& m = body.material;
    if (m.attenuation != ambient.attenuation) grids |= kernels::kAttenuationBit;
    if (m.scattering != ambient.scattering) grids |= kernels::kScatteringBit;
    if (m.asymmetry != ambient.asymmetry) grids |= kernels::kAsymmetryBit;
  }
  return grids;
}

OpticsBricks ambientOptics(const Domain& domain, const Ambient& ambient, std::span<const Body> bodies,
                           const RunContext& ctx) {
  const std::uint8_t grids = changedGrids(ambient, bodies);
  const bool attenuates = grids & kernels::kAttenuationBit, scatters = grids & kernels::kScatteringBit;
  const bool turns = grids & kernels::kAsymmetryBit;
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
  const auto towards = [](const auto& end) {
    return [end](const auto& value, float c) { return mixTo(value, end, c); };
  };
  paint(optics.index, patch, ctx, towards(static_cast<float>(material.index)));
  paint(optics.coverage, patch, ctx, kernels::coverTo);
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
