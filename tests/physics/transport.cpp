// Conservation and closed forms of the photon pass.

#include "backends/lanes.h"
#include "support/fields.h"
#include "support/solids.h"
#include "support/tracing.h"
#include "volcaustic/error.h"
#include "volcaustic/photons.h"

#include <cmath>
#include <gtest/gtest.h>

namespace volcaustic::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

Light sun(const Vec3d& direction, const Rgb& irradiance = {1, 1, 1}) {
  Light l;
  l.direction = direction;
  l.irradiance = irradiance;
  return l;
}

TEST(DirectLight, IsTheIrradianceWhereNothingBends) {
  const Light light = sun({.3, -.2, -1}, {2, 3, 5});
  const auto result = trace({}, {}, 64, light);
  EXPECT_EQ(result.balance.photonsTraced, 0);
  forVoxels(result.radiance, [&](const Vec3i& v) {
    const Vec3f f = result.radiance.fluence(v);
    ASSERT_NEAR(f[0], 2, 2e-6);
    ASSERT_NEAR(f[1], 3, 3e-6);
    ASSERT_NEAR(f[2], 5, 5e-6);
    ASSERT_NEAR(
        std::hypot(result.radiance.direction(v)[0], result.radiance.direction(v)[1], result.radiance.direction(v)[2]),
        1, 1e-5);
  });
}

TEST(DirectLight, IsWithinOnePercentBesideAndBeforeABall) {
  const Vec3d d{.3, -.2, -1};
  const auto result = trace({glassBall({.5, .5, .5}, .2, 1.5)}, {}, 64, sun(d));
  const double length = std::hypot(d[0], d[1], d[2]);
  int lit = 0;
  forVoxels(result.radiance, [&](const Vec3i& v) {
    Vec3d r;
    double along = 0, square = 0;
    for (int a = 0; a < 3; ++a) {
      r[a] = (v[a] + .5) / 64 - .5;
      along += r[a] * d[a] / length;
      square += r[a] * r[a];
    }
    // The ball's smoothed skin, with all that a lookup there can see, reaches up to fourteen voxels beyond its radius.
    const double across = std::sqrt(square - along * along), reach = .2 + 14.0 / 64;
    const bool beside = across > reach, before = along < 0 && square > reach * reach;
    if (!beside && !before) return;
    ++lit;
    ASSERT_NEAR(result.radiance.directFluence(v)[0], 1, .01) << v[0] << ' ' << v[1] << ' ' << v[2];
  });
  EXPECT_GT(lit, 64 * 64 * 5);
}

// A body that only hints at being there is traced, not evaluated: both parts together must not show it.
TEST(DirectLight, AndTracedLightCoverEachVoxelOnce) {
  Body ghost = glassBall({.5, .5, .6}, .25, 1);
  ghost.material.attenuation = {1e-9, 1e-9, 1e-9};
  for (const Vec3d& d : {Vec3d{0, 0, -1}, Vec3d{.4, .3, -1}}) {
    const auto result = trace({ghost}, {}, 64, sun(d));
    EXPECT_GT(result.balance.photonsTraced, 10000);
    double sum = 0, worst = 0;
    forVoxels(result.radiance, [&](const Vec3i& v) {
      const double f = result.radiance.fluence(v)[0];
      sum += f;
      worst = std::max(worst, std::abs(f - 1));
    });
    EXPECT_NEAR(sum / (64 * 64 * 64), 1, 2e-4);
    EXPECT_LT(worst, .03) << "64 photons cross a voxel";
  }
}

TEST(Energy, BalancesAndAgreesWithTheVolume) {
  Body body = glassBall({.5, .5, .6}, .25, 1.5);
  body.material.attenuation = {3, 1, .2};
  body.material.scattering = {1, 1, 0};
  Ambient fog;
  fog.attenuation = {.2, .3, .4};
  fog.scattering = {.2, .1, 0};
  for (const bool roulette : {false, true}) {
    PhotonOptions options;
    options.roulette = roulette;
    options.cutoff = .05;
    const auto result = trace({body}, fog, 64, sun({.2, .1, -1}, {1, 2, 4}), options);
    const EnergyBalance& e = result.balance;
    EXPECT_LT(e.relativeImbalance(), 1e-5);
    EXPECT_EQ(e.photonsAtStepLimit, 0);
    EXPECT_EQ(e.photonsNotFinite, 0);
    for (int c = 0; c < 3; ++c) {
      EXPECT_GT(e.scattered[c] + e.absorbed[c], .1 * e.emitted[c]);
      EXPECT_NEAR(e.depositedLoss[c], e.tracedLoss[c], .01 * e.tracedLoss[c]) << "channel " << c;
    }
    EXPECT_EQ(e.absorbed[0] > 0, true);
    EXPECT_NEAR(e.received[0], 0, 0);
  }
}

