// Straight ways that are kept and rasterised block by block: each block has what one dense rasterisation of the domain
// gives it and the voxels around it.

#include "backends/far_light.h"
#include "kernels/slab.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>

namespace volcaustic::test {
namespace {

using kernels::Double3;
using kernels::Float3;
using kernels::Int3;

/// Each instruction set that keeps chords for later; the reference does not.
class FarLightOnLanes : public testing::TestWithParam<std::string> {
protected:
  const LaneSet& mSet = laneSet(GetParam());
};
INSTANTIATE_TEST_SUITE_P(All, FarLightOnLanes, testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const LaneSet& set : laneSets())
                             if (set.rasterise) names.emplace_back(set.name);
                           return names;
                         }()),
                         [](const auto& set) { return set.param; });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(FarLightOnLanes);

constexpr Int3 kDims{100, 70, 128};
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
using VoxelLight = std::vector<std::array<double, 6>>;
std::size_t voxelNumber(const Int3& v) { return (std::size_t(v.x) * kDims.y + v.y) * kDims.z + v.z; }

/// One dense rasterisation of the whole domain.
VoxelLight dense(const std::vector<FarChord>& chords) {
  VoxelLight light(voxelNumber({kDims.x, 0, 0}));
  for (const FarChord& c : chords) {
    const Double3 start(c.start[0], c.start[1], c.start[2]), d(c.direction[0], c.direction[1], c.direction[2]);
    const auto add = [&](const auto& cell) {
      if (!(cell.length > 0)) return;
      double w[3];
      for (int i = 0; i < 3; ++i) w[i] = (c.power[i] + c.slope[i] * (cell.middle - 0.5 * c.length)) * cell.length;
      for (int i = 0; i < 3; ++i) {
        light[cell.at][i] += w[i];
        light[cell.at][3 + i] += d[i] * kernels::luminance(Double3(w[0], w[1], w[2]));
      }
    };
    const kernels::SlabChord<float, kernels::DenseCells> slabs({kDims}, Float3(start), Float3(d), c.length);
    for (int k = 0; k < slabs.slabs(); ++k) {
      const auto crossing = slabs.crossing(k);
      add(crossing.first), add(crossing.second), add(crossing.third);
    }
  }
  return light;
}

/// Sorts the chords by block, in tasks of unequal length, and holds the sums of every block, and of the voxels around
/// it, against one dense rasterisation. `most`: how far any voxel may be off, W*voxel.
void expectDenseLight(const LaneSet& set, const std::vector<FarChord>& chords, double most) {
  FarLight far(kDims, set);
  const std::span<FarChords> tasks = far.newTasks(5);
  for (std::size_t i = 0; i < chords.size(); ++i) tasks[i * i % 4].append(&chords[i], 1);
  EXPECT_EQ(far.waiting(), chords.size());
  far.sort({});
  EXPECT_EQ(far.waiting(), 0u);
  const VoxelLight light = dense(chords);
  BlockSums sums;
  for (std::int64_t b = 0; b < far.blockCount(); ++b) {
    sums.clear();
    far.addTo(b, kScale, sums);
    const Int3 corner = blockCorner(blockDims(kDims), b);
    for (int v = 0; v < kSumsVoxels; ++v) {
      const Int3 at{corner.x + v / (kSumsEdge * kSumsEdge) - 1, corner.y + v / kSumsEdge % kSumsEdge - 1,
                    corner.z + v % kSumsEdge - 1};
      const VoxelSums s = sums.at(v);
      const auto in = [](int c, int dim) { return c >= 0 && c < dim; };
      const bool inside = in(at.x, kDims.x) && in(at.y, kDims.y) && in(at.z, kDims.z);
      for (int i = 0; i < 6; ++i)
        ASSERT_NEAR(double(s[i]) / kScale, inside ? light[voxelNumber(at)][i] : 0, most)
            << "block " << b << " voxel " << at.x << ' ' << at.y << ' ' << at.z << " sum " << i;
      if (s != VoxelSums{}) {
        ASSERT_TRUE(far.touched(b));
      }
    }
  }
}

std::vector<FarChord> randomChords(int count) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> u(0, 1);
  std::vector<FarChord> chords;
  for (int i = 0; i < count; ++i) {
    const auto point = [&] { return Double3(u(random) * kDims.x, u(random) * kDims.y, u(random) * kDims.z); };
    const Double3 from = point(), to = point(), way = to - from;
    const double part = std::min(1.0, (3 + 61 * u(random)) / kernels::length(way));
    const float decay = i % 2 ? 0.01f : 0.0f;
    const Float3 power(static_cast<float>(u(random)), 1, 2);
    chords.push_back(chordBetween(from, from + way * part, power, power * -decay));
  }
  return chords;
}

