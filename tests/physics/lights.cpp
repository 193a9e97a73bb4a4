// Spots, and lights that are no points, against closed forms.
#include "support/lights.h"
#include "support/tracing.h"
#include "transport/soft_lights.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>

namespace volcaustic::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

TEST(Spot, ItsConeHasTheIntensityAndThePowerThatItsAnglesSay) {
  // Above the box, inside it, and on its side so wide that the cone leaves through five faces.
  struct Place {
    Vec3d position, axis;
    double inner, outer;
    bool seen; ///< the box takes all of the cone
  };
  for (const Place& p :
       {Place{{.5, .5, 2}, {0, 0, -2}, 10, 18, true}, Place{{.4, .5, .6}, {1, .4, -.3}, 20, 50, true},
        Place{{.5, .5, .5}, {0, .1, 1}, 0, 90, true}, Place{{-.3, .5, .5}, {1, 0, .2}, 35, 35.5, false}}) {
    const double inner = std::cos(p.inner * kPi / 180), outer = std::cos(p.outer * kPi / 180);
    Light light;
    light.type = LightType::Spot;
    light.position = p.position;
    light.direction = p.axis;
    light.intensity = {3, 3, 3};
    light.innerAngle = p.inner;
    light.outerAngle = p.outer;
    const auto result = trace({}, {}, 32, light, {}, {}, 512);
    int lit = 0, dark = 0;
    forVoxels(result.radiance, [&](const Vec3i& v) {
      const Vec3d at{(v[0] + .5) / 32 - p.position[0], (v[1] + .5) / 32 - p.position[1],
                     (v[2] + .5) / 32 - p.position[2]};
      const double r = std::hypot(at[0], at[1], at[2]);
      if (r < 2.0 / 32) return;
      const double cosine = (at[0] * p.axis[0] + at[1] * p.axis[1] + at[2] * p.axis[2]) /
                            (r * std::hypot(p.axis[0], p.axis[1], p.axis[2]));
      const double ramp = std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0);
      ASSERT_NEAR(result.radiance.fluence(v)[0] * r * r, 3 * ramp * ramp, .01) << v[0] << ' ' << v[1] << ' ' << v[2];
      ++(ramp > 0 ? lit : dark);
    });
    EXPECT_GT(lit, 500);
    EXPECT_GT(dark, 500);
    // The square of a ramp in the cosine has a third of the plateau's share.
    const double power = 3 * 2 * kPi * (1 - inner + (inner - outer) / 3);
    if (p.seen) {
      EXPECT_NEAR(result.balance.emitted[0], power, 2e-4 * power);
    }
    EXPECT_LT(result.balance.relativeImbalance(), 1e-6);
  }
}

TEST(Spot, ThatMissesTheBoxGivesNoLight) {
  for (const Vec3d& axis : {Vec3d{0, 1, 1}, Vec3d{0, 0, 1}, Vec3d{1, 0, -.1}}) {
    const auto result = trace({glassBall({.5, .5, .5}, .3, 1.5)}, {}, 32, spot({.5, .5, 2}, axis, 20, 30));
    for (int c = 0; c < 3; ++c) EXPECT_EQ(result.balance.emitted[c], 0);
    EXPECT_EQ(result.balance.photonsTraced > 0, axis[0] > 0); // one of these cones reaches around the raster's plane
    forVoxels(result.radiance, [&](const Vec3i& v) { ASSERT_EQ(result.radiance.fluence(v)[0], 0); });
  }
}

