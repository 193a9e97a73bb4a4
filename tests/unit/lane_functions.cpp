// The parts that an instruction set offers, one by one, against the reference and against plain definitions.

#include "backends/lanes.h"
#include "kernels/traverse.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <random>
#include <set>

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

TEST_P(LaneFunctions, SmoothBrickIsTheReferencesBitForBit) {
  Random random(2);
  std::uniform_real_distribution<float> u(0, 1);
  constexpr int kIn = 3000, kOut = 1536;
  for (int round = 0; round < 100; ++round) {
    alignas(64) float in[kIn], out[kOut], reference[kOut];
    for (float& v : in) {
      const float scale = std::pow(10.0f, 70 * u(random) - 38); // denormal numbers too
      v = round % 2 ? u(random) : round % 4 ? scale : (u(random) < .9f ? 0.0f : u(random));
    }
    mSet.smoothBrick(in, out);
    laneSet("scalar").smoothBrick(in, reference);
    ASSERT_EQ(std::memcmp(out, reference, sizeof out), 0) << "round " << round;
  }
}

TEST_P(LaneFunctions, SmoothBrickWeighsNeighboursByTheBinomial) {
  std::vector<float> in(3000), out(1536);
  in[3 * (4 * 100 + 5 * 10 + 6) + 1] = 64; // one voxel, in the block's coordinates
  mSet.smoothBrick(in.data(), out.data());
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; ++z) {
        const auto weight = [](int d) { return d == 0 ? 2 : d == 1 || d == -1 ? 1 : 0; };
        const float* v = &out[3 * (x * 64 + y * 8 + z)];
        ASSERT_EQ(v[0], 0);
        ASSERT_EQ(v[1], float(weight(x - 3) * weight(y - 4) * weight(z - 5)));
        ASSERT_EQ(v[2], 0);
      }
}

constexpr Int3 kDims{100, 70, 128}, kBlocks{4, 3, 4};
constexpr float kScale = 1 << 16;

FarChord chordBetween(const Double3& from, const Double3& to, const Float3& power, const Float3& slope) {
  const Double3 way = to - from;
  const double length = kernels::length(way);
  FarChord c{};
  for (int i = 0; i < 3; ++i) {
    c.start[i] = static_cast<float>(from[i]);
    c.direction[i] = static_cast<float>(way[i] / length);
    c.power[i] = power[i];
    c.slope[i] = slope[i];
  }
  c.length = static_cast<float>(length);
  return c;
}

/// W*voxel by voxel of the domain: RGB, then direction times luminance.
using Light = std::vector<std::array<double, 6>>;
std::size_t voxelNumber(const Int3& v) { return (std::size_t(v.x) * kDims.y + v.y) * kDims.z + v.z; }

Light walked(const std::vector<FarChord>& chords) {
  Light light(voxelNumber({kDims.x, 0, 0}));
  for (const FarChord& c : chords) {
    const Double3 start(c.start[0], c.start[1], c.start[2]), d(c.direction[0], c.direction[1], c.direction[2]);
    kernels::traverse(start, d, 0.0, double(c.length), kDims, 0, [&](const Int3& v, double in, double out) {
      auto& sums = light[voxelNumber(v)];
      double w[3];
      for (int i = 0; i < 3; ++i) w[i] = (c.power[i] + c.slope[i] * (0.5 * (in + out) - 0.5 * c.length)) * (out - in);
      for (int i = 0; i < 3; ++i) {
        sums[i] += w[i];
        sums[3 + i] += d[i] * kernels::luminance(Double3(w[0], w[1], w[2]));
      }
      return true;
    });
  }
  return light;
}

/// The same by blocks, as the tracer does it.
Light rasterised(const LaneSet& set, const std::vector<FarChord>& chords) {
  float longest = 0;
  for (const FarChord& c : chords) longest = std::max(longest, c.length);
  std::vector<BlockCrossing> crossings(chords.size() * mostBlocks(longest));
  const auto found = set.findBlocks(chords.data(), std::int64_t(chords.size()), kBlocks, crossings.data());
  EXPECT_LE(found, std::int64_t(crossings.size()));
  crossings.resize(found);
  std::set<std::pair<int, int>> once;
  for (const BlockCrossing& c : crossings) once.insert({c.block, c.chord});
  EXPECT_EQ(once.size(), crossings.size()) << "a block that is found twice gets the chord's light twice";
  Light light(voxelNumber({kDims.x, 0, 0}));
  BlockSums sums;
  for (int b = 0; b < kBlocks.x * kBlocks.y * kBlocks.z; ++b) {
    std::vector<std::uint32_t> ids;
    for (const BlockCrossing& c : crossings)
      if (c.block == b) ids.push_back(static_cast<std::uint32_t>(c.chord));
    if (ids.empty()) continue;
    const Int3 corner{b / (kBlocks.y * kBlocks.z) * 32, b / kBlocks.z % kBlocks.y * 32, b % kBlocks.z * 32};
    sums.clear();
    EXPECT_GT(set.rasterise(chords.data(), ids.data(), std::int64_t(ids.size()), corner, kScale, sums), 0);
    for (int v = 0; v < kBlockVoxels; ++v) {
      const VoxelSums s = sums.at(v);
      if (s == VoxelSums{}) continue;
      const Int3 at{corner.x + (v >> 10), corner.y + (v >> 5 & 31), corner.z + (v & 31)};
      EXPECT_TRUE(at.x < kDims.x && at.y < kDims.y && at.z < kDims.z) << at.x << ' ' << at.y << ' ' << at.z;
      for (int i = 0; i < 6; ++i) light[voxelNumber(at)][i] += double(s[i]) / kScale;
    }
  }
  return light;
}

