// Backgrounds as cameras see them, and as sources of light, against closed forms.
#include "transport/environment.h"
#include "support/lights.h"
#include "support/shared_data.h"
#include "support/tracing.h"
#include "transport/many_lamps.h"
#include "transport/soft_lights.h"
#include "volcaustic/error.h"
#include "volcaustic/view.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

namespace volcaustic::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

using Colour = std::function<Rgb(const Vec3d& direction)>;

/// A map of a function of direction, where up is z.
std::shared_ptr<const Image> mapOf(int width, int height, const Colour& colour) {
  auto image = std::make_shared<Image>();
  image->width = width;
  image->height = height;
  for (const char* channel : {"R", "G", "B"}) image->add(channel);
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const double longitude = kPi - 2 * kPi * (column + .5) / width, polar = kPi * (row + .5) / height;
      const Rgb c =
          colour({std::sin(polar) * std::cos(longitude), std::sin(polar) * std::sin(longitude), std::cos(polar)});
      for (int i = 0; i < 3; ++i) image->planes[i][std::size_t(row) * width + column] = static_cast<float>(c[i]);
    }
  return image;
}

double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3d unit(const Vec3d& a) {
  const double length = std::sqrt(dot(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}

Image picture(const Background& background, const Camera& camera, const std::string& device = "cpu") {
  RunContext ctx;
  ctx.device = device;
  const Medium nothing = buildMedium({}, {}, unitCube(8), {}, ctx);
  return renderView(nothing, tracePhotons(nothing, {}, {}, {}, ctx).radiance, camera, background, {}, {}, ctx).image;
}

Camera cameraTowards(const Vec3d& direction, const Vec3d& up, double fieldOfView) {
  Camera camera;
  camera.position = {.5, .5, .5};
  for (int i = 0; i < 3; ++i) camera.target[i] = camera.position[i] + direction[i];
  camera.up = up;
  camera.fieldOfView = fieldOfView;
  camera.resolution = {40, 40};
  return camera;
}

/// Calls visit(colour of the background layer, direction) for each pixel.
template <class Visit>
void forPixels(const Image& image, const Camera& camera, const Visit& visit) {
  Vec3d forward{};
  for (int i = 0; i < 3; ++i) forward[i] = camera.target[i] - camera.position[i];
  forward = unit(forward);
  const Vec3d right = unit(cross(forward, camera.up)), up = cross(right, forward);
  const double half = std::tan(.5 * camera.fieldOfView * kPi / 180);
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column) {
      const double x = half * (2 * (column + .5) / image.width - 1), y = half * (1 - 2 * (row + .5) / image.height);
      Vec3d d{};
      for (int i = 0; i < 3; ++i) d[i] = forward[i] + x * right[i] + y * up[i];
      const std::size_t at = std::size_t(row) * image.width + column;
      visit(Rgb{image.planes[image.find("background.R")][at], image.planes[image.find("background.G")][at],
                image.planes[image.find("background.B")][at]},
            unit(d));
    }
}

// A map of the directions themselves: its colours say where one looks, over the poles and across the seam too.
TEST(Background, AMapIsSeenInItsDirections) {
  Background background;
  background.scale = {1, 2, .5};
  background.image = mapOf(180, 91, [](const Vec3d& d) { return Rgb{2 + d[0], 2 + d[1], 2 + d[2]}; });
  struct Turn {
    Vec3d up, front, left; ///< where the map's z, x and y are
    double degrees;
  };
  const double s = std::sqrt(.5);
  for (const Turn& t : {Turn{{0, 0, 2}, {1, 0, 0}, {0, 1, 0}, 0}, Turn{{0, 0, 1}, {s, s, 0}, {-s, s, 0}, 45},
                        Turn{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}, 0}, Turn{{0, 3, 0}, {0, 0, 1}, {1, 0, 0}, -90},
                        Turn{{-1, 0, 1}, {s, 0, s}, {0, 1, 0}, 0}}) {
    background.up = t.up;
    background.turn = t.degrees;
    for (const Vec3d& towards : {Vec3d{1, 0, 0}, Vec3d{-1, .1, .1}, Vec3d{0, 0, 1}, Vec3d{.1, .3, -1}, Vec3d{0, -1, 0}})
      for (const char* device : {"cpu", "cpu:scalar"}) {
        const Camera camera = cameraTowards(towards, std::abs(towards[2]) < .5 ? Vec3d{0, 0, 1} : Vec3d{0, 1, 0}, 100);
        forPixels(picture(background, camera, device), camera, [&](const Rgb& seen, const Vec3d& d) {
          const Rgb expected{2 + dot(d, t.front), 2 * (2 + dot(d, t.left)), .5 * (2 + dot(d, unit(t.up)))};
          for (int c = 0; c < 3; ++c) ASSERT_NEAR(seen[c], expected[c], 2e-3) << d[0] << ' ' << d[1] << ' ' << d[2];
        });
      }
  }
}