TEST(Energy, EmittedPowerIsIrradianceTimesTheBoxsProjection) {
  const auto straight = trace({}, {}, 32, sun({0, 0, -1}));
  EXPECT_NEAR(straight.balance.emitted[0], 1, 1e-9);
  // A unit cube seen along (1, 1, 1) is a hexagon of area sqrt(3).
  const auto diagonal = trace({}, {}, 32, sun({1, 1, 1}));
  EXPECT_NEAR(diagonal.balance.emitted[0], std::sqrt(3), .005);
}

TEST(BeerLambert, DirectAndTracedLightDecayAlike) {
  Ambient fog;
  fog.attenuation = {2, 1, 0};
  const auto direct = trace({}, fog, 64, sun({0, 0, -1}));
  // The same fog as a body that fills the box: traced photons.
  Body block;
  block.mesh = std::make_shared<const Mesh>(ellipsoid({.5, .5, .5}, {20, 20, 20}, 64));
  block.material.index = 1;
  block.material.attenuation = fog.attenuation;
  PhotonOptions options;
  options.cutoff = 0;
  const auto traced = trace({block}, {}, 64, sun({0, 0, -1}), options);
  EXPECT_EQ(traced.balance.photonsTraced, 512 * 512);
  for (const int k : {2, 20, 50}) {
    const double depth = (64 - k - .5) / 64;
    for (int c = 0; c < 3; ++c) {
      const double expected = std::exp(-fog.attenuation[c] * depth);
      EXPECT_NEAR(direct.radiance.fluence({30, 30, k})[c], expected, 1e-3 * expected);
      EXPECT_NEAR(traced.radiance.fluence({30, 30, k})[c], expected, 2e-3 * expected);
    }
  }
}

/// Each instruction set of this processor.
class OnLanes : public testing::TestWithParam<std::string> {
protected:
  RunContext mCtx;
  void SetUp() override { mCtx.device = "cpu:" + GetParam(); }
};
INSTANTIATE_TEST_SUITE_P(All, OnLanes, testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const LaneSet& set : laneSets()) names.emplace_back(set.name);
                           return names;
                         }()),
                         [](const auto& set) { return set.param; });

// A body that fills the box and takes most of the light within a few voxels. The fluence of a voxel is the mean over
// its depth, not the value at its centre.
TEST_P(OnLanes, BeerLambertHoldsVoxelByVoxelInStrongAbsorption) {
  constexpr int kVoxels = 64;
  Body block;
  block.mesh = std::make_shared<const Mesh>(ellipsoid({.5, .5, .5}, {20, 20, 20}, 64));
  block.material.index = 1;
  block.material.attenuation = {.5 * kVoxels, .1 * kVoxels, .01 * kVoxels};
  block.material.scattering = {.2 * kVoxels, .1 * kVoxels, 0};
  PhotonOptions options;
  options.cutoff = 0;
  const auto straight = trace({block}, {}, kVoxels, sun({0, 0, -1}), options, mCtx, 256);
  EXPECT_EQ(straight.balance.photonsTraced, 256 * 256);
  for (int k = 0; k < kVoxels; ++k)
    for (int c = 0; c < 3; ++c) {
      const double a = block.material.attenuation[c] / kVoxels;
      const double mean = std::exp(-a * (kVoxels - 1 - k)) * (1 - std::exp(-a)) / a;
      // All photons go the same way here, so all of them round alike: each of a voxel's five parts to a whole unit,
      // which is 2^-15 of the strongest photon's light or less.
      EXPECT_NEAR(straight.radiance.fluence({20, 40, k})[c], mean, 1e-3 * mean + 2.5 / (1 << 15))
          << "voxel " << k << " channel " << c;
    }
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(straight.balance.tracedLoss[c], 1 - std::exp(-block.material.attenuation[c]), 1e-5);

  // On slanted ways rounding evens out: what voxels take, voxel by voxel, is what photons lose, but for the light of
  // less than half a unit that is left in the depth.
  constexpr double kLeft = 3e-5;
  const auto slanted = trace({block}, {}, kVoxels, sun({.31, -.23, -1}), options, mCtx, 256);
  const EnergyBalance& e = slanted.balance;
  EXPECT_LT(e.relativeImbalance(), 1e-6);
  for (int c = 0; c < 3; ++c) {
    const double lost = e.tracedLoss[c], albedo = block.material.scattering[c] / block.material.attenuation[c];
    EXPECT_GT(lost, .3 * e.emitted[c]);
    EXPECT_NEAR(e.depositedLoss[c], lost, kLeft * lost) << "channel " << c;
    EXPECT_NEAR(e.scattered[c], lost * albedo, 1e-5 * lost) << "channel " << c;
    double taken = 0;
    forVoxels(slanted.radiance,
              [&](const Vec3i& v) { taken += block.material.attenuation[c] * slanted.radiance.causticFluence(v)[c]; });
    EXPECT_NEAR(taken / std::pow(kVoxels, 3), lost, kLeft * lost) << "channel " << c;
  }
}

