// What the kernels are given, against what it has to be: labels by brute force, fields in closed form, optics voxel by
// voxel, and memory that goes by what is active.
#include "support/fields.h"
#include "support/resident_memory.h"
#include "support/solids.h"
#include "volcaustic/error.h"
#include "volcaustic/openvdb.h"
#include "volume/flatten.h"
#include "volume/grids.h"

#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {
namespace {

using kernels::Float3;
using kernels::Int3;

template <class Visit>
void forEachVoxel(const Vec3i& dims, Visit&& visit) {
  for (int x = 0; x < dims[0]; ++x)
    for (int y = 0; y < dims[1]; ++y)
      for (int z = 0; z < dims[2]; ++z) visit(x, y, z);
}

/// Patches of n and attenuation over a flat background, with steps about as large as the tolerances.
Medium randomMedium(const Vec3i& dims, unsigned seed) {
  std::mt19937 random(seed);
  const auto pick = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  BrickGrid<float> index(dims, 1.f);
  BrickGrid<Vec3f> attenuation(dims, {.1f, .1f, .1f});
  for (int patch = 0; patch < 6; ++patch) {
    Vec3i low, high;
    for (int a = 0; a < 3; ++a) {
      low[a] = pick(dims[a]);
      high[a] = std::min(low[a] + 1 + pick(20), dims[a]);
    }
    const float n = 1 + .004f * static_cast<float>(pick(8)), sigma = .1f + .006f * static_cast<float>(pick(4));
    for (int x = low[0]; x < high[0]; ++x)
      for (int y = low[1]; y < high[1]; ++y)
        for (int z = low[2]; z < high[2]; ++z) {
          const std::int64_t b = index.brickIndex({x / 8, y / 8, z / 8});
          index.allocate(b)[brickOffset(x, y, z)] = n;
          if (patch % 2) attenuation.allocate(b)[brickOffset(x, y, z)] = {.1f, sigma, .1f};
        }
  }
  const Domain domain{{0, 0, 0}, 1, dims};
  MediumGrids grids;
  grids.index = toFloatGrid(index, domain, "index");
  grids.attenuation = toVec3Grid(attenuation, domain, "attenuation");
  Ambient ambient;
  ambient.attenuation = {.1, .1, .1};
  return mediumFromGrids(domain, ambient, grids);
}

/// The label of one cube, or -1, by looking at all its voxels and one around them.
int labelOfCube(const BrickGrid<float>& index, const BrickGrid<Vec3f>& attenuation, const Vec3i& origin, int level,
                const StepFieldOptions& o) {
  float least = 1e9f, most = -1e9f;
  Vec3f leastA{1e9f, 1e9f, 1e9f}, mostA{-1e9f, -1e9f, -1e9f};
  const auto from = [&](int a) { return std::max(origin[a] - 1, 0); };
  const auto to = [&](int a) { return std::min(origin[a] + (1 << level), index.dims()[a] - 1); };
  for (int x = from(0); x <= to(0); ++x)
    for (int y = from(1); y <= to(1); ++y)
      for (int z = from(2); z <= to(2); ++z) {
        least = std::min(least, index.at(x, y, z));
        most = std::max(most, index.at(x, y, z));
        for (int c = 0; c < 3; ++c) {
          leastA[c] = std::min(leastA[c], attenuation.at(x, y, z)[c]);
          mostA[c] = std::max(mostA[c], attenuation.at(x, y, z)[c]);
        }
      }
  for (int c = 0; c < 3; ++c)
    if (mostA[c] - leastA[c] > o.attenuationTolerance) return -1;
  if (most - least < o.indexTolerance) return level;
  return most - least < o.indexTolerance2 ? level + kStepCapped : -1;
}

TEST(StepLabels, AreTheLargestCubesThatHardlyChange) {
  const StepFieldOptions options;
  for (const Vec3i& dims : {Vec3i{37, 21, 50}, Vec3i{64, 64, 64}, Vec3i{8, 70, 9}, Vec3i{5, 3, 4}})
    for (unsigned seed = 0; seed < 6; ++seed) {
      const Medium medium = randomMedium(dims, seed);
      const BrickGrid<float> index = fromFloatGrid(*medium.grids().index, dims);
      const BrickGrid<Vec3f> attenuation = fromVec3Grid(*medium.grids().attenuation, dims);
      int top = kBrickLog2;
      while (1 << top < *std::ranges::max_element(dims)) ++top;
      BrickGrid<float> expected(dims, -1.f); // labels, the coarsest first
      std::vector<std::int64_t> all(static_cast<std::size_t>(expected.brickCount()));
      for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int64_t>(i);
      expected.activate(all);
      const auto label = [&](int x, int y, int z) -> float& {
        return expected.voxels(expected.brickIndex({x / 8, y / 8, z / 8}))[brickOffset(x, y, z)];
      };
      for (int level = top; level >= 1; --level)
        forEachVoxel(dims, [&](int x, int y, int z) {
          if (((x | y | z) & ((1 << level) - 1)) != 0 || label(x, y, z) >= 0) return;
          const int found = labelOfCube(index, attenuation, {x, y, z}, level, options);
          if (found < 0) return;
          for (int i = x; i < std::min(x + (1 << level), dims[0]); ++i)
            for (int j = y; j < std::min(y + (1 << level), dims[1]); ++j)
              for (int k = z; k < std::min(z + (1 << level), dims[2]); ++k) label(i, j, k) = static_cast<float>(found);
        });
      const auto grid = stepFieldGrid(medium, options);
      const FlatMediumStorage flat = flattenMedium(medium, options, {});
      const kernels::FlatMedium m = flat.view();
      forEachVoxel(dims, [&](int x, int y, int z) {
        const int want = std::max(static_cast<int>(label(x, y, z)), 0);
        ASSERT_EQ(grid->tree().getValue({x, y, z}), want) << x << ' ' << y << ' ' << z << " seed " << seed;
        const int byte = m.stepAt(Int3(x, y, z));
        ASSERT_EQ((byte & kernels::kStepLevelMask) + (byte & kernels::kStepCappedBit ? kStepCapped : 0), want);
      });
    }
}

TEST(StepLabels, HaveTheirTree) {
  // Flat halves of a box: one tile for each cube, no leaf that is one value.
  const Medium medium = sampleMedium(unitCube(256), {}, [](const Vec3d& p) { return p[0] < .5 ? 1.0 : 1.4; });
  const auto grid = stepFieldGrid(medium);
  for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
    std::int32_t value;
    bool state;
    EXPECT_FALSE(leaf->isConstant(value, state, 0));
  }
  EXPECT_EQ(grid->tree().getValue({10, 10, 10}), 6);
  EXPECT_EQ(grid->activeVoxelCount(), 256u * 256 * 256);
  StepFieldOptions wrong;
  wrong.indexTolerance = .1;
  EXPECT_THROW(stepFieldGrid(medium, wrong), Error);
  EXPECT_THROW(flattenMedium(medium, wrong, {}), Error);
}

