// What moves surfaces: noise and waves.

#include "shape_support.h"
#include "shapes/noise.h"
#include "shapes/waves.h"

#include <gtest/gtest.h>
#include <numbers>

namespace volcaustic::test {
namespace {

shapes::NoiseDisplacement noise(int octaves = 1, int seed = 0) {
  shapes::NoiseDisplacement n;
  n.amplitude = .3;
  n.size = .5;
  n.octaves = octaves;
  n.gain = .6;
  n.seed = seed;
  return n;
}

void expectBound(const ShapeFunction& f, Random& random, const Box& box) {
  const Interval bound = f.bound(box);
  for (const double value : valuesOf(f, random.points(box, 300))) {
    ASSERT_LE(bound.low, value);
    ASSERT_GE(bound.high, value);
  }
}

} // namespace

TEST(ShapeNoise, StaysWithinItsAmplitudeAndUsesMuchOfIt) {
  Random random(1);
  for (const int octaves : {1, 4, 12}) {
    Interval seen;
    double sum = 0;
    const std::vector<double> values = valuesOf(*makeNoise(noise(octaves)), random.points(cube(20), 40000));
    for (const double v : values) {
      seen = united(seen, {v, v});
      sum += v;
    }
    EXPECT_LE(magnitude(seen), .3);
    EXPECT_LT(seen.low, -.1);
    EXPECT_GT(seen.high, .1);
    EXPECT_NEAR(sum / 40000, 0, .003);
  }
}

TEST(ShapeNoise, GradientsAreDifferences) {
  Random random(2);
  for (const int octaves : {1, 5}) {
    const auto f = makeNoise(noise(octaves));
    for (const Vec3d& p : random.points(cube(3), 500)) {
      const Vec3d g = gradientsOf(*f, {p})[0];
      EXPECT_NEAR(apart(g, differences([&](const Vec3d& q) { return valueOf(*f, q); }, p, 1e-5)), 0, 3e-6);
    }
  }
}

TEST(ShapeNoise, SecondDerivativesAreContinuousAcrossCells) {
  Random random(3);
  const auto f = makeNoise(noise());
  // Slopes of the gradient on both sides of the planes that cells meet in. With a cubic fade they differ by some tens.
  constexpr double kStep = 1e-5;
  double greatest = 0;
  for (int i = 0; i < 300; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d p = random.point(cube(3));
      p[axis] = .5 * std::round(p[axis] / .5);
      Vec3d before = p, after = p;
      before[axis] -= kStep;
      after[axis] += kStep;
      const std::vector<Vec3d> g = gradientsOf(*f, {before, p, after});
      for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR((g[2][a] - g[1][a]) / kStep, (g[1][a] - g[0][a]) / kStep, .02);
        greatest = std::max(greatest, std::abs(g[2][a] - g[1][a]) / kStep);
      }
    }
  EXPECT_GT(greatest, 1); // they are not all 0 there
}

TEST(ShapeNoise, IsTheSameEverywhereAndForever) {
  const std::vector<Vec3d> points{{.1, .2, .3}, {-7.25, 3.5, 11.75}, {1234.5, -.0625, 1e6}};
  const double expected[2][3] = {{0x1.543364142ba5cp-4, 0x1.5e3106604f086p-6, 0x1.efe1e1e8e4735p-6},
                                 {0x1.4db085489177dp-6, -0x1.1152b92dbbc96p-4, 0x1.763e3a39258f9p-5}};
  for (const int octaves : {1, 6}) {
    const std::vector<double> values = valuesOf(*makeNoise(noise(octaves, 7)), points);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(values[i], expected[octaves > 1][i]);
  }
  // A point alone, at the end of what SIMD takes, with its gradient: the same bits.
  Random random(4);
  const auto f = makeNoise(noise(3));
  const std::vector<Vec3d> many = random.points(cube(5), kShapeBatch - 3);
  const std::vector<double> together = valuesOf(*f, many);
  const std::vector<Vec3d> slopes = gradientsOf(*f, many);
  for (std::size_t i = 0; i < many.size(); ++i) {
    double value;
    Vec3d g;
    f->evaluate({&many[i][0], &many[i][1], &many[i][2], 1}, {&value, {&g[0], &g[1], &g[2]}});
    EXPECT_EQ(value, together[i]);
    EXPECT_EQ(g, slopes[i]);
  }
}