TEST(Background, AGradientFollowsItsOwnAxis) {
  Background background{{1, 0, 2}, {3, 4, 2}, {0, -1, 0}};
  const Camera camera = cameraTowards({0, -1, .2}, {1, 0, 0}, 90);
  forPixels(picture(background, camera), camera, [&](const Rgb& seen, const Vec3d& d) {
    const double share = .5 - .5 * d[1];
    ASSERT_NEAR(seen[0], 1 + 2 * share, 1e-5);
    ASSERT_NEAR(seen[1], 4 * share, 1e-5);
    ASSERT_NEAR(seen[2], 2, 1e-5);
  });
  background.visible = false;
  forPixels(picture(background, camera), camera, [&](const Rgb& seen, const Vec3d&) {
    ASSERT_EQ(seen, (Rgb{0, 0, 0}));
  });
}

Light environment(const Background& background, int samples = 0) {
  Light light;
  light.type = LightType::Environment;
  light.environment = background;
  light.samples = samples;
  return light;
}
std::vector<LightPart> partsOf(const Light& light) { return volcaustic::partsOf(std::span(&light, 1)); }

TEST(EnvironmentLight, AnEvenSkyHasItsPowerAndItsIrradianceOnEveryPlane) {
  for (const int samples : {64, 256}) {
    Light light = environment({{2, 3, 4}, {2, 3, 4}}, samples);
    light.scale = {1, .5, 0};
    const std::vector<LightPart> parts = partsOf(light);
    ASSERT_EQ(int(parts.size()), samples);
    Rgb all{0, 0, 0};
    double photons = 0;
    for (const LightPart& p : parts) {
      photons += p.share;
      for (int c = 0; c < 3; ++c) all[c] += p.light.irradiance[c];
    }
    EXPECT_NEAR(photons, 1, 1e-12);
    EXPECT_NEAR(all[0], 4 * kPi * 2, 1e-5);
    EXPECT_NEAR(all[1], 4 * kPi * 1.5, 1e-5);
    EXPECT_EQ(all[2], 0);
    // A part's directions are drawn together, so planes get a little more of it: 1/(mean cosine to its middle).
    for (const Vec3d& normal : {Vec3d{0, 0, 1}, Vec3d{0, 0, -1}, Vec3d{1, 0, 0}, unit({1, -2, .7})}) {
      double irradiance = 0;
      for (const LightPart& p : parts)
        irradiance += p.light.irradiance[0] * std::max(0.0, -dot(p.light.direction, normal));
      EXPECT_NEAR(irradiance, kPi * 2, (samples == 64 ? .03 : .008) * kPi * 2);
    }
  }
}