// A spot that shines on a ball makes the caustic of a point light that shines there.
TEST(Spot, LightsABallAsALampDoes) {
  Light lamp, spot;
  lamp.type = LightType::Point;
  spot.type = LightType::Spot;
  lamp.position = spot.position = {.5, .5, 2.5};
  spot.direction = {0, 0, -1};
  spot.innerAngle = 14; // the ball and its smoothed skin are seen under 11 degrees
  spot.outerAngle = 16;
  const std::vector<Body> ball{glassBall({.5, .5, .5}, .2, 1.5)};
  const auto a = trace(ball, {}, 48, lamp, {}, {}, 1024), b = trace(ball, {}, 48, spot, {}, {}, 1024);
  // By blocks of 8^3 voxels, in which the rays of neither raster are few.
  std::array<double, 216> blocks[2]{};
  forVoxels(a.radiance, [&](const Vec3i& v) {
    const std::size_t block = std::size_t(v[0] / 8) * 36 + std::size_t(v[1] / 8) * 6 + std::size_t(v[2] / 8);
    blocks[0][block] += a.radiance.causticFluence(v)[0];
    blocks[1][block] += b.radiance.causticFluence(v)[0];
  });
  double difference = 0, totals[2] = {0, 0};
  for (std::size_t i = 0; i < 216; ++i) {
    difference += std::abs(blocks[0][i] - blocks[1][i]);
    for (int k = 0; k < 2; ++k) totals[k] += blocks[k][i];
  }
  EXPECT_GT(totals[0], 0);
  EXPECT_NEAR(totals[1] / totals[0], 1, 2e-3);
  EXPECT_LT(difference, .02 * totals[0]);
}

/// A sheet over the half of the cube with x < 1/2 that swallows light, a voxel thick.
constexpr int kVoxels = 64;
constexpr double kSheet = .75;
Body sheet() {
  Body body;
  Mesh mesh;
  const Vec3d low{-1, -1, kSheet}, high{.5, 2, kSheet + 1. / kVoxels};
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back({i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  body.mesh = std::make_shared<const Mesh>(std::move(mesh));
  body.material.index = 1;
  body.material.attenuation = {1e5, 1e5, 1e5};
  return body;
}

/// The part of a disc of radius 1 that is beyond a chord at the distance x of its middle.
double discBeyond(double x) {
  const double c = std::clamp(x, -1.0, 1.0);
  return (std::acos(c) - c * std::sqrt(1 - c * c)) / kPi;
}

TEST(SoftLight, ADiscInTheSkyThrowsThePenumbraOfADisc) {
  Light soft = sun({0, 0, -1}, {1, 1, 1});
  soft.angle = 16;
  soft.samples = 256;
  const auto result = trace({sheet()}, {}, kVoxels, soft, {}, {}, 2048);
  const double spread = std::tan(.5 * soft.angle * kPi / 180);
  int half = 0;
  forVoxels(result.radiance, [&](const Vec3i& v) {
    const double x = (v[0] + .5) / kVoxels, y = (v[1] + .5) / kVoxels, z = (v[2] + .5) / kVoxels;
    if (z > kSheet - .3 || std::abs(x - .5) > .2 || std::abs(y - .5) > .3) return;
    const double expected = discBeyond((.5 - x) / ((kSheet - z) * spread)), found = result.radiance.fluence(v)[0];
    ASSERT_NEAR(found, expected, .05) << v[0] << ' ' << v[1] << ' ' << v[2];
    half += expected > .2 && expected < .8;
  });
  EXPECT_GT(half, 3000);
}

TEST(SoftLight, ABallThrowsThePenumbraOfADisc) {
  Light soft = lamp({.5, .5, 2}, {1, 1, 1});
  soft.radius = .15;
  soft.samples = 256;
  const auto result = trace({sheet()}, {}, kVoxels, soft, {}, {}, 2048);
  forVoxels(result.radiance, [&](const Vec3i& v) {
    const double x = (v[0] + .5) / kVoxels, y = (v[1] + .5) / kVoxels, z = (v[2] + .5) / kVoxels;
    if (z > kSheet - .3 || std::abs(x - .5) > .1 || std::abs(y - .5) > .2) return;
    const double edge = x + (.5 - x) * (2 - z) / (kSheet - z); // where the line over the sheet's edge meets the lamp
    const double square = (x - .5) * (x - .5) + (y - .5) * (y - .5) + (z - 2) * (z - 2);
    ASSERT_NEAR(result.radiance.fluence(v)[0] * square, discBeyond((edge - .5) / soft.radius), .06)
        << v[0] << ' ' << v[1] << ' ' << v[2];
  });
}

TEST(SoftLight, SharesItsPhotonsAndKeepsItsPower) {
  for (Light light : {sun({.1, .2, -1}), lamp({.4, .5, .6}), spot({.5, .5, 2}, {0, 0, -1}, 8, 12),
                      areaLight({.5, .5, .9}, {0, 0, -1}, 0, 0)}) {
    const std::vector<Body> ball{glassBall({.5, .5, .4}, .2, 1.5)};
    const auto sharp = trace(ball, {}, 32, light);
    light.angle = 2;
    light.radius = light.width = light.height = .03;
    const auto soft = trace(ball, {}, 32, light);
    EXPECT_LT(soft.balance.relativeImbalance(), 1e-6);
    EXPECT_NEAR(double(soft.balance.photonsEmitted) / double(sharp.balance.photonsEmitted), 1, .05);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(soft.balance.emitted[c] / sharp.balance.emitted[c], 1, 5e-3);
  }
}

TEST(SoftLight, PartsOfABallLookLikeAnEvenDiscFromEverywhere) {
  Light light = lamp({3, -2, 5}, {1, 2, 3});
  light.radius = 2;
  light.samples = 1000;
  const std::vector<LightPart> parts = partsOf(std::span(&light, 1));
  ASSERT_EQ(parts.size(), 1000u);
  for (const Vec3d& axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}, Vec3d{.6, 0, .8}, Vec3d{.48, .6, -.64}}) {
    int inner = 0; // of half the disc's area
    double second = 0, fourth = 0;
    for (const LightPart& p : parts) {
      const Vec3d& q = p.light.position;
      const Vec3d r{q[0] - 3, q[1] + 2, q[2] - 5};
      const double along = r[0] * axis[0] + r[1] * axis[1] + r[2] * axis[2];
      const double across = (r[0] * r[0] + r[1] * r[1] + r[2] * r[2] - along * along) / 4; // of the radius, squared
      ASSERT_LE(across, 1 + 1e-9);
      inner += across < .5;
      second += across / 1000;
      fourth += across * across / 1000;
    }
    EXPECT_NEAR(inner, 500, 15);
    EXPECT_NEAR(second, 1 / 2., .01);
    EXPECT_NEAR(fourth, 1 / 3., .01);
  }
  double power = 0;
  for (const LightPart& p : parts) power += p.light.intensity[1];
  EXPECT_NEAR(power, 2, 1e-12);
}

