// From the sums of a tracer to a volume of light: every voxel is what one Gaussian over the whole domain makes of it,
// whatever blocks and threads the domain was cut into.

#include "transport/caustic.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

namespace volcaustic::test {
namespace {

using kernels::Int3;

constexpr FixedPoint kScale{1 << 16, 1};
constexpr double kVoxelSize = 0.25;
/// W/m2 of a unit: a deposit of 1/2^16 W*voxel, over the area of a voxel's face.
constexpr double kUnit = 1.0 / (1 << 16) / (kVoxelSize * kVoxelSize);

std::size_t voxelNumber(const Int3& dims, int x, int y, int z) { return (std::size_t(x) * dims.y + y) * dims.z + z; }

/// Holds light in some voxels of a domain, of all magnitudes from a unit to far beyond 32 bits.
class SparseTracer final : public PhotonTracer {
public:
  SparseTracer(const Int3& dims, double lit, unsigned seed) : mDims(dims), mVoxels(voxelNumber(dims, dims.x, 0, 0)) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> u(0, 1);
    std::normal_distribution<double> normal;
    for (std::int64_t i = 0; i < std::int64_t(mVoxels.size()); ++i) {
      const auto z = i % dims.z, y = i / dims.z % dims.y, x = i / dims.z / dims.y;
      const bool corner = (x == 0 || x == dims.x - 1) && (y == 0 || y == dims.y - 1) && (z == 0 || z == dims.z - 1);
      // Nothing in the middle of the domain, so that some bricks and blocks are dark.
      const bool hole = x > dims.x / 3 && x < dims.x * 2 / 3;
      if (!corner && (hole || u(random) > lit)) continue;
      const double brightness = std::exp2(u(random) * 42);
      kernels::Double3 fluence(u(random), u(random), u(random));
      if (i % 5 == 0) fluence.y = 0;
      const kernels::Double3 towards =
          kernels::normalize(kernels::Double3(normal(random), normal(random), normal(random))) *
          (kernels::luminance(fluence) * u(random));
      for (int c = 0; c < 3; ++c) {
        mVoxels[i][c] = static_cast<std::int64_t>(fluence[c] * brightness);
        mVoxels[i][3 + c] = static_cast<std::int64_t>(towards[c] * brightness);
      }
    }
  }

  void emit(const kernels::EmissionFrame&, const kernels::RasterReach&, RowRange, const RasterCells&) override {}
  void trace(const kernels::EmissionFrame&, RowRange, const RasterCells&) override {}
  void finish() override {}
  [[nodiscard]] PhotonTally tally() const override { return {}; }
  [[nodiscard]] std::uint64_t peakBytes() const override { return 0; }

  [[nodiscard]] bool touched(std::int64_t block) const override {
    bool light = false;
    forVoxels(block, [&](int, const VoxelSums&) { light = true; });
    return light;
  }
  void addBlock(std::int64_t block, BlockSums& sums) const override {
    // A part of it through low(), as tracers that deposit there do, then the rest.
    const auto part = [](std::int64_t s) { return std::clamp<std::int64_t>(s, -(1 << 29), 1 << 29); };
    forVoxels(block, [&](int voxel, const VoxelSums& s) {
      std::int32_t* low = sums.low() + std::ptrdiff_t{8} * voxel;
      for (int c = 0; c < kSums; ++c) low[c < 3 ? c : c + 1] += static_cast<std::int32_t>(part(s[c]));
    });
    sums.carry();
    forVoxels(block, [&](int voxel, VoxelSums s) {
      for (std::int64_t& rest : s) rest -= part(rest);
      sums.add(voxel, s);
    });
  }
  [[nodiscard]] const std::vector<VoxelSums>& voxels() const { return mVoxels; }

private:
  template <class Visit>
  void forVoxels(std::int64_t block, const Visit& visit) const {
    const Int3 corner = blockCorner(blockDims(mDims), block);
    const auto first = [](int c) { return std::max(c - 1, 0); };
    const auto end = [](int c, int dim) { return std::min(c + kBlockEdge + 1, dim); };
    for (int x = first(corner.x); x < end(corner.x, mDims.x); ++x)
      for (int y = first(corner.y); y < end(corner.y, mDims.y); ++y)
        for (int z = first(corner.z); z < end(corner.z, mDims.z); ++z)
          if (const VoxelSums& s = mVoxels[voxelNumber(mDims, x, y, z)]; s != VoxelSums{})
            visit(sumsOffset(x - corner.x, y - corner.y, z - corner.z), s);
  }