TEST(EnvironmentLight, ASunOfAFewPixelsKeepsItsPowerAndItsPlace) {
  const int width = 256, height = 128;
  const auto lies = [&](int column, int row) { return (column == 200 || column == 201) && (row == 30 || row == 31); };
  int pixel = 0;
  const auto image = mapOf(width, height, [&](const Vec3d&) {
    const bool sun = lies(pixel % width, pixel / width);
    ++pixel;
    return sun ? Rgb{1e5, 9e4, 7e4} : Rgb{.1, .2, .4};
  });
  Background background;
  background.image = image;
  std::vector<LightPart> parts = partsOf(environment(background));
  ASSERT_EQ(parts.size(), 64u);
  // The sun's solid angle and its middle, pixel by pixel.
  double angle = 0;
  Vec3d middle{0, 0, 0};
  for (int row = 30; row < 32; ++row)
    for (int column = 200; column < 202; ++column) {
      const double area = 2 * kPi / width * (std::cos(kPi * row / height) - std::cos(kPi * (row + 1) / height));
      const double longitude = kPi - 2 * kPi * (column + .5) / width, polar = kPi * (row + .5) / height;
      angle += area;
      middle[0] += area * std::sin(polar) * std::cos(longitude);
      middle[1] += area * std::sin(polar) * std::sin(longitude);
      middle[2] += area * std::cos(polar);
    }
  middle = unit(middle);
  double sun = 0, sky = 0;
  Vec3d towards{0, 0, 0};
  int suns = 0;
  for (const LightPart& p : parts) {
    const bool isSun = p.light.irradiance[0] > .2 * 1e5 * angle;
    suns += isSun;
    (isSun ? sun : sky) += p.light.irradiance[0];
    for (int i = 0; isSun && i < 3; ++i) towards[i] -= p.light.irradiance[0] * p.light.direction[i];
  }
  EXPECT_NEAR((sun + sky) / (1e5 * angle + .1 * (4 * kPi - angle)), 1, 1e-6);
  EXPECT_NEAR(sun / (1e5 * angle), 1, 5e-4); // its parts may reach into the sky beside it
  EXPECT_LT(std::acos(std::min(dot(unit(towards), middle), 1.0)), 1e-4);
  EXPECT_LE(suns, 4);
  EXPECT_GE(parts.size() - std::size_t(suns), 32u) << "the sky has to be more than one lamp";
}

TEST(EnvironmentLight, TheDarkGivesNone) {
  EXPECT_TRUE(partsOf(environment({{0, 0, 0}, {0, 0, 0}})).empty());
  const auto result = trace({glassBall({.5, .5, .5}, .3, 1.5)}, {}, 16, environment({{0, 0, 0}, {0, 0, 0}}));
  EXPECT_EQ(result.balance.photonsEmitted, 0);
  forVoxels(result.radiance, [&](const Vec3i& v) { ASSERT_EQ(result.radiance.fluence(v)[0], 0); });
}

TEST(EnvironmentLight, FillsAnEmptyBoxWithItsFluence) {
  const auto result = trace({}, {}, 16, environment({{2, 1, 0}, {2, 1, 0}}));
  forVoxels(result.radiance, [&](const Vec3i& v) {
    ASSERT_NEAR(result.radiance.fluence(v)[0], 4 * kPi * 2, 1e-3);
    ASSERT_NEAR(result.radiance.fluence(v)[1], 4 * kPi, 1e-3);
  });
}

// Radiance over n^2 is what rays keep: in even light from everywhere, glass cannot be told from its surroundings by
// fluence outside, and has n^2 times as much where rays from all directions come (within R/n of the middle).
TEST(EnvironmentLight, TheFurnaceOfLight) {
  const double index = 1.25, radius = .3;
  const auto result =
      trace({glassBall({.5, .5, .5}, radius, index)}, {}, 48, environment({{1, 1, 1}, {1, 1, 1}}, 128), {}, {}, 1024);
  double inside = 0, outside = 0;
  int insides = 0, outsides = 0;
  forVoxels(result.radiance, [&](const Vec3i& v) {
    const double r = std::hypot((v[0] + .5) / 48 - .5, (v[1] + .5) / 48 - .5, (v[2] + .5) / 48 - .5);
    const double fluence = result.radiance.fluence(v)[0] / (4 * kPi);
    if (r < .55 * radius) {
      inside += fluence;
      ++insides;
    } else if (r > 1.35 * radius) {
      outside += fluence;
      ++outsides;
    }
  });
  EXPECT_NEAR(inside / insides, index * index, .02 * index * index);
  EXPECT_NEAR(outside / outsides, 1, .005);
  EXPECT_LT(result.balance.relativeImbalance(), 1e-6);
}

