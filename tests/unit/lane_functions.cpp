// The parts that an instruction set offers, one by one, against the reference and against plain definitions.

#include "backends/lanes.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {
namespace {

using kernels::Double3;
using kernels::Float3;
using kernels::Int3;
using kernels::LitLengths;
using kernels::LitView;

class LaneFunctions : public testing::TestWithParam<std::string> {
protected:
  const LaneSet& mSet = laneSet(GetParam());
};
using Random = std::mt19937_64;

Float3 unitVector(Random& random) {
  std::normal_distribution<double> n;
  return Float3(kernels::normalize(Double3(n(random), n(random), n(random))));
}

/// A footprint of some size over a voxel, with bends before, in and behind it.
LitView randomView(Random& random, int columns, int rows, bool point, bool aligned) {
  std::uniform_real_distribution<float> u(-1, 1);
  LitView view{};
  view.axisW = aligned ? Float3(0, 0, u(random) < 0 ? -1 : 1) : unitVector(random);
  view.axisU = aligned ? Float3(1, 0, 0) : kernels::normalize(kernels::cross(view.axisW, unitVector(random)));
  view.axisV = kernels::cross(view.axisW, view.axisU);
  view.point = point;
  view.columns = columns;
  view.cells = columns * rows;
  view.mapStride = columns + 3;
  view.first = 5;
  const float across = 2.2f; // rays beside the voxel too
  view.distance = point ? 3 + 100 * std::abs(u(random)) : 0;
  const float size = point ? across / view.distance : across;
  view.du = size / static_cast<float>(columns);
  view.dv = size / static_cast<float>(rows);
  const float leanU = point ? 0.4f * u(random) : 0, leanV = point ? 0.4f * u(random) : 0;
  view.u0 = leanU - 0.5f * size + 0.5f * view.du;
  view.v0 = leanV - 0.5f * size + 0.5f * view.dv;
  view.towards = kernels::normalize(view.axisW + view.axisU * leanU + view.axisV * leanV);
  view.shift = 10 * u(random);
  return view;
}

TEST_P(LaneFunctions, LitLengthsAreTheReferences) {
  Random random(1);
  std::uniform_real_distribution<float> depth(-1.2f, 1.2f);
  double sum = 0;
  for (const auto& [columns, rows] : {std::pair{1, 1}, {1, 9}, {3, 5}, {4, 4}, {8, 2}, {17, 1}, {9, 11}, {33, 31}})
    for (int i = 0; i < 200; ++i) {
      const LitView view = randomView(random, columns, rows, i & 1, i & 2);
      std::vector<float> entry(5 + std::size_t(view.mapStride) * rows);
      for (float& e : entry) e = i % 5 == 0 ? kernels::kNeverBends : depth(random) - view.shift;
      const LitLengths<float> a = mSet.litLengths(view, entry.data()),
                              b = laneSet("scalar").litLengths(view, entry.data());
      ASSERT_TRUE(b.lit >= 0 && b.lit <= b.all * 1.00001f);
      // A ray's place is good to a unit in the last place of the light's distance.
      const float tolerance = static_cast<float>(view.cells) * 1e-4f;
      ASSERT_NEAR(a.all, b.all, tolerance) << columns << 'x' << rows << " number " << i;
      ASSERT_NEAR(a.lit, b.lit, tolerance) << columns << 'x' << rows << " number " << i;
      if (i % 5 == 0) {
        ASSERT_EQ(a.lit, a.all);
      }
      sum += b.all;
    }
  EXPECT_GT(sum, 1000);
}

// Rays along an axis through every place of a voxel: all of them cross it from face to face.
TEST_P(LaneFunctions, LitLengthsOfRaysAlongAnAxis) {
  LitView view{};
  view.axisU = {1, 0, 0}, view.axisV = {0, 1, 0}, view.axisW = {0, 0, 1};
  view.columns = 7, view.cells = 35, view.mapStride = 7;
  view.du = 1.0f / 7, view.dv = 1.0f / 5, view.u0 = -3.0f / 7, view.v0 = -2.0f / 5;
  std::vector<float> entry(35, kernels::kNeverBends);
  for (int i = 0; i < 10; ++i) entry[i] = 0.25f; // three quarters before the bend
  for (int i = 10; i < 15; ++i) entry[i] = -2;   // behind it
  const LitLengths<float> l = mSet.litLengths(view, entry.data());
  EXPECT_NEAR(l.all, 35, 1e-4);
  EXPECT_NEAR(l.lit, 20 + 10 * .75, 1e-4);
}

/// Sums of a cube of kEdge^3 voxels and those around it, with some voxels' carried sums; light is never negative, and
/// neither is it less than its direction's length.
template <int kEdge, class T>
struct RandomSums {
  std::vector<T> sums = std::vector<T>(std::size_t(kEdge + 2) * (kEdge + 2) * (kEdge + 2) * 8);
  std::vector<kernels::CarriedSums> carried;
  kernels::LightSums<T> light{};

