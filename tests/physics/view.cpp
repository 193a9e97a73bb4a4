// Closed forms of the camera pass, on volumes of light filled by hand.

#include "volcaustic/view.h"
#include "support/fields.h"
#include "volume/radiance_bricks.h"

#include <cmath>
#include <gtest/gtest.h>

namespace volcaustic::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A volume whose direct fluence and direction are functions of the voxel's centre.
RadianceVolume lightVolume(const Domain& domain, const std::function<float(const Vec3d&)>& fluence,
                           const Vec3f& direction) {
  auto light = std::make_shared<RadianceBricks>(domain.dims);
  FluenceGrid& direct = light->direct.stored;
  direct.reserve(direct.brickCount(), {});
  for (std::int64_t b = 0; b < direct.brickCount(); ++b) {
    const std::int32_t slot = direct.claim(1);
    const auto voxels = direct.slot(slot);
    const Vec3i c = direct.brickCoord(b);
    for (int k = 0; k < kBrickVoxels; ++k) {
      const Vec3d p{(c[0] * 8 + (k >> 6) + .5) * domain.voxelSize, (c[1] * 8 + ((k >> 3) & 7) + .5) * domain.voxelSize,
                    (c[2] * 8 + (k & 7) + .5) * domain.voxelSize};
      const float f = fluence(p);
      voxels[k] =
          kernels::pack({kernels::Float3(f, f, f), kernels::Float3(direction[0], direction[1], direction[2]) * f});
    }
    direct.assign(b, slot);
  }
  return {domain, light};
}

Camera cameraAlongX(int size = 9) {
  Camera c;
  c.position = {-4, .5, .5};
  c.target = {.5, .5, .5};
  c.fieldOfView = 8;
  c.resolution = {size, size};
  return c;
}

double centre(const Image& image, const char* channel) {
  return image.planes[image.find(channel)][static_cast<std::size_t>(image.height / 2) * image.width + image.width / 2];
}

TEST(View, EmptyMediumShowsTheBackground) {
  const Domain domain = unitCube(16);
  const Medium medium = buildMedium({}, {}, domain);
  const auto result = renderView(medium, lightVolume(domain, [](const Vec3d&) { return 1.f; }, {0, 0, -1}),
                                 cameraAlongX(), {{1, 2, 3}, {3, 2, 1}});
  EXPECT_NEAR(centre(result.image, "R"), 2, 1e-5);
  EXPECT_NEAR(centre(result.image, "G"), 2, 1e-5);
  EXPECT_EQ(centre(result.image, "A"), 0);
}

// Single scattering of uniform light: L = scattering * fluence * phase * (1 - exp(-t d)) / t.
TEST(View, SingleScatteringInUniformFog) {
  const Domain domain = unitCube(64);
  Ambient fog;
  fog.attenuation = {2, 1, .5};
  fog.scattering = {1, 1, .5};
  for (const double g : {0.0, .6, -.4}) {
    fog.asymmetry = g;
    const Medium medium = buildMedium({}, fog, domain);
    for (const double spread : {1.0, .5, 0.0}) {
      // The light travels along (-1, 0, 0) on average; the camera looks along (1, 0, 0): scattered straight on into the
      // lens.
      const auto light = lightVolume(domain, [](const Vec3d&) { return 3.f; }, {static_cast<float>(-spread), 0, 0});
      const auto image = renderView(medium, light, cameraAlongX(), {{0, 0, 0}, {0, 0, 0}}).image;
      const double e = g * spread, phase = (1 - e * e) / (4 * kPi * std::pow(1 + e * e - 2 * e, 1.5));
      for (int c = 0; c < 3; ++c) {
        const double expected = fog.scattering[c] * 3 * phase * -std::expm1(-fog.attenuation[c]) / fog.attenuation[c];
        const char* names[] = {"R", "G", "B"};
        EXPECT_NEAR(centre(image, names[c]), expected, .01 * expected)
            << "g " << g << " spread " << spread << " channel " << c;
      }
      EXPECT_NEAR(centre(image, "transmittance.R"), std::exp(-2), 1e-4);
    }
  }
}

