// Reflection at surfaces: Snell's critical angle from bent paths alone, Fresnel's equations on request.

#include "kernels/fresnel.h"
#include "support/tracing.h"
#include "volcaustic/view.h"

#include <gtest/gtest.h>

namespace volcaustic::test {
namespace {

constexpr double kPi = 3.14159265358979323846, kDegree = kPi / 180;

/// Fresnel's reflectance of unpolarised light, by the angles of the textbooks.
double reflectance(double before, double behind, double angle) {
  const double sine = before / behind * std::sin(angle);
  if (sine >= 1) return 1;
  const double other = std::asin(sine);
  if (angle < 1e-9) return std::pow((before - behind) / (before + behind), 2);
  const double s = std::sin(angle - other) / std::sin(angle + other),
               p = std::tan(angle - other) / std::tan(angle + other);
  return .5 * (s * s + p * p);
}

/// Index 1 above z = .5, `dense` below, with a skin as wide as that of a voxelised surface.
Medium halfSpace(int resolution, double dense, double voxels = 3) {
  return sampleMedium(unitCube(resolution), {}, [=](const Vec3d& p) {
    return 1 + (dense - 1) * .5 * std::erfc((p[2] - .5) * resolution / voxels);
  });
}

TEST(Fresnel, ReflectanceIsThatOfTheTextbooks) {
  for (const auto& [before, behind] : {std::pair{1.0, 1.5}, {1.5, 1.0}, {1.33, 2.4}})
    for (int degrees = 0; degrees < 90; degrees += 3) {
      const double along = before * std::sin(degrees * kDegree);
      if (along > behind) continue;
      EXPECT_NEAR(kernels::fresnelReflectance<float>(float(before), float(behind), float(along * along)),
                  reflectance(before, behind, degrees * kDegree), 2e-5)
          << before << " to " << behind << " at " << degrees;
    }
}

// Total reflection is what a bent path does by itself: it turns round where n sin(angle) comes to 1.
TEST(Fresnel, BentPathsTurnRoundAtSnellsCriticalAngle) {
  for (const double dense : {1.33, 1.5, 2.4}) {
    const Medium medium = halfSpace(128, dense);
    const double critical = std::asin(1 / dense) / kDegree;
    for (const double off : {-6.0, -1.0, -.1, .1, 1.0, 6.0}) {
      const double angle = (critical + off) * kDegree;
      TracedRay ray;
      ray.position = {.1, .5, .3};
      ray.direction = {std::sin(angle), 0, std::cos(angle)};
      traceRays(medium, std::span(&ray, 1));
      ASSERT_TRUE(ray.left);
      EXPECT_EQ(ray.direction[2] > 0, off < 0) << "n " << dense << ", " << off << " degrees from the critical angle";
      if (std::abs(off) < 1) continue; // within a tenth of a degree a ray leaves the box before it has left the skin
      if (off > 0)
        EXPECT_NEAR(ray.direction[2], -std::cos(angle), .005);
      else
        EXPECT_NEAR(ray.direction[0], dense * std::sin(angle), .01); // Snell
    }
  }
}

// A beam on a plane surface: above it goes the reflected beam, as wide as the one that comes, with R of its light.
TEST(Fresnel, PhotonsAreReflectedAsOftenAsTheEquationsSay) {
  for (const double degrees : {0.0, 30.0, 60.0, 75.0}) {
    const Medium medium = halfSpace(64, 1.5);
    Light light;
    light.direction = {std::sin(degrees * kDegree), 0, -std::cos(degrees * kDegree)};
    PhotonOptions options;
    options.grid = {512, 512};
    options.smooth = false;
    options.fresnel = true;
    const PhotonResult result = tracePhotons(medium, std::span(&light, 1), {}, options);
    EXPECT_LT(result.balance.relativeImbalance(), 1e-6);
    // Where both beams are whole: over the middle, less the way that light travels sideways.
    double reflected = 0, direct = 0;
    for (int x = 36; x < 60; ++x)
      for (int y = 4; y < 60; ++y)
        for (int z = 40; z < 42; ++z) {
          reflected += result.radiance.causticFluence({x, y, z})[1];
          direct += result.radiance.directFluence({x, y, z})[1];
        }
    if (direct == 0) continue; // the light at a grazing angle does not come down there
    const double expected = reflectance(1, 1.5, degrees * kDegree);
    EXPECT_NEAR(reflected / direct, expected, .02 * expected + .002) << degrees;
  }
}

// Without it no light comes back.
TEST(Fresnel, NothingIsReflectedUnlessAskedFor) {
  const Medium medium = halfSpace(64, 1.5);
  const Light light;
  PhotonOptions options;
  options.grid = {128, 128};
  options.smooth = false;
  const PhotonResult result = tracePhotons(medium, std::span(&light, 1), {}, options);
  for (int x = 8; x < 56; ++x) ASSERT_EQ(result.radiance.causticFluence({x, 32, 50})[1], 0);
}

Camera cameraAtBall() {
  Camera c;
  c.position = {-4, .5, .5};
  c.target = {.5, .5, .5};
  c.fieldOfView = 16;
  c.resolution = {64, 64};
  return c;
}

// Energy is conserved where a ray splits: in uniform light a ball of glass cannot be seen, reflecting or not.
TEST(Fresnel, FurnaceHidesReflectingGlass) {
  const Medium medium = buildMedium(std::vector{glassBall({.5, .5, .5}, .35, 1.5)}, {}, unitCube(96));
  ViewOptions options;
  options.fresnel = true;
  const Light light;
  PhotonOptions dark;
  dark.grid = {8, 8};
  const PhotonResult photons = tracePhotons(medium, std::span(&light, 1), {}, dark);
  Background white;
  white.bottom = white.top = {2, 2, 2};
  const Image image = renderView(medium, photons.radiance, cameraAtBall(), white, {}, options).image;
  for (const float v : image.planes[image.find("R")]) ASSERT_NEAR(v, 2, 2e-3);
  for (const float a : image.planes[image.find("A")]) ASSERT_NEAR(a, 0, 1e-3);
}

// The sky above, mirrored by the upper half of a ball whose inside is black: R at the angle of the mirror.
TEST(Fresnel, TheCameraSeesReflections) {
  Body body = glassBall({.5, .5, .5}, .35, 1.5);
  body.material.attenuation = {1e3, 1e3, 1e3};
  const Medium medium = buildMedium(std::vector{body}, {}, unitCube(128));
  const Light light;
  PhotonOptions dark;
  dark.grid = {8, 8};
  const PhotonResult photons = tracePhotons(medium, std::span(&light, 1), {}, dark);
  Background white;
  white.bottom = white.top = {1, 1, 1};
  ViewOptions options;
  options.fresnel = true;
  const Camera camera = cameraAtBall();
  const Image image = renderView(medium, photons.radiance, camera, white, {}, options).image;
  const auto& red = image.planes[image.find("R")];
  const double perPixel = 2 * std::tan(8 * kDegree) / 64;
  int looked = 0;
  for (int column = 34; column < 64; ++column) {
    const double offset = 4.5 * std::sin(std::atan((column + .5 - 32) * perPixel)); // from the ball's centre
    const double sine = offset / .35;
    if (sine > .9) continue;
    const double expected = reflectance(1, 1.5, std::asin(sine));
    EXPECT_NEAR(red[32 * 64 + column], expected, .12 * expected) << "at " << std::asin(sine) / kDegree << " degrees";
    ++looked;
  }
  EXPECT_GT(looked, 10);
}

} // namespace
} // namespace volcaustic::test