  RandomSums(Random& random, int round) {
    std::uniform_real_distribution<double> u(0, 1);
    const bool sparse = round % 3 == 0;
    for (std::size_t v = 0; v < sums.size() / 8; ++v) {
      if (sparse && u(random) < .98) continue;
      double fluence[3], scale = std::is_integral_v<T> ? 1e9 : std::pow(10.0, 70 * u(random) - 38); // denormal ones too
      if (round % 2) scale = 1;
      for (double& f : fluence) f = u(random) < .1 ? 0 : u(random) * scale;
      const Float3 towards = unitVector(random) * static_cast<float>(u(random));
      const double l = kernels::luminance(Double3(fluence[0], fluence[1], fluence[2]));
      for (int c = 0; c < 3; ++c) {
        sums[8 * v + c] = static_cast<T>(fluence[c]);
        sums[8 * v + 4 + c] = static_cast<T>(towards[c] * l);
      }
      if constexpr (std::is_integral_v<T>)
        if (u(random) < .01)
          carried.push_back({static_cast<std::int32_t>(v), {5e9f, 3e12f, 1e10f, 0, 1e9f, -2e12f, 1.5e3f, 0}});
    }
    light.sums = sums.data();
    light.carried = carried.data();
    light.carriedCount = static_cast<std::int32_t>(carried.size());
    light.unit = std::is_integral_v<T> ? 1e-5f : 1;
    light.smooth = round % 5 != 4;
    for (int a = 0; a < 3; ++a) {
      light.from[a] = static_cast<std::int32_t>(random() % 2);
      light.to[a] = random() % 2 ? kEdge + 2 : 2 + static_cast<std::int32_t>(random() % kEdge);
    }
  }
};
constexpr kernels::FluenceVoxel kUnwritten{{1, 2, 3, 4}};
bool sameWords(const kernels::FluenceVoxel& a, const kernels::FluenceVoxel& b) {
  return std::equal(a.words, a.words + 4, b.words);
}

TEST_P(LaneFunctions, FinishedBricksAreTheReferencesBitForBit) {
  Random random(2);
  for (int round = 0; round < 200; ++round) {
    const RandomSums<8, float> in(random, round);
    std::vector<kernels::FluenceVoxel> out(512, kUnwritten), reference(512, kUnwritten);
    mSet.finishBrick(in.light, out.data());
    laneSet("scalar").finishBrick(in.light, reference.data());
    for (int k = 0; k < 512; ++k) ASSERT_TRUE(sameWords(out[k], reference[k])) << "round " << round << " voxel " << k;
  }
}

TEST_P(LaneFunctions, FinishedBlocksAreTheReferencesBitForBit) {
  Random random(3);
  for (int round = 0; round < 12; ++round) {
    const RandomSums<kBlockEdge, std::int32_t> in(random, round);
    const auto finish = [&](const LaneSet& set, std::vector<kernels::FluenceVoxel>& voxels) {
      std::array<kernels::FluenceVoxel*, 64> bricks;
      for (std::size_t b = 0; b < bricks.size(); ++b) bricks[b] = &voxels[b * 512];
      return set.finishBlock(in.light, bricks.data());
    };
    std::vector<kernels::FluenceVoxel> out(64 * 512, kUnwritten), reference = out;
    EXPECT_EQ(finish(mSet, out), finish(laneSet("scalar"), reference)) << "round " << round;
    for (int k = 0; k < 64 * 512; ++k)
      ASSERT_TRUE(sameWords(out[k], reference[k])) << "round " << round << " voxel " << k;
  }
}

// One voxel's light goes to its neighbours by the binomial, and to bricks that say so.
TEST_P(LaneFunctions, FinishedBlocksWeighNeighboursByTheBinomial) {
  std::vector<std::int32_t> sums(std::size_t{kSumsVoxels} * 8);
  const Int3 lit(7, 16, 31); // at the end of a brick, at the beginning of one, at the end of the block
  sums[std::size_t(sumsOffset(lit.x, lit.y, lit.z)) * 8 + 1] = 64;
  std::vector<kernels::FluenceVoxel> voxels(64 * 512, kUnwritten);
  std::array<kernels::FluenceVoxel*, 64> bricks;
  for (std::size_t b = 0; b < bricks.size(); ++b) bricks[b] = &voxels[b * 512];
  const kernels::LightSums<std::int32_t> light{sums.data(), nullptr, 0, {0, 0, 0}, {kSumsEdge, kSumsEdge, kSumsEdge},
                                               1,           true};
  std::uint64_t expected = 0;
  const std::uint64_t bits = mSet.finishBlock(light, bricks.data());
  for (int x = 0; x < 32; ++x)
    for (int y = 0; y < 32; ++y)
      for (int z = 0; z < 32; ++z) {
        const auto weight = [](int d) { return d == 0 ? 2 : d == 1 || d == -1 ? 1 : 0; };
        const int w = weight(x - lit.x) * weight(y - lit.y) * weight(z - lit.z);
        const int brick = (x / 8 * 4 + y / 8) * 4 + z / 8;
        const kernels::Light l = kernels::unpack(bricks[brick][(x & 7) << 6 | (y & 7) << 3 | (z & 7)]);
        ASSERT_EQ(l.fluence.y, float(w)) << x << ' ' << y << ' ' << z;
        ASSERT_EQ(l.fluence.x + l.fluence.z, 0);
        if (w > 0) expected |= std::uint64_t{1} << brick;
      }
  EXPECT_EQ(bits, expected);
  EXPECT_EQ(std::popcount(bits), 4);
}

// Irradiance, or intensity over distance squared, through the fog on the way: in double precision, by its definition.
TEST_P(LaneFunctions, LightAroundABrickIsTheLampsLight) {
  Random random(5);
  std::uniform_real_distribution<double> u(0, 1);
  const Int3 dims(40, 33, 61);
  for (int round = 0; round < 60; ++round) {
    kernels::Lamp lamp;
    lamp.point = round % 2;
    lamp.clear = round % 4 < 2;
    lamp.box = Float3(dims);
    lamp.strength = {3, 100, .5f};
    lamp.direction = round % 8 == 2 ? Float3(0, -1, 0) : unitVector(random);
    if (!lamp.clear) lamp.attenuation = {.01f, .05f, 0};
    lamp.origin = Float3(Double3(u(random) * 120 - 40, u(random) * 120 - 40, u(random) * 120 - 40));
    const Int3 low(static_cast<int>(random() % 6) * 8 - 9, static_cast<int>(random() % 5) * 8 - 1,
                   static_cast<int>(random() % 8) * 8 - 1);
    std::vector<float> parts(kAroundPadded), sums(std::size_t{kAroundVoxels} * 8);
    for (float& part : parts) part = random() % 3 ? static_cast<float>(u(random)) : 0;
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = i % 4 == 3 ? 0 : 1;
    mSet.lightAround(lamp, low, dims, parts.data(), sums.data());
    for (int k = 0; k < kAroundVoxels; ++k) {
      const auto centre = [](int c, int dim) { return std::clamp(c, 0, dim - 1) + .5; };
      const Double3 p(centre(low.x + k / 100, dims.x), centre(low.y + k / 10 % 10, dims.y),
                      centre(low.z + k % 10, dims.z));
      const Double3 r = p - Double3(lamp.origin);
      const Double3 direction = lamp.point ? kernels::normalize(r) : Double3(lamp.direction);
      double way = lamp.point ? kernels::length(r) : 1e30;
      for (int a = 0; a < 3; ++a)
        if (std::abs(direction[a]) > 1e-6)
          way = std::min(way, (p[a] - (direction[a] > 0 ? 0.0 : double(dims[a]))) / direction[a]);
      Double3 fluence(lamp.strength);
      for (double* c : {&fluence.x, &fluence.y, &fluence.z}) {
        const double attenuation = lamp.attenuation[static_cast<int>(c - &fluence.x)];
        *c *= std::exp(-attenuation * way) / (lamp.point ? std::max(kernels::dot(r, r), .25) : 1);
      }
      const double part = parts[k], most = 1 + kernels::maxComponent(fluence);
      const float* sum = &sums[std::size_t(k) * 8];
      for (int a = 0; a < 3; ++a) {
        ASSERT_NEAR(sum[a], 1 + part * fluence[a], 1e-5 * most) << "round " << round << " voxel " << k;
        ASSERT_NEAR(sum[4 + a], 1 + part * direction[a] * kernels::luminance(fluence), 1e-5 * most)
            << "round " << round << " voxel " << k;
      }
      ASSERT_EQ(sum[3], 0);
      ASSERT_EQ(sum[7], 0);
    }
  }
}

std::vector<std::string> names() {
  std::vector<std::string> n;
  for (const LaneSet& set : laneSets()) n.emplace_back(set.name);
  return n;
}
INSTANTIATE_TEST_SUITE_P(All, LaneFunctions, testing::ValuesIn(names()), [](const auto& set) { return set.param; });

TEST(LaneSets, AreWidestFirstAndEndWithTheReference) {
  const auto sets = laneSets();
  ASSERT_FALSE(sets.empty());
  EXPECT_EQ(sets.back().name, "scalar");
  EXPECT_EQ(sets.back().width, 1);
  for (std::size_t i = 1; i < sets.size(); ++i) EXPECT_GT(sets[i - 1].width, sets[i].width);
  EXPECT_EQ(laneSet("").name, sets.front().name);
  for (const LaneSet& set : sets) EXPECT_EQ(&laneSet(set.name), &set);
}

TEST(LaneSets, OthersAreRefusedByName) {
  for (const std::string name : {"sse", "AVX2", "avx", " scalar", "avx512", "avx2"}) {
    SCOPED_TRACE(name);
    if (std::any_of(laneSets().begin(), laneSets().end(), [&](const LaneSet& s) { return s.name == name; })) continue;
    try {
      (void)laneSet(name);
      FAIL() << "no error";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), name == "avx512" || name == "avx2" ? ErrorKind::Device : ErrorKind::Usage);
      const std::string line = e.what();
      EXPECT_EQ(line.find('\n'), std::string::npos);
      EXPECT_NE(line.find("cpu:" + name), std::string::npos);
      EXPECT_NE(line.find("scalar"), std::string::npos) << "it says what there is";
    }
  }
}

} // namespace
} // namespace volcaustic::test