/// Solid angle of a rectangle around the origin of the plane z = 0, from a point above or below it: of its quarters.
double rectangleSeenFrom(const Vec3d& p, double width, double height) {
  const auto quarter = [&](double x, double y) {
    return std::atan(x * y / (std::abs(p[2]) * std::sqrt(x * x + y * y + p[2] * p[2])));
  };
  const double x0 = -.5 * width - p[0], x1 = .5 * width - p[0], y0 = -.5 * height - p[1], y1 = .5 * height - p[1];
  return quarter(x1, y1) - quarter(x0, y1) - quarter(x1, y0) + quarter(x0, y0);
}

// Radiance is the same from everywhere, so the fluence is that times the solid angle, and nothing goes back.
TEST(AreaLight, FillsSpaceWithItsRadianceTimesItsSolidAngle) {
  constexpr int kEdge = 32;
  Light light = areaLight({.5, .5, .75}, {0, 0, -3}, .6, .3, {2, 2, 2});
  light.across = {2, 2, 1}; // its part along the direction is left out
  light.samples = 512;
  for (const bool round : {false, true}) {
    light.round = round;
    const auto result = trace({}, {}, kEdge, light, {}, {}, 2048);
    const double area = light.width * light.height * (round ? kPi / 4 : 1), radiance = 2 / area;
    int seen = 0;
    forVoxels(result.radiance, [&](const Vec3i& v) {
      const double x = (v[0] + .5) / kEdge - .5, y = (v[1] + .5) / kEdge - .5, z = (v[2] + .5) / kEdge - .75;
      const double found = result.radiance.fluence(v)[1];
      if (z > 0) {
        ASSERT_EQ(found, 0) << v[0] << ' ' << v[1] << ' ' << v[2];
        return;
      }
      if (z > -.15) return; // the points that stand for it can be told apart
      const double u = (x + y) / std::sqrt(2.), w = (y - x) / std::sqrt(2.);
      double angle = rectangleSeenFrom({u, w, z}, light.width, light.height);
      if (round) { // by rows of rectangles
        angle = 0;
        constexpr int kRows = 64;
        for (int i = 0; i < kRows; ++i) {
          const double row = (i + .5) / kRows * 2 - 1;
          angle += rectangleSeenFrom({u, w - .5 * row * light.height, z}, light.width * std::sqrt(1 - row * row),
                                     light.height / kRows);
        }
      }
      ASSERT_NEAR(found, radiance * angle, .02 * radiance * angle + .01) << v[0] << ' ' << v[1] << ' ' << v[2];
      ++seen;
    });
    EXPECT_GT(seen, 10000);
    // Half the sphere, by the cosine. All of it goes into the box.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(result.balance.emitted[c], 2 * kPi, 1e-3 * 2 * kPi);
    EXPECT_LT(result.balance.relativeImbalance(), 1e-6);
  }
}

