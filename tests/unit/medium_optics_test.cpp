// Blending of bodies and the Gaussian on the index, on brick grids.
#include "unit/voxelise_support.h"
#include "volume/optics.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {
namespace {

Material glass(double index) {
  Material m;
  m.index = index;
  return m;
}

OpticsBricks painted(std::vector<Body> bodies, const Domain& domain, const Ambient& ambient = {}) {
  OpticsBricks optics = ambientOptics(domain, ambient, bodies);
  for (const Body& b : bodies) paintBody(optics, voxeliseBody(b, domain, 4, FillRule::Auto), b.material);
  collapseUniform(optics);
  return optics;
}

Body body(Mesh mesh, const Material& material) {
  Body b = bodyOf(std::move(mesh));
  b.material = material;
  return b;
}

TEST(Optics, ALaterBodyReplacesAnEarlierOneByItsCoverage) {
  const Domain domain = cubeDomain(16);
  const OpticsBricks o = painted(
      {body(box({2, 2, 2}, {14, 14, 14}), glass(1.5)), body(box({4, 4, 4}, {12, 12, 8.5}), glass(1.33))}, domain);
  EXPECT_EQ(o.index.at(3, 3, 3), 1.5f);
  EXPECT_EQ(o.index.at(8, 8, 6), 1.33f); // exactly: no trace of the glass or of the air under the liquid
  EXPECT_FLOAT_EQ(o.index.at(8, 8, 8), 0.5f * 1.5f + 0.5f * 1.33f);
  EXPECT_EQ(o.index.at(0, 0, 0), 1.0f);
  EXPECT_EQ(o.coverage.at(8, 8, 8), 1.0f);
}

TEST(Optics, CoverageOfSeveralBodiesIsWhatTheyDoNotLeaveFree) {
  const Domain domain = cubeDomain(8);
  const OpticsBricks o =
      painted({body(box({1, 1, 1}, {7, 7, 4.5}), glass(1.2)), body(box({1, 1, 4.25}, {7, 7, 7}), glass(1.4))}, domain);
  EXPECT_FLOAT_EQ(o.coverage.at(4, 4, 4), 1 - 0.5f * 0.25f);
  EXPECT_EQ(o.coverage.at(4, 4, 3), 1.0f);
}

TEST(Optics, GridsThatNoBodyChangesAreAbsent) {
  const Domain domain = cubeDomain(16);
  Ambient fog;
  fog.attenuation = {0.1, 0.2, 0.3};
  fog.scattering = {0.1, 0.1, 0.1};
  Material m = glass(1.5);
  m.attenuation = fog.attenuation;
  m.scattering = fog.scattering;
  OpticsBricks same = painted({body(box({2, 2, 2}, {9, 9, 9}), m)}, domain, fog);
  EXPECT_FALSE(same.attenuation || same.scattering || same.asymmetry);
  m.attenuation = {1, 2, 3};
  m.asymmetry = 0.5;
  const OpticsBricks dye = painted({body(box({2, 2, 2}, {9, 9, 9}), m)}, domain, fog);
  ASSERT_TRUE(dye.attenuation && dye.asymmetry);
  EXPECT_FALSE(dye.scattering);
  EXPECT_EQ(dye.attenuation->at(4, 4, 4), (Vec3f{1, 2, 3}));
  EXPECT_EQ(dye.attenuation->at(12, 4, 4), (Vec3f{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(dye.asymmetry->at(4, 4, 4), 0.5f);
}

TEST(Optics, ABodyLikeItsSurroundingsLeavesNoTrace) {
  const Domain domain = cubeDomain(32);
  const OpticsBricks o = painted({body(icosphere({16, 16, 16}, 11, 3), glass(1.0))}, domain);
  EXPECT_EQ(o.index.activeBrickCount(), 0);
  EXPECT_GT(o.coverage.activeBrickCount(), 0);
}

/// The straightforward Gaussian, in double, on all voxels at once.
std::vector<double> denseBlur(const BrickGrid<float>& grid, int width) {
  const Vec3i n = grid.dims();
  std::vector<double> w;
  double sum = 0;
  for (int t = -width / 2; t <= width / 2; ++t) sum += w.emplace_back(std::exp(-0.5 * t * t * 36.0 / (width * width)));
  std::vector<double> from;
  for (int x = 0; x < n[0]; ++x)
    for (int y = 0; y < n[1]; ++y)
      for (int z = 0; z < n[2]; ++z) from.push_back(grid.at(x, y, z));
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> to(from.size(), 0);
    std::size_t i = 0;
    for (int x = 0; x < n[0]; ++x)
      for (int y = 0; y < n[1]; ++y)
        for (int z = 0; z < n[2]; ++z, ++i)
          for (int t = 0; t < width; ++t) {
            Vec3i c{x, y, z};
            c[axis] = std::clamp(c[axis] + t - width / 2, 0, n[axis] - 1);
            to[i] += w[t] / sum * from[(std::size_t(c[0]) * n[1] + c[1]) * n[2] + c[2]];
          }
    from = std::move(to);
  }
  return from;
}

TEST(GaussianBlur, AgreesWithTheDenseOneEverywhere) {
  const Domain domain{{0, 0, 0}, 1, {64, 61, 58}}; // not whole bricks; the body leaves through a face
  const OpticsBricks o =
      painted({body(rotated(translated(torus(18, 6, 60, 30), {31, 34, 3}), 0.1, 0.2), glass(1.5))}, domain);
  for (const int width : {3, 5, 7, 9, 11}) {
    const BrickGrid<float> blurred = gaussianBlur(o.index, width);
    const std::vector<double> expected = denseBlur(o.index, width);
    std::size_t i = 0;
    double worst = 0;
    for (int x = 0; x < 64; ++x)
      for (int y = 0; y < 61; ++y)
        for (int z = 0; z < 58; ++z) worst = std::max(worst, std::abs(blurred.at(x, y, z) - expected[i++]));
    EXPECT_LT(worst, 1e-6) << width;
  }
}

TEST(GaussianBlur, ABodyGoesOnWhereOnlyTheDomainEndsInsideABrick) {
  for (const int edge : {20, 21, 23}) {
    const OpticsBricks o = painted({body(box({2, 2, 2}, {23.5, 23.5, 23.5}), glass(1.5))}, cubeDomain(edge));
    const BrickGrid<float> blurred = gaussianBlur(o.index, 9);
    for (int x = 7; x < edge; ++x) // out of reach of the near faces
      for (int y = 7; y < edge; ++y)
        for (int z = 7; z < edge; ++z)
          ASSERT_EQ(blurred.at(x, y, z), 1.5f) << edge << ": " << x << ' ' << y << ' ' << z;
  }
}

TEST(GaussianBlur, KeepsTheSumAndTheBitsOfConstants) {
  const Domain domain = cubeDomain(96);
  const float ambient = 1.000293f, inside = 1.4585f; // air and quartz: neither is a short binary fraction
  Ambient air;
  air.index = ambient;
  const OpticsBricks o = painted({body(icosphere({48, 48, 48}, 28, 4), glass(inside))}, domain, air);
  const BrickGrid<float> blurred = gaussianBlur(o.index, 9);
  double before = 0, after = 0;
  for (int x = 0; x < 96; ++x)
    for (int y = 0; y < 96; ++y)
      for (int z = 0; z < 96; ++z) {
        before += double(o.index.at(x, y, z)) - ambient;
        after += double(blurred.at(x, y, z)) - ambient;
        const double r = std::hypot(x - 47.5, y - 47.5, z - 47.5);
        if (r > 28 + 8 || r < 28 - 9) {
          ASSERT_EQ(blurred.at(x, y, z), r > 28 ? ambient : inside);
        }
      }
  EXPECT_NEAR(after / before, 1, 1e-6);
  // Only bricks within reach of the surface have voxels of their own.
  for (std::int64_t b = 0; b < blurred.brickCount(); ++b)
    if (!blurred.isConstant(b)) {
      const auto voxels = blurred.voxels(b);
      EXPECT_TRUE(std::any_of(voxels.begin(), voxels.end(), [&](float v) { return v != voxels[0]; }));
      const Vec3i c = blurred.brickCoord(b);
      EXPECT_NEAR(std::hypot(c[0] * 8 - 44, c[1] * 8 - 44, c[2] * 8 - 44), 28, 8 + 7.0);
    }
}

TEST(GaussianBlur, WidthOneChangesNothing) {
  const OpticsBricks o = painted({body(box({2, 2, 2}, {9, 9, 9}), glass(1.5))}, cubeDomain(16));
  EXPECT_EQ(gaussianBlur(o.index, 1).at(8, 8, 8), o.index.at(8, 8, 8));
  EXPECT_NE(gaussianBlur(o.index, 3).at(8, 8, 8), o.index.at(8, 8, 8));
}

} // namespace
} // namespace volcaustic::test