// A crossing of a voxel is good to its place, which is good to 1e-5 voxels: 4e-5 W*voxel and the rounding to a unit,
// times the dozen chords of a voxel.
TEST_P(FarLightOnLanes, ChordsLightTheVoxelsThatTheyCross) { expectDenseLight(mSet, randomChords(3001), 2e-3); }

// Along the axes and nearly so: inside voxels, in faces of voxels and blocks, in the last voxel around a block and just
// beyond it, in the domain's faces.
TEST_P(FarLightOnLanes, ChordsAlongAxesAndFaces) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double slant : {0.0, 1e-13, -1e-11}) {
      SCOPED_TRACE(testing::Message() << "axis " << axis << " slant " << slant);
      std::vector<FarChord> chords;
      for (const double at : {0.0, 30.0, 30.9996, 31.0, 31.5, 32.0, 32.5, 33.0, 33.0004, 34.0, 64.0, 65.0, 70.0}) {
        const auto point = [&](double along, double off) {
          return Double3(axis == 0 ? along : at + off, axis == 1 ? along : at + off, axis == 2 ? along : at + off);
        };
        chords.push_back(chordBetween(point(0, 0), point(64, 64 * slant), {1, 2, 3}, {0, 0, 0}));
        chords.push_back(chordBetween(point(64, 0), point(0, 64 * slant), {3, 1, 2}, {0, 0, 0}));
      }
      expectDenseLight(mSet, chords, 1e-3);
    }
  // From corner to corner of blocks, from block faces, and in the domain's high faces.
  expectDenseLight(mSet, {chordBetween({0, 0, 0}, {64, 64, 64}, {1, 1, 1}, {0, 0, 0})}, 1e-3);
  expectDenseLight(mSet, {chordBetween({64, 64, 96}, {32, 32, 64}, {1, 1, 1}, {0, 0, 0})}, 1e-3);
  expectDenseLight(mSet, {chordBetween({32, 10, 64}, {64, 20, 64}, {1, 1, 1}, {0, 0, 0})}, 1e-3);
  expectDenseLight(mSet, {chordBetween({100, 10, 128}, {40, 20, 128}, {1, 1, 1}, {0, 0, 0})}, 1e-3);
}

TEST_P(FarLightOnLanes, ChordsAddUpToTheSameOnAnyNumberOfThreads) {
  const std::vector<FarChord> chords = randomChords(2000);
  std::vector<std::vector<VoxelSums>> sums;
  for (const int threads : {1, 2, 3}) {
    FarLight far(kDims, mSet);
    for (const auto& [first, count] : {std::pair{0, 700}, {700, 1300}}) // sorted once for all
      far.newTasks(1)[0].append(&chords[first], count);
    RunContext ctx;
    ctx.threads = threads;
    far.sort(ctx);
    auto& all = sums.emplace_back();
    BlockSums block;
    for (std::int64_t b = 0; b < far.blockCount(); ++b) {
      block.clear();
      far.addTo(b, kScale, block);
      for (int v = 0; v < kSumsVoxels; ++v) all.push_back(block.at(v));
    }
    EXPECT_TRUE(all == sums.front());
  }
}

// The sums are 32 bits wide; chords in plenty are carried beyond them in time.
TEST_P(FarLightOnLanes, ChordsThroughOneVoxelAddUpBeyond32Bits) {
  const FarChord chord = chordBetween({0.5, 0.5, 0}, {0.5, 0.5, 32}, {1.9f, 1, 0}, {0, 0, 0});
  const std::vector<std::uint32_t> ids(40001, 0);
  constexpr float kStrong = 1 << 16;
  BlockSums sums;
  sums.clear();
  mSet.rasterise(&chord, ids.data(), std::int64_t(ids.size()), {0, 0, 0}, kStrong, sums);
  for (const int z : {0, 15, 31}) {
    const VoxelSums s = sums.at(sumsOffset(0, 0, z));
    EXPECT_NEAR(double(s[0]), 40001 * 1.9 * kStrong, 1e-5 * 40001 * kStrong);
    EXPECT_EQ(s[1], std::int64_t{40001} << 16);
    EXPECT_EQ(s[2], 0);
    EXPECT_NEAR(double(s[5]), 40001 * (1.9 * .2126 + .7152) * kStrong, 1e-5 * 40001 * kStrong);
  }
  EXPECT_EQ(sums.at(sumsOffset(0, 0, 32)), VoxelSums{});
}

} // namespace
} // namespace volcaustic::test