TEST(PointLight, FluenceFallsWithTheSquareAndPowerIsSolidAngle) {
  for (const Vec3d& position : {Vec3d{.5, .5, 2}, Vec3d{.4, .5, .6}, Vec3d{-.2, 1.3, 1.4}}) {
    Light lamp;
    lamp.type = LightType::Point;
    lamp.position = position;
    lamp.intensity = {3, 3, 3};
    const auto result = trace({}, {}, 32, lamp);
    forVoxels(result.radiance, [&](const Vec3i& v) {
      const double r =
          distanceTo({(v[0] + .5) / 32, (v[1] + .5) / 32, (v[2] + .5) / 32}, position[0], position[1], position[2]);
      if (r < 2.0 / 32) return;
      ASSERT_NEAR(result.radiance.fluence(v)[0] * r * r, 3, .01) << v[0] << ' ' << v[1] << ' ' << v[2];
    });
    const bool inside = position[2] < 1;
    if (inside) {
      EXPECT_NEAR(result.balance.emitted[0], 3 * 4 * kPi, .001);
    }
  }
}

TEST(PointLight, TracedAndDirectLightCoverEachVoxelOnce) {
  Body ghost = glassBall({.5, .5, .3}, .2, 1);
  ghost.material.attenuation = {1e-9, 1e-9, 1e-9};
  for (const Vec3d& position : {Vec3d{.5, .5, 2}, Vec3d{.4, .5, .7}}) {
    Light lamp;
    lamp.type = LightType::Point;
    lamp.position = position;
    // A raster along the voxels' own axes holds 32 rays in the width of a voxel, or one more or less: three percent.
    const auto result = trace({ghost}, {}, 32, lamp, {}, {}, 2048);
    EXPECT_GT(result.balance.photonsTraced, 10000);
    forVoxels(result.radiance, [&](const Vec3i& v) {
      const double r =
          distanceTo({(v[0] + .5) / 32, (v[1] + .5) / 32, (v[2] + .5) / 32}, position[0], position[1], position[2]);
      if (r < 4.0 / 32) return;
      ASSERT_NEAR(result.radiance.fluence(v)[0] * r * r, 1, .06) << v[0] << ' ' << v[1] << ' ' << v[2];
    });
  }
}

TEST(SameBits, WhateverTheNumberOfThreads) {
  Body body = glassBall({.5, .5, .6}, .25, 1.4);
  body.material.attenuation = {1, 2, 3};
  PhotonOptions options;
  options.jitter = true;
  options.roulette = true;
  options.cutoff = .2;
  RunContext one, two;
  one.threads = 1;
  two.threads = 2;
  const auto a = trace({body}, {}, 64, sun({.1, .2, -1}), options, one),
             b = trace({body}, {}, 64, sun({.1, .2, -1}), options, two);
  forVoxels(a.radiance, [&](const Vec3i& v) {
    ASSERT_EQ(a.radiance.fluence(v), b.radiance.fluence(v));
    ASSERT_EQ(a.radiance.direction(v), b.radiance.direction(v));
  });
  EXPECT_EQ(a.balance.escaped, b.balance.escaped);
  EXPECT_EQ(a.balance.steps, b.balance.steps);
}

TEST(Smoothing, KeepsTheTotal) {
  const std::vector<Body> bodies{glassBall({.5, .5, .6}, .25, 1.5)};
  const Medium medium = buildMedium(bodies, {}, unitCube(64));
  const Light light = sun({.2, .1, -1});
  PhotonOptions options;
  options.grid = {256, 256};
  double totals[2], peaks[2];
  for (const bool smooth : {false, true}) {
    options.smooth = smooth;
    const auto r = tracePhotons(medium, std::span(&light, 1), {}, options);
    totals[smooth] = peaks[smooth] = 0;
    forVoxels(r.radiance, [&](const Vec3i& v) {
      totals[smooth] += r.radiance.fluence(v)[1];
      peaks[smooth] = std::max<double>(peaks[smooth], r.radiance.fluence(v)[1]);
    });
  }
  EXPECT_NEAR(totals[1], totals[0], 1e-5 * totals[0]);
  EXPECT_LT(peaks[1], peaks[0]);
}

TEST(Cancel, StopsMidTrace) {
  std::atomic<bool> stop{true};
  RunContext ctx;
  ctx.cancel = &stop;
  const Light light = sun({0, 0, -1});
  const Medium medium = buildMedium(std::vector<Body>{glassBall({.5, .5, .5}, .2, 1.5)}, {}, unitCube(32));
  EXPECT_THROW(tracePhotons(medium, std::span(&light, 1), {}, {}, ctx), Error);
}

} // namespace
} // namespace volcaustic::test