TEST(ShapeNoise, SeedsDifferAndDriftMovesIt) {
  Random random(5);
  shapes::NoiseDisplacement moved = noise(3);
  moved.drift = {.25, -1, 3.5};
  const auto still = makeNoise(noise(3)), other = makeNoise(noise(3, 1)), drifted = makeNoise(moved);
  double difference = 0;
  for (const Vec3d& p : random.points(cube(5), 300)) {
    difference += std::abs(valueOf(*still, p) - valueOf(*other, p));
    EXPECT_NEAR(valueOf(*drifted, {p[0] + .25, p[1] - 1, p[2] + 3.5}), valueOf(*still, p), 1e-12);
  }
  EXPECT_GT(difference / 300, .02);
}

TEST(ShapeNoise, BoundsHoldAllValuesAndShrinkByTheSquare) {
  Random random(6);
  for (const int octaves : {1, 3, 8}) {
    const auto f = makeNoise(noise(octaves, octaves));
    for (int i = 0; i < 400; ++i) expectBound(*f, random, random.box(cube(3)));
  }
  const auto f = makeNoise(noise());
  for (const double half : {.02, .005, 1e-3, 1e-5, 0.}) {
    double worst = 0;
    for (int i = 0; i < 200; ++i) {
      const Vec3d p = random.point(cube(3));
      Box box{p, p};
      for (int a = 0; a < 3; ++a) {
        box.min[a] -= half;
        box.max[a] += half;
      }
      // What a plane of its slope takes over the box, and no more than what its bending adds.
      const Vec3d g = gradientsOf(*f, {p})[0];
      const Interval bound = f->bound(box);
      worst = std::max(worst, bound.high - bound.low - 2 * half * (std::abs(g[0]) + std::abs(g[1]) + std::abs(g[2])));
    }
    EXPECT_LE(worst, 120 * half * half + 1e-11);
  }
}

TEST(ShapeNoise, FarPointsAndHugeBoxesAreTaken) {
  Random random(7);
  const auto f = makeNoise(noise(12));
  for (const double reach : {1e7, 1e12, 1e21, 1e300}) {
    expectBound(*f, random, cube(reach));
    EXPECT_LE(magnitude(f->bound(cube(reach))), .3 + 1e-12);
    expectBound(*f, random, {{reach, -reach, reach}, {reach, -reach, reach}});
  }
}

TEST(ShapeWaves, AreCosines) {
  Random random(8);
  shapes::WaveDisplacement plane{.2, .7, 2.3, {1, -2, .5}, false}, rings{.2, .7, -.4, {0, 0, 0}, true};
  const double length = std::hypot(1, 2, .5), turn = 2 * std::numbers::pi;
  for (const Vec3d& p : random.points(cube(3), 1000)) {
    const double along = (p[0] - 2 * p[1] + .5 * p[2]) / length, radius = std::hypot(p[0], p[1]);
    EXPECT_NEAR(valueOf(*makeWaves(plane), p), .2 * std::cos(turn * (along / .7 - 2.3)), 1e-14);
    EXPECT_NEAR(valueOf(*makeWaves(rings), p), .2 * std::cos(turn * (radius / .7 + .4)), 1e-14);
  }
  for (const auto& waves : {plane, rings}) {
    const auto f = makeWaves(waves);
    for (const Vec3d& p : random.points(cube(3), 300))
      EXPECT_NEAR(apart(gradientsOf(*f, {p})[0], differences([&](auto& q) { return valueOf(*f, q); }, p, 1e-6)), 0,
                  1e-7);
  }
  rings.phase = 0;
  EXPECT_EQ(gradientsOf(*makeWaves(rings), {{0, 0, 1}})[0], (Vec3d{0, 0, 0}));
}

TEST(ShapeWaves, BoundsAreWhatTheyTake) {
  Random random(9);
  for (const bool radial : {false, true}) {
    const auto f = makeWaves({.2, .7, .3, {3, 0, 0}, radial});
    for (int i = 0; i < 500; ++i) {
      const Box box = random.box(cube(3));
      expectBound(*f, random, box);
      if (radial) continue;
      Interval seen{1, -1}; // along the one axis that they depend on
      for (int k = 0; k <= 2000; ++k) {
        const double v = valueOf(*f, {box.min[0] + (box.max[0] - box.min[0]) * k / 2000, 0, 0});
        seen = united(seen, {v, v});
      }
      const Interval bound = f->bound(box);
      EXPECT_NEAR(bound.low, seen.low, 2e-5);
      EXPECT_NEAR(bound.high, seen.high, 2e-5);
    }
    for (const double reach : {1e9, 1e20, 1e150}) expectBound(*f, random, cube(reach));
  }
}

} // namespace volcaustic::test