TEST(FlatMedium, LinearAndQuadraticFieldsComeOutExact) {
  for (const int resolution : {64, 43}) {
    const double h = 1.0 / resolution;
    const FlatMediumStorage linear = flattenMedium(
        sampleMedium(unitCube(resolution), {}, [](const Vec3d& p) { return 1 + .5 * p[0] - .2 * p[1] + .1 * p[2]; }),
        {}, {});
    const FlatMediumStorage square =
        flattenMedium(sampleMedium(unitCube(resolution), {}, [](const Vec3d& p) { return 1 + p[1] * p[1]; }), {}, {});
    const kernels::FlatMedium m = linear.view(), q = square.view();
    forEachVoxel({resolution, resolution, resolution}, [&](int x, int y, int z) {
      const Float3 p(float(x) + .5f, float(y) + .5f, float(z) + .5f);
      const auto f = kernels::nearestField(m, p);
      ASSERT_NEAR(f.n, 1 + h * (.5 * p.x - .2 * p.y + .1 * p.z), 1e-6);
      ASSERT_NEAR(f.gradient.x, .5 * h, 2e-6); // up to the faces
      ASSERT_NEAR(f.gradient.y, -.2 * h, 2e-6);
      ASSERT_NEAR(f.gradient.z, .1 * h, 2e-6);
      if (y < 3 || y >= resolution - 4) return; // beyond the faces n goes on straight
      const auto g = kernels::nearestField(q, p);
      ASSERT_NEAR(g.n, 1 + h * h * (p.y * p.y - 1 / 6.), 1e-6); // less a twelfth of the second difference
      ASSERT_NEAR(g.gradient.y, 2 * h * h * p.y, 3e-6);
      ASSERT_EQ(g.gradient.x, 0);
    });
  }
}