TEST(AreaLight, ThrowsThePenumbraOfItsWidth) {
  Light light = areaLight({.5, .5, 1.75}, {0, 0, -1}, .3, 0, {1, 1, 1});
  light.samples = 256;
  const auto result = trace({sheet()}, {}, kVoxels, light, {}, {}, 2048);
  int half = 0;
  forVoxels(result.radiance, [&](const Vec3i& v) {
    const double x = (v[0] + .5) / kVoxels - .5, y = (v[1] + .5) / kVoxels - .5, z = (v[2] + .5) / kVoxels;
    if (z > kSheet - .3 || std::abs(x) > .1 || std::abs(y) > .1) return;
    const double down = 1.75 - z, edge = x - x * down / (kSheet - z); // where the line over the sheet's edge meets it
    const double shadow = std::clamp(.5 - edge / light.width, 0., 1.), r2 = down * down + x * x + y * y;
    ASSERT_NEAR(result.radiance.fluence(v)[0] * r2 * std::sqrt(r2) / down, shadow, .06)
        << v[0] << ' ' << v[1] << ' ' << v[2];
    half += shadow > .2 && shadow < .8;
  });
  EXPECT_GT(half, 1000);
}

TEST(SoftLight, WhatMakesNoSenseIsNamed) {
  const auto messageOf = [](const Light& light) {
    try {
      (void)partsOf(std::span(&light, 1));
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  Light light = lamp({0, 0, 2});
  light.name = "key";
  light.radius = -1;
  EXPECT_EQ(messageOf(light), "lights[0] (key): radius must be finite and not negative");
  light.radius = 1;
  light.samples = -1;
  EXPECT_EQ(messageOf(light), "lights[0] (key): samples must be in 0 to 1024");
  light.samples = 1;
  light.angle = 100;
  EXPECT_EQ(messageOf(light), "lights[0] (key): angle must be in 0 to 90 degrees");
  light = areaLight({0, 0, 2}, {1, 0, 0}, 1, 1);
  EXPECT_EQ(messageOf(light), "lights[0]: direction and across must be finite, not zero, and not on one line");
  light.across = {0, 1, 0};
  EXPECT_EQ(messageOf(light), "");
  light.height = -1;
  EXPECT_EQ(messageOf(light), "lights[0]: width and height must be finite and not negative");
}

} // namespace
} // namespace volcaustic::test