void expectSameLight(const LaneSet& set, const std::vector<FarChord>& chords, double most) {
  const Light a = rasterised(set, chords), b = walked(chords);
  double all = 0, totals[2] = {0, 0}, off = 0;
  for (std::size_t v = 0; v < a.size(); ++v)
    for (int i = 0; i < 6; ++i) {
      off += std::abs(a[v][i] - b[v][i]);
      all += std::abs(b[v][i]);
      if (i < 3) totals[0] += a[v][i], totals[1] += b[v][i];
    }
  EXPECT_LT(off, most * all);
  EXPECT_NEAR(totals[0], totals[1], 2e-5 * totals[1]);
}

TEST_P(LaneFunctions, FarChordsLightTheVoxelsThatTheyCross) {
  if (!mSet.rasterise) GTEST_SKIP() << "the reference keeps no chords for later";
  Random random(4);
  std::uniform_real_distribution<double> u(0, 1);
  std::vector<FarChord> chords;
  for (int i = 0; i < 3001; ++i) {
    const auto point = [&] { return Double3(u(random) * kDims.x, u(random) * kDims.y, u(random) * kDims.z); };
    const Double3 from = point(), to = point(), way = to - from;
    const double part = std::min(1.0, (3 + 61 * u(random)) / kernels::length(way));
    const float decay = i % 2 ? 0.01f : 0.0f;
    const Float3 power(static_cast<float>(u(random)), 1, 2);
    chords.push_back(chordBetween(from, from + way * part, power, power * -decay));
  }
  expectSameLight(mSet, chords, 5e-4);
}

TEST_P(LaneFunctions, FarChordsAlongAxesAndBlocksFaces) {
  if (!mSet.rasterise) GTEST_SKIP() << "the reference keeps no chords for later";
  for (const double at : {0.0, 31.5, 32.0, 64.0})
    for (int axis = 0; axis < 3; ++axis)
      for (const bool back : {false, true}) {
        SCOPED_TRACE(testing::Message() << "axis " << axis << " at " << at << (back ? " backwards" : ""));
        const auto point = [&](double along) {
          return Double3(axis == 0 ? along : at, axis == 1 ? along : at, axis == 2 ? along : at);
        };
        const Double3 a = point(0), b = point(64);
        expectSameLight(mSet, {chordBetween(back ? b : a, back ? a : b, {1, 2, 3}, {0, 0, 0})}, 1e-4);
      }
  // From corner to corner of blocks, and from block faces.
  expectSameLight(mSet, {chordBetween({0, 0, 0}, {64, 64, 64}, {1, 1, 1}, {0, 0, 0})}, 1e-4);
  expectSameLight(mSet, {chordBetween({64, 64, 96}, {32, 32, 64}, {1, 1, 1}, {0, 0, 0})}, 1e-4);
  expectSameLight(mSet, {chordBetween({32, 10, 64}, {64, 20, 64}, {1, 1, 1}, {0, 0, 0})}, 1e-4);
}

// The sums are 32 bits wide; chords in plenty are carried beyond them in time.
TEST_P(LaneFunctions, FarChordsThroughOneVoxelAddUpBeyond32Bits) {
  if (!mSet.rasterise) GTEST_SKIP() << "the reference keeps no chords for later";
  const FarChord chord = chordBetween({0.5, 0.5, 0}, {0.5, 0.5, 32}, {1.9f, 1, 0}, {0, 0, 0});
  const std::vector<std::uint32_t> ids(40001, 0);
  constexpr float kStrong = 1 << 16;
  BlockSums sums;
  sums.clear();
  EXPECT_EQ(mSet.rasterise(&chord, ids.data(), std::int64_t(ids.size()), {0, 0, 0}, kStrong, sums), 40001 * 32);
  for (const int z : {0, 15, 31}) {
    const VoxelSums s = sums.at(z);
    EXPECT_NEAR(double(s[0]), 40001 * 1.9 * kStrong, 1e-5 * 40001 * kStrong);
    EXPECT_EQ(s[1], std::int64_t{40001} << 16);
    EXPECT_EQ(s[2], 0);
    EXPECT_NEAR(double(s[5]), 40001 * (1.9 * .2126 + .7152) * kStrong, 1e-5 * 40001 * kStrong);
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