Body bodyOf(std::shared_ptr<const Mesh> mesh, double index, const Rgb& attenuation, const Rgb& scattering) {
  Body body;
  body.mesh = std::move(mesh);
  body.material.index = index;
  body.material.attenuation = attenuation;
  body.material.scattering = scattering;
  return body;
}

/// Bodies in fog, one of which differs from it in its optics alone.
Medium ballsInFog(const Domain& domain, const RunContext& ctx = {}) {
  std::vector<Body> bodies{bodyOf(ball({.5, .4, .5}, .3), 1.5, {2, 3, 4}, {1, 1, 2}),
                           bodyOf(ball({.8, .3, .9}, .2), 1.0, {1, 5, 4}, {1, .5, 2})};
  bodies[0].material.asymmetry = .4;
  bodies[1].priority = 1;
  Ambient fog;
  fog.attenuation = {.5, .4, .3};
  fog.scattering = {.1, .1, .2};
  fog.asymmetry = .1;
  return buildMedium(bodies, fog, domain, {}, ctx);
}

const Domain kOddDomain{{0, 0, 0}, 1.0 / 61, {61, 45, 70}};

TEST(FlatMedium, EveryVoxelHasItsOptics) {
  const Medium medium = ballsInFog(kOddDomain);
  const FlatMediumStorage flat = flattenMedium(medium, {}, {});
  const kernels::FlatMedium m = flat.view();
  const MediumGrids& g = medium.grids();
  const auto h = static_cast<float>(kOddDomain.voxelSize);
  forEachVoxel(kOddDomain.dims, [&](int x, int y, int z) {
    const openvdb::Coord at(x, y, z);
    const kernels::Optics& o = m.opticsAt({x, y, z});
    const openvdb::Vec3s a = g.attenuation->tree().getValue(at), s = g.scattering->tree().getValue(at);
    ASSERT_EQ(openvdb::Vec3s(o.attenuation.x, o.attenuation.y, o.attenuation.z), a * h) << at;
    ASSERT_EQ(openvdb::Vec3s(o.scattering.x, o.scattering.y, o.scattering.z), s * h) << at;
    ASSERT_EQ(o.asymmetry, g.asymmetry->tree().getValue(at)) << at;
  });
  EXPECT_TRUE(flat.attenuates);
  for (std::size_t i = 0; i < flat.optics.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      ASSERT_NE(std::memcmp(&flat.optics[i], &flat.optics[j], sizeof(kernels::Optics)), 0) << "the same twice";
}

TEST(FlatMedium, BendsWhereALookupSeesAGradientOrOtherOptics) {
  const Medium medium = ballsInFog(kOddDomain);
  const FlatMediumStorage flat = flattenMedium(medium, {}, {});
  const kernels::FlatMedium m = flat.view();
  const Vec3i& d = kOddDomain.dims;
  int bending = 0, straight = 0;
  forEachVoxel(d, [&](int x, int y, int z) {
    const bool bends = m.stepAt(Int3(x, y, z)) & kernels::kStepBendsBit;
    (bends ? bending : straight)++;
    if (bends) {
      ASSERT_TRUE(m.bends[m.brickIndex(Int3(x, y, z))]);
      return;
    }
    ASSERT_EQ(m.opticsIndex(Int3(x, y, z)), 0);
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, d[0] - 1); ++i)
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, d[1] - 1); ++j)
        for (int k = std::max(z - 1, 0); k <= std::min(z + 1, d[2] - 1); ++k) {
          const Float3 g = kernels::nearestField(m, Float3(float(i) + .5f, float(j) + .5f, float(k) + .5f)).gradient;
          // The outermost weight, 1/144 of a step of 0.5, may go unseen.
          ASSERT_LT(std::max({std::abs(g.x), std::abs(g.y), std::abs(g.z)}), .5f / 144 + 1e-5f);
        }
  });
  EXPECT_GT(bending, 10000);
  EXPECT_GT(straight, 10000);
}