// Lamps from all sides through thin fog, in a brick in a corner of the domain and in one inside.
TEST(ManyLamps, InterpolateWhatEachLampGives) {
  const kernels::Int3 dims(64, 48, 56);
  for (const kernels::Int3& low : {kernels::Int3(0, 0, 0), kernels::Int3(56, 40, 48), kernels::Int3(24, 16, 32)}) {
    std::vector<float> exact(8 * kAroundPadded), sums(8 * kAroundPadded), parts(kAroundPadded, 1.f);
    ManyLamps many(low, dims);
    for (int i = 0; i < 64; ++i) {
      kernels::Lamp lamp;
      lamp.direction = kernels::normalize(
          kernels::Float3(std::sin(1.7f * float(i)), std::cos(2.3f * float(i)), std::sin(3.1f * float(i)) + .1f));
      lamp.strength = {1, 2, 3};
      lamp.attenuation = {.01f, .005f, .02f};
      lamp.clear = false;
      lamp.box = kernels::Float3(dims);
      ASSERT_TRUE(ManyLamps::takes(lamp));
      many.add(lamp);
      laneSet("").lightAround(lamp, {low.x - 1, low.y - 1, low.z - 1}, dims, parts.data(), exact.data());
    }
    many.spread(sums.data());
    for (int k = 0; k < 8 * kAroundVoxels; ++k) ASSERT_NEAR(sums[k], exact[k], 64 * 3 * 1e-2) << k;
    double difference = 0, all = 0;
    for (int k = 0; k < 8 * kAroundVoxels; ++k) {
      difference += std::abs(sums[k] - exact[k]);
      all += std::abs(exact[k]);
    }
    EXPECT_LT(difference, 2e-3 * all);
  }
}