  Int3 mDims;
  std::vector<VoxelSums> mVoxels;
};

FlatMediumStorage emptyMedium(const Int3& dims, const Ambient& ambient = {}) {
  return flattenMedium(buildMedium({}, ambient, {{0, 0, 0}, kVoxelSize, {dims.x, dims.y, dims.z}}), {}, {});
}

/// The Gaussian over the whole domain, in double precision; values before the faces stand beyond them.
std::vector<std::array<double, 6>> light(const Int3& dims, const std::vector<VoxelSums>& sums, bool smooth) {
  std::vector<std::array<double, 6>> values(sums.size());
  for (std::size_t v = 0; v < sums.size(); ++v)
    for (int i = 0; i < 6; ++i) values[v][i] = static_cast<double>(sums[v][i]) * kUnit;
  for (int axis = 0; smooth && axis < 3; ++axis) {
    const auto before = values;
    for (int x = 0; x < dims.x; ++x)
      for (int y = 0; y < dims.y; ++y)
        for (int z = 0; z < dims.z; ++z) {
          int low[3] = {x, y, z}, high[3] = {x, y, z};
          low[axis] = std::max(low[axis] - 1, 0);
          high[axis] = std::min(high[axis] + 1, dims[axis] - 1);
          const auto &a = before[voxelNumber(dims, low[0], low[1], low[2])], &b = before[voxelNumber(dims, x, y, z)],
                     &c = before[voxelNumber(dims, high[0], high[1], high[2])];
          for (int i = 0; i < 6; ++i) values[voxelNumber(dims, x, y, z)][i] = (a[i] + 2 * b[i] + c[i]) / 4;
        }
  }
  return values;
}

/// Every voxel of the grid, z fastest.
std::vector<kernels::Light> lightOf(const FluenceGrid& grid) {
  std::vector<kernels::Light> all;
  const kernels::FluenceField field = grid.view();
  for (int x = 0; x < grid.dims()[0]; ++x)
    for (int y = 0; y < grid.dims()[1]; ++y)
      for (int z = 0; z < grid.dims()[2]; ++z) all.push_back(field.at({x, y, z}));
  return all;
}

class CausticLight : public testing::TestWithParam<Int3> {};
// Blocks and bricks that the domain fills, that it ends in, that it ends just before and just behind.
INSTANTIATE_TEST_SUITE_P(Domains, CausticLight,
                         testing::Values(Int3(8, 8, 8), Int3(1, 1, 1), Int3(2, 3, 1), Int3(33, 40, 7), Int3(64, 64, 64),
                                         Int3(37, 50, 61), Int3(100, 9, 70), Int3(32, 31, 33), Int3(65, 34, 97)),
                         [](const auto& dims) {
                           return std::to_string(dims.param.x) + "x" + std::to_string(dims.param.y) + "x" +
                                  std::to_string(dims.param.z);
                         });

// A voxel's light is stored with 20 bits of its largest channel: 2e-6 of it for the fluence, 4e-6 for the direction.
TEST_P(CausticLight, IsTheGaussianOfTheSums) {
  const Int3 dims = GetParam();
  const FlatMediumStorage flat = emptyMedium(dims);
  for (const double lit : {.03, .7})
    for (const bool smooth : {true, false}) {
      SCOPED_TRACE(testing::Message() << "lit " << lit << (smooth ? " smooth" : ""));
      const SparseTracer tracer(dims, lit, 1);
      FluenceGrid grid({dims.x, dims.y, dims.z});
      (void)gatherCaustic(tracer, flat, kVoxelSize, kScale, smooth, grid, {});
      const std::vector<kernels::Light> got = lightOf(grid);
      const auto expected = light(dims, tracer.voxels(), smooth);
      double totals[2][3] = {}, largest = 0;
      for (std::size_t v = 0; v < got.size(); ++v) {
        const double most = std::max({expected[v][0], expected[v][1], expected[v][2]});
        for (int c = 0; c < 3; ++c) {
          ASSERT_NEAR(got[v].fluence[c], expected[v][c], 2e-6 * most) << "voxel " << v;
          ASSERT_NEAR(got[v].towards[c], expected[v][3 + c], 4e-6 * most) << "voxel " << v;
          totals[0][c] += got[v].fluence[c];
          totals[1][c] += static_cast<double>(tracer.voxels()[v][c]) * kUnit;
        }
        largest += most;
      }
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(totals[0][c], totals[1][c], 1e-6 * largest) << "the total";
    }
}

TEST_P(CausticLight, CostsMemoryWhereThereIsSome) {
  const Int3 dims = GetParam();
  const SparseTracer tracer(dims, .001, 2);
  FluenceGrid grid({dims.x, dims.y, dims.z});
  (void)gatherCaustic(tracer, emptyMedium(dims), kVoxelSize, kScale, true, grid, {});
  const auto expected = light(dims, tracer.voxels(), true);
  const kernels::FluenceField field = grid.view();
  for (std::int64_t b = 0; b < grid.brickCount(); ++b) {
    const Vec3i c = grid.brickCoord(b);
    bool lit = false;
    for (int k = 0; k < kBrickVoxels; ++k) {
      const Int3 v(8 * c[0] + (k >> 6), 8 * c[1] + (k >> 3 & 7), 8 * c[2] + (k & 7));
      if (v.x < dims.x && v.y < dims.y && v.z < dims.z) {
        const auto& e = expected[voxelNumber(dims, v.x, v.y, v.z)];
        lit = lit || std::max({e[0], e[1], e[2]}) > 0;
      } else if (!grid.isDark(b)) {
        ASSERT_EQ(kernels::maxComponent(field.at(field.entries[b], v).fluence), 0) << "outside the domain";
      }
    }
    EXPECT_EQ(!grid.isDark(b), lit) << "brick " << b;
  }
}

TEST_P(CausticLight, IsTheSameBitsOnAnyNumberOfThreads) {
  const Int3 dims = GetParam();
  const SparseTracer tracer(dims, .1, 3);
  const FlatMediumStorage flat = emptyMedium(dims);
  std::vector<std::vector<kernels::Light>> all;
  for (const int threads : {1, 2, 3}) {
    RunContext ctx;
    ctx.threads = threads;
    FluenceGrid grid({dims.x, dims.y, dims.z});
    (void)gatherCaustic(tracer, flat, kVoxelSize, kScale, true, grid, ctx);
    all.push_back(lightOf(grid));
    for (std::size_t v = 0; v < all[0].size(); ++v)
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(all.back()[v].fluence[c], all[0][v].fluence[c]);
        ASSERT_EQ(all.back()[v].towards[c], all[0][v].towards[c]);
      }
  }
}

