// Chords cut into slabs against a walk from face to face in double precision.

#include "kernels/slab.h"
#include "support/traverse.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <tuple>
#include <vector>

namespace volcaustic::test {
namespace {

using kernels::BrickCells;
using kernels::DenseCells;
using kernels::Double3;
using kernels::Float3;
using kernels::Int3;
using kernels::SlabChord;

constexpr Int3 kDims{37, 50, 61}, kBrickDims{5, 7, 8};

using Voxel = std::tuple<int, int, int>;
using Lengths = std::map<Voxel, double>;

struct Chord {
  Float3 start, direction;
  float length;
};
std::ostream& operator<<(std::ostream& out, const Chord& c) {
  return out << std::hexfloat << "from " << c.start.x << ' ' << c.start.y << ' ' << c.start.z << " along "
             << c.direction.x << ' ' << c.direction.y << ' ' << c.direction.z << " for " << c.length;
}

Chord chordBetween(const Double3& from, const Double3& to) {
  const Double3 way = to - from;
  return {Float3(from), Float3(way * (1 / kernels::length(way))), static_cast<float>(kernels::length(way))};
}

Lengths walked(const Chord& c) {
  Lengths lengths;
  traverse(Double3(c.start), Double3(c.direction), 0.0, static_cast<double>(c.length), kDims, 0,
           [&](const Int3& v, double in, double out) {
             lengths[{v.x, v.y, v.z}] += out - in;
             return true;
           });
  return lengths;
}

BrickCells cellsOf(BrickCells*) { return {kDims, kBrickDims}; }
DenseCells cellsOf(DenseCells*) { return {kDims}; }
Voxel voxelOf(const BrickCells::Address<float>& a) {
  EXPECT_TRUE(a.brick >= 0 && a.brick < kBrickDims.x * kBrickDims.y * kBrickDims.z && a.offset >= 0 && a.offset < 512);
  return {a.brick / (kBrickDims.y * kBrickDims.z) * 8 + (a.offset >> 6),
          a.brick / kBrickDims.z % kBrickDims.y * 8 + (a.offset >> 3 & 7), a.brick % kBrickDims.z * 8 + (a.offset & 7)};
}
Voxel voxelOf(std::int32_t a) {
  EXPECT_TRUE(a >= 0 && a < kDims.x * kDims.y * kDims.z);
  return {a / (kDims.y * kDims.z), a / kDims.z % kDims.y, a % kDims.z};
}

/// Lengths by voxel, after a look at what holds of every chord.
template <class Cells>
Lengths cut(const Chord& c) {
  Lengths lengths;
  double sum = 0, moment = 0;
  const SlabChord<float, Cells> slabs(cellsOf(static_cast<Cells*>(nullptr)), c.start, c.direction, c.length);
  EXPECT_GE(slabs.slabs(), 1);
  for (int k = 0; k < slabs.slabs(); ++k) {
    const auto crossing = slabs.crossing(k);
    for (const auto& cell : {crossing.first, crossing.second, crossing.third}) {
      const Voxel v = voxelOf(cell.at);
      const auto [x, y, z] = v;
      EXPECT_TRUE(x < kDims.x && y < kDims.y && z < kDims.z) << c;
      EXPECT_GE(cell.length, 0) << c;
      if (!(cell.length > 0)) continue;
      EXPECT_TRUE(cell.middle >= 0 && cell.middle <= c.length) << c;
      lengths[v] += cell.length;
      sum += cell.length;
      moment += double{cell.length} * cell.middle;
    }
  }
  EXPECT_NEAR(sum, c.length, 1e-4) << c;
  EXPECT_NEAR(moment, 0.5 * c.length * c.length, 1e-4 * c.length) << c;
  return lengths;
}

double difference(const Lengths& a, const Lengths& b) {
  double sum = 0;
  for (const auto& [v, length] : a) sum += std::abs(length - (b.contains(v) ? b.at(v) : 0));
  for (const auto& [v, length] : b)
    if (!a.contains(v)) sum += length;
  return sum;
}

/// What single precision may do: it moves the faces by some hundred-thousandths of a voxel, and along a chord by as
/// much over the cosine.
double allowed(const Chord& c) {
  double inverse = 1;
  for (const float d : {c.direction.x, c.direction.y, c.direction.z})
    if (d != 0) inverse = std::max(inverse, 1 / std::abs(double{d}));
  return 1e-3 + 3e-5 * inverse;
}

Double3 randomPoint(std::mt19937_64& random) {
  std::uniform_real_distribution<double> u(0, 1);
  return {u(random) * kDims.x, u(random) * kDims.y, u(random) * kDims.z};
}

template <class Cells>
class Slabs : public testing::Test {};
using CellKinds = testing::Types<BrickCells, DenseCells>;
TYPED_TEST_SUITE(Slabs, CellKinds);

TYPED_TEST(Slabs, AgreeWithTheWalkOnRandomChords) {
  std::mt19937_64 random(20240607);
  std::uniform_real_distribution<double> logarithm(std::log(1e-4), std::log(64.0));
  int off = 0;
  for (int i = 0; i < 20000; ++i) {
    const Double3 from = randomPoint(random), to = randomPoint(random);
    const double whole = kernels::length(to - from), part = std::min(1.0, std::exp(logarithm(random)) / whole);
    const Chord c = chordBetween(from, from + (to - from) * part);
    const double d = difference(cut<TypeParam>(c), walked(c));
    ASSERT_LE(d, allowed(c)) << c;
    off += d > 1e-3;
  }
  EXPECT_LT(off, 200) << "chords nearly along a face";
}

// Points on faces, edges and corners of voxels, joined by straight lines: exact diagonals, axis-parallel chords, chords
// that end where they meet a corner.
TYPED_TEST(Slabs, AgreeWithTheWalkBetweenFacesEdgesAndCorners) {
  std::mt19937_64 random(7);
  std::uniform_int_distribution<int> step(-16, 16), quarter(0, 3);
  for (int i = 0; i < 20000; ++i) {
    const Double3 p = randomPoint(random);
    const double grid = quarter(random) == 0 ? 0.5 : 1.0;
    const auto round = [&](double a) { return std::floor(a / grid) * grid; };
    const Double3 from{round(p.x), quarter(random) ? round(p.y) : p.y, quarter(random) ? round(p.z) : p.z};
    Double3 way(grid * step(random), grid * step(random), grid * step(random));
    if (quarter(random) == 0) way.x = 0;
    if (quarter(random) == 0) way.z = way.y;
    const Double3 to{kernels::clampTo(from.x + way.x, 0.0, double{kDims.x}),
                     kernels::clampTo(from.y + way.y, 0.0, double{kDims.y}),
                     kernels::clampTo(from.z + way.z, 0.0, double{kDims.z})};
    if (kernels::length(to - from) == 0) continue;
    const Chord c = chordBetween(from, to);
    ASSERT_LE(difference(cut<TypeParam>(c), walked(c)), allowed(c)) << c;
  }
}

TYPED_TEST(Slabs, AgreeWithTheWalkAlongTheAxes) {
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {-1.0f, 1.0f})
      for (const float across : {0.0f, 0.25f, 1.0f, 8.0f, 36.5f, 37.0f})
        for (const float begin : {0.0f, 0.5f, 8.0f, 17.3f})
          for (const float length : {1e-6f, 0.25f, 1.0f, 7.0f, 19.5f}) {
            float at[3] = {across, across, across}, towards[3] = {0, 0, 0};
            at[axis] = sign > 0 ? begin : begin + length;
            towards[axis] = sign;
            const Chord c{{at[0], at[1], at[2]}, {towards[0], towards[1], towards[2]}, length};
            ASSERT_LE(difference(cut<TypeParam>(c), walked(c)), 1e-4) << c;
          }
}

TYPED_TEST(Slabs, KeepTheLengthOfChordsThatGlideAlongFaces) {
  std::mt19937_64 random(3);
  std::uniform_int_distribution<int> exponent(-12, -3), whole(0, 36);
  std::uniform_real_distribution<double> u(-1, 1), length(1, 36);
  for (int i = 0; i < 20000; ++i) {
    // Which side of the face such a chord is on is up to rounding; that it stays beside it is not.
    const double slope = u(random) * std::pow(10.0, exponent(random));
    const int face = whole(random);
    const Double3 from(face, face, 0.3), towards = kernels::normalize(Double3(slope, u(random) < 0 ? slope : 0.0, 1));
    const Chord c{Float3(from), Float3(towards), static_cast<float>(length(random))};
    for (const auto& [v, inVoxel] : cut<TypeParam>(c)) {
      const double drift = std::abs(slope) * c.length + 1e-3;
      EXPECT_GE(std::get<0>(v) + 1 + drift, face) << c;
      EXPECT_LE(std::get<0>(v) - drift, face) << c;
      EXPECT_LE(inVoxel, 1 + 1e-3 + drift) << c;
    }
  }
}

TYPED_TEST(Slabs, CountToTheOutermostVoxelsWhatLiesOnTheBoxsFacesAndBeyond) {
  const Float3 along = kernels::normalize(Float3(0, 0.6f, 0.8f));
  for (const float x : {37.0f, 37.0005f, 0.0f, -0.0005f})
    for (const auto& [voxel, length] : cut<TypeParam>({{x, 2.5f, 3.5f}, along, 40}))
      EXPECT_EQ(std::get<0>(voxel), x > 1 ? 36 : 0);
  for (const auto& [voxel, length] : cut<TypeParam>({{37.0f, 50.0f, 61.0f}, {0, 0, -1}, 60.5f})) {
    EXPECT_EQ(std::get<0>(voxel), 36);
    EXPECT_EQ(std::get<1>(voxel), 49);
  }
}

TYPED_TEST(Slabs, TakeChordsOfAlmostNoLength) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const float length : {1e-3f, 1e-6f, 1e-20f, 1e-38f, 0.0f})
    for (int i = 0; i < 1000; ++i) {
      const Float3 direction(kernels::normalize(Double3(u(random), u(random), u(random))));
      const Float3 p(randomPoint(random));
      (void)cut<TypeParam>({i % 2 ? p : Float3(std::floor(p.x), std::floor(p.y), std::floor(p.z)), direction, length});
    }
}

} // namespace
} // namespace volcaustic::test