TEST(FlatMedium, ForeignBackgroundsAreNotTheAmbientMedium) {
  const Medium made = ballsInFog(kOddDomain);
  MediumGrids grids;
  grids.index = made.grids().index;
  grids.attenuation = made.grids().attenuation;
  Ambient water;
  water.index = 1.25;
  water.attenuation = {.125, .25, .5};
  const FlatMediumStorage flat = flattenMedium(mediumFromGrids(kOddDomain, water, grids), {}, {});
  const kernels::FlatMedium m = flat.view();
  const auto h = static_cast<float>(kOddDomain.voxelSize);
  EXPECT_EQ(m.ambientIndex, 1.25f);
  EXPECT_EQ(m.optics[0].attenuation.x, .125f * h);
  EXPECT_EQ(kernels::nearestField(m, Float3(1.5f, 1.5f, 1.5f)).n, 1.f); // the grid's background
  EXPECT_EQ(m.opticsAt({1, 1, 1}).attenuation.x, .5f * h);
  EXPECT_TRUE(m.stepAt(Int3(1, 1, 1)) & kernels::kStepBendsBit);
}

template <class Table>
bool sameBytes(const Table& a, const Table& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(*a.data())) == 0;
}

TEST(FlatMedium, DoesNotDependOnTheNumberOfThreads) {
  RunContext one, three;
  one.threads = 1;
  three.threads = 3;
  const Domain domain{{0, 0, 0}, 1.0 / 128, {128, 100, 120}};
  const FlatMediumStorage a = flattenMedium(ballsInFog(domain, one), {}, one);
  const FlatMediumStorage b = flattenMedium(ballsInFog(domain, three), {}, three);
  EXPECT_TRUE(sameBytes(a.fieldSlots, b.fieldSlots));
  EXPECT_TRUE(sameBytes(a.stepSlots, b.stepSlots));
  EXPECT_TRUE(sameBytes(a.opticsSlots, b.opticsSlots));
  EXPECT_TRUE(sameBytes(a.indexOffsets, b.indexOffsets));
  EXPECT_TRUE(sameBytes(a.bends, b.bends));
  EXPECT_TRUE(sameBytes(a.fields, b.fields));
  EXPECT_TRUE(sameBytes(a.steps, b.steps));
  EXPECT_TRUE(sameBytes(a.voxelOptics, b.voxelOptics));
  EXPECT_TRUE(sameBytes(a.optics, b.optics));
}

TEST(FlatMedium, ASmallBallInAHugeBoxCostsWhatTheBallCosts) {
  VOLCAUSTIC_NEED_TRUE_MEMORY;
  // 60 voxels of 2048 along each axis, 16.8 million bricks: a table of 8 bytes a brick alone would be over the limit.
  const Body body = bodyOf(ball({.5, .5, .5}, 30.0 / 2048), 1.5, {1, 2, 3}, {.5, .5, .5});
  const std::int64_t before = peakResidentBytes();
  const Medium medium = buildMedium(std::span(&body, 1), {}, unitCube(2048));
  const FlatMediumStorage flat = flattenMedium(medium, {}, {});
  EXPECT_LT(peakResidentBytes() - before, 100 << 20);
  const kernels::FlatMedium m = flat.view();
  EXPECT_EQ(m.stepAt(Int3(3, 3, 3)) & kernels::kStepLevelMask, 9); // the ball stands on the corner of eight cubes
  EXPECT_EQ(kernels::nearestField(m, Float3(1024, 1024, 1024)).n, 1.5f);
  EXPECT_EQ(m.opticsIndex(Int3(3, 3, 3)), 0);
}

} // namespace
} // namespace volcaustic::test