// What the medium takes is attenuation times light, over each voxel once: blocks hold their neighbours' voxels too.
TEST_P(CausticLight, LosesWhatTheMediumTakes) {
  const Int3 dims = GetParam();
  const SparseTracer tracer(dims, .2, 4);
  Ambient fog;
  fog.attenuation = {.8, .2, 0};
  kernels::Double3 all(0, 0, 0);
  for (const VoxelSums& s : tracer.voxels())
    all += kernels::Double3(static_cast<double>(s[0]), static_cast<double>(s[1]), static_cast<double>(s[2]));
  for (const bool smooth : {true, false}) {
    FluenceGrid grid({dims.x, dims.y, dims.z});
    const Rgb loss = gatherCaustic(tracer, emptyMedium(dims, fog), kVoxelSize, kScale, smooth, grid, {});
    for (int c = 0; c < 3; ++c) {
      const double expected = all[c] / kScale.deposit * fog.attenuation[c] * kVoxelSize;
      EXPECT_NEAR(loss[c], expected, 1e-6 * expected) << "channel " << c;
    }
  }
}

TEST(CausticLightMemory, BeyondTheLimitIsOneErrorLine) {
  const Int3 dims(128, 128, 128);
  const SparseTracer tracer(dims, .1, 5);
  const FlatMediumStorage flat = emptyMedium(dims);
  RunContext ctx;
  ctx.memoryLimit = 4 << 20;
  FluenceGrid grid({dims.x, dims.y, dims.z});
  try {
    (void)gatherCaustic(tracer, flat, kVoxelSize, kScale, true, grid, ctx);
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    const std::string line = e.what();
    EXPECT_NE(line.find("memory"), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
}

} // namespace
} // namespace volcaustic::test