TEST(EnvironmentLight, WhatMakesNoSenseIsNamed) {
  const auto messageOf = [](const Light& light) {
    try {
      (void)partsOf(light);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  Background background;
  background.up = {0, 0, 0};
  EXPECT_EQ(messageOf(environment(background)), "lights[0]: environment.up: must be finite and not zero");
  background.up = {0, 0, 1};
  background.file = "sky.hdr";
  EXPECT_EQ(messageOf(environment(background)),
            "lights[0]: environment.file: is not read yet; set the image to what readEnvironment makes of it");
  background.file.clear();
  background.top[1] = -1;
  EXPECT_EQ(messageOf(environment(background)), "lights[0]: environment.top: must be finite and not negative");
  EXPECT_EQ(messageOf(environment({}, 2000)), "lights[0]: samples must be in 0 to 1024");
}

TEST(LightsByThemselves, AddUpToAllOfThem) {
  Ambient fog;
  fog.attenuation = {.4, .3, .5};
  fog.scattering = {.2, .3, .1};
  const std::vector<Body> ball{glassBall({.5, .5, .5}, .25, 1.4)};
  const Medium medium = buildMedium(ball, fog, unitCube(40));
  std::vector<Light> lights{sun({.2, .1, -1}, {3, 1, 2}), lamp({.4, .6, 2}, {2, 5, 1}),
                            environment({{.1, .2, .3}, {.5, .4, .3}}, 8)};
  PhotonOptions options;
  options.grid = {256, 256};
  const PhotonResult together = tracePhotons(medium, lights, {}, options);
  options.separate = true;
  const PhotonResult sum = tracePhotons(medium, lights, {}, options);
  ASSERT_EQ(sum.lights.size(), 3u);
  EXPECT_EQ(sum.lights[1].light, "light1");
  EXPECT_EQ(sum.balance.photonsTraced, together.balance.photonsTraced);
  EXPECT_NEAR(sum.balance.scattered[1] / together.balance.scattered[1], 1, 1e-6);
  double most = 0;
  forVoxels(sum.radiance, [&](const Vec3i& v) { most = std::max<double>(most, together.radiance.fluence(v)[1]); });
  forVoxels(sum.radiance, [&](const Vec3i& v) {
    const Vec3f a = together.radiance.fluence(v), b = sum.radiance.fluence(v), c = together.radiance.directFluence(v),
                d = sum.radiance.directFluence(v);
    float parts = 0;
    for (const PhotonResult& one : sum.lights) parts += one.radiance.fluence(v)[1];
    ASSERT_NEAR(b[1], parts, 1e-5 * most);
    // Summed in other units, and interpolated where there are many lamps.
    for (int i = 0; i < 3; ++i) ASSERT_NEAR(a[i], b[i], 1e-3 * most) << v[0] << ' ' << v[1] << ' ' << v[2];
    for (int i = 0; i < 3; ++i) ASSERT_NEAR(c[i], d[i], 1e-3 * most) << v[0] << ' ' << v[1] << ' ' << v[2];
  });
}

TEST(LightsByThemselves, HaveNamesThatFilesCanHold) {
  std::vector<Light> lights(3);
  lights[1].name = "Key light/1.x";
  EXPECT_EQ(lightLayers(lights), (std::vector<std::string>{"light0", "Key_light_1_x", "light2"}));
  lights[2].name = "light0";
  EXPECT_THROW((void)lightLayers(lights), Error);
  lights[2].name = "direct";
  EXPECT_THROW((void)lightLayers(lights), Error);
}

TEST(EnvironmentMap, RealOnesAreRead) {
  for (const char* name : {"StinsonBeach.hdr", "rooftop_small.hdr", "uffizi_latlong_128.exr", "StageEnvLatLong.exr"}) {
    const auto path = sharedPath("data/env/" + std::string(name));
    VOLCAUSTIC_NEED_SHARED(path);
    const auto map = readEnvironment(path);
    EXPECT_EQ(map->channels, (std::vector<std::string>{"R", "G", "B"}));
    Light light;
    light.type = LightType::Environment;
    light.environment.image = map;
    double power = 0;
    for (const LightPart& p : partsOf(light)) power += p.light.irradiance[1];
    EXPECT_GT(power, 0) << name;
  }
}

TEST(EnvironmentMap, NumbersThatAreNoneBecomeBlackWithAWarning) {
  const auto path = sharedPath("data/env/BrightRingsNanInf.exr");
  VOLCAUSTIC_NEED_SHARED(path);
  std::vector<std::string> lines;
  RunContext ctx;
  ctx.onLog = [&](LogLevel, std::string_view line) { lines.emplace_back(line); };
  const auto map = readEnvironment(path, ctx);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("negative or not finite"), std::string::npos) << lines[0];
  for (const auto& plane : map->planes)
    EXPECT_TRUE(std::all_of(plane.begin(), plane.end(), [](float v) { return v >= 0 && std::isfinite(v); }));
}

TEST(EnvironmentMap, DamagedOnesAreOneLine) {
  for (const char* name : {"crash-res.hdr", "invalid.exr"}) {
    const auto path = sharedPath("data/env_bad/" + std::string(name));
    VOLCAUSTIC_NEED_SHARED(path);
    try {
      (void)readEnvironment(path);
      FAIL() << name;
    } catch (const Error& e) {
      EXPECT_EQ(std::string(e.what()).find(path.string()), 0u) << e.what();
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  }
}

} // namespace
} // namespace volcaustic::test