// Furnace: in a cavity of uniform radiance, matter that only scatters cannot be seen, whatever its index; fluence in it
// is 4 pi n^2 L. A wrong n^2 factor shows at once.
TEST(View, FurnaceHidesARefractingScatterer) {
  const Domain domain = unitCube(64);
  Ambient fog;
  fog.attenuation = fog.scattering = {1.5, 1.5, 1.5};
  const IndexField n = [](const Vec3d& p) { return 1 + .4 * smootherStep((.4 - distanceTo(p, .5, .5, .5)) / .25); };
  const Medium medium = sampleMedium(domain, fog, n);
  const auto light =
      lightVolume(domain, [&](const Vec3d& p) { return static_cast<float>(4 * kPi * 2 * n(p) * n(p)); }, {0, 0, 0});
  Camera camera = cameraAlongX(33);
  camera.fieldOfView = 14;
  const auto image = renderView(medium, light, camera, {{2, 2, 2}, {2, 2, 2}}).image;
  for (const float v : image.planes[image.find("R")]) ASSERT_NEAR(v, 2, .01);
}

TEST(View, EmissionInsideADenseMediumIsDimmedByIndexSquared) {
  const Domain domain = unitCube(32);
  Ambient fog;
  fog.attenuation = fog.scattering = {.01, .01, .01};
  const auto light = lightVolume(domain, [](const Vec3d&) { return 1.f; }, {0, 0, 0});
  const Medium thin = sampleMedium(domain, fog, [](const Vec3d&) { return 1.0; });
  const Medium dense = sampleMedium(domain, fog, [](const Vec3d&) { return 1.5; });
  const Background black{{0, 0, 0}, {0, 0, 0}};
  const double a = centre(renderView(thin, light, cameraAlongX(), black).image, "R"),
               b = centre(renderView(dense, light, cameraAlongX(), black).image, "R");
  EXPECT_NEAR(b / a, 1 / 2.25, 1e-3);
}

// A ball lens turns what is behind it upside down: looking along x, a background gradient along z is reversed in its
// middle.
TEST(View, BallLensInvertsTheBackground) {
  const Domain domain = unitCube(96);
  const Medium medium = sampleMedium(
      domain, {}, [](const Vec3d& p) { return 1 + .5 * smootherStep((.4 - distanceTo(p, .5, .5, .5)) / .06); });
  Camera camera = cameraAlongX(41);
  camera.fieldOfView = 7;
  const auto image = renderView(medium, lightVolume(domain, [](const Vec3d&) { return 0.f; }, {0, 0, 0}), camera,
                                {{0, 0, 0}, {1, 1, 1}})
                         .image;
  const auto at = [&](int row) {
    return image.planes[image.find("R")][static_cast<std::size_t>(row) * image.width + image.width / 2];
  };
  EXPECT_GT(at(26), at(20));
  EXPECT_GT(at(20), at(14));
  EXPECT_LT(std::abs(at(20) - .5f), .02);
}

TEST(View, SameBitsWithOneAndTwoThreads) {
  const Domain domain = unitCube(32);
  Ambient fog;
  fog.attenuation = fog.scattering = {1, 1, 1};
  const Medium medium = sampleMedium(domain, fog, indexField("smooth_sphere"));
  const auto light = lightVolume(domain, [](const Vec3d& p) { return static_cast<float>(p[2]); }, {0, 0, -1});
  RunContext one, two;
  one.threads = 1;
  two.threads = 2;
  ViewOptions options;
  options.samples = 2;
  const auto a = renderView(medium, light, cameraAlongX(21), {}, {}, options, one),
             b = renderView(medium, light, cameraAlongX(21), {}, {}, options, two);
  EXPECT_EQ(a.image.planes, b.image.planes);
  EXPECT_EQ(a.steps, b.steps);
}

} // namespace
} // namespace volcaustic::test
