// Every instruction set sees what the reference sees, and its pictures do not depend on who renders what when.

#include "backends/view_tracer.h"
#include "support/fields.h"
#include "support/lights.h"
#include "support/solids.h"
#include "volcaustic/error.h"
#include "volcaustic/view.h"
#include "volume/flatten.h"
#include "volume/radiance_bricks.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

namespace volcaustic::test {
namespace {

constexpr double kPi = 3.14159265358979323846;
const Domain kBox{{0, 0, 0}, 1, {37, 50, 43}};

Camera cameraAt(const Vec3d& position, const Vec3d& target, const std::array<int, 2>& resolution = {67, 45}) {
  Camera c;
  c.position = position;
  c.target = target;
  c.fieldOfView = 55;
  c.resolution = resolution;
  return c;
}
const Camera kOutside = cameraAt({20, -45, 30}, {18, 25, 20});

Ambient fog(const Rgb& attenuation, const Rgb& scattering, double asymmetry = 0) {
  Ambient a;
  a.attenuation = attenuation;
  a.scattering = scattering;
  a.asymmetry = asymmetry;
  return a;
}

/// A ball that bends everywhere inside.
Medium lens(const Ambient& ambient) {
  return sampleMedium(kBox, ambient, [](const Vec3d& p) {
    const double r = distanceTo(p, 18, 24, 20) / 13;
    return r < 1 ? std::sqrt(2 - r * r) : 1.0;
  });
}
/// A ball of one index, of colours of its own.
Medium drop(const Ambient& ambient) {
  Body body;
  body.mesh = ball({18, 24, 20}, 12);
  body.material.index = 1.1;
  body.material.attenuation = {.05, .02, .2};
  body.material.scattering = {.03, .02, 0};
  body.material.asymmetry = .4;
  return buildMedium(std::span(&body, 1), ambient, kBox);
}

struct Scene {
  Medium medium;
  RadianceVolume light;

  Scene(const Medium& m, const std::vector<Light>& lights) : medium(m), light(trace(m, lights)) {}

private:
  static RadianceVolume trace(const Medium& m, const std::vector<Light>& lights) {
    PhotonOptions o;
    o.grid = {150, 150};
    RunContext ctx;
    ctx.device = "cpu:scalar";
    return tracePhotons(m, lights, {}, o, ctx).radiance;
  }
};

ViewResult look(const Scene& scene, const Camera& camera, const std::string& lanes, const ViewOptions& options = {},
                int threads = 0) {
  RunContext ctx;
  ctx.device = "cpu:" + lanes;
  ctx.threads = threads;
  return renderView(scene.medium, scene.light, camera, {}, {}, options, ctx);
}

class ViewLanes : public testing::TestWithParam<std::string> {};
class ViewLanesAndReference : public ViewLanes {};

/// Rounding decides in which of two cubes a ray on their common face is, and so how long its next step is, and in which
/// step it first meets a bend; a ray that grazes the ball magnifies that. So a few pixels differ, but all others agree
/// to rounding.
void expectSameAsScalar(const Scene& scene, const Camera& camera, const std::string& lanes,
                        const ViewOptions& options = {}) {
  const ViewResult a = look(scene, camera, lanes, options), reference = look(scene, camera, "scalar", options);
  EXPECT_EQ(a.raysNotFinite, 0);
  EXPECT_EQ(a.raysAtStepLimit, reference.raysAtStepLimit);
  EXPECT_NEAR(double(a.steps), double(reference.steps), 5e-2 * double(reference.steps));
  ASSERT_EQ(a.image.channels, reference.image.channels);
  for (std::size_t c = 0; c < reference.image.planes.size(); ++c) {
    if (reference.image.channels[c] == "steps.Y") continue;
    const std::vector<float>&x = a.image.planes[c], &y = reference.image.planes[c];
    ASSERT_EQ(x.size(), y.size());
    const bool depth = reference.image.channels[c] == "depth.Z";
    double sum = 0, difference = 0;
    std::size_t beyond = 0;
    for (std::size_t i = 0; i < y.size(); ++i) {
      if (!std::isfinite(x[i]) || !std::isfinite(y[i])) {
        ASSERT_TRUE(depth);
        beyond += std::isfinite(x[i]) != std::isfinite(y[i]);
        continue;
      }
      const double d = std::abs(double(x[i]) - y[i]);
      sum += std::abs(y[i]);
      difference += d;
      beyond += d > (depth ? 1.5 : 1e-4 * std::abs(y[i]) + 1e-7);
    }
    EXPECT_LE(double(beyond), .02 * double(y.size())) << reference.image.channels[c];
    EXPECT_LE(difference, (depth ? 2e-2 : 5e-4) * sum + 1e-9) << reference.image.channels[c];
  }
}

double total(const ViewResult& v, const char* channel) {
  double sum = 0;
  for (const float x : v.image.planes[v.image.find(channel)]) sum += x;
  return sum;
}

TEST_P(ViewLanesAndReference, SeeALensWithNothingAround) {
  const Scene scene(lens({}), {sun({.3, -.2, -1})});
  expectSameAsScalar(scene, kOutside, GetParam());
}

TEST_P(ViewLanesAndReference, SeeALensInFogsOfAllKinds) {
  for (const Ambient& ambient : {fog({.02, .05, .1}, {0, 0, 0}), fog({.02, .02, .02}, {.02, .02, .02}),
                                 fog({.01, .05, .3}, {.01, .03, .1}, .6), fog({2, 1, .5}, {1, 1, .5}, -.3)}) {
    SCOPED_TRACE(testing::Message() << ambient.attenuation[2] << ' ' << ambient.scattering[2]);
    const Scene scene(lens(ambient), {sun({.3, -.2, -1})});
    expectSameAsScalar(scene, kOutside, GetParam());
    EXPECT_EQ(total(look(scene, kOutside, GetParam()), "direct.G") > 0, ambient.scattering[1] > 0);
  }
}

TEST_P(ViewLanesAndReference, SeeColouredMatterUnderLampsInsideTheBoxAndOutside) {
  const Scene scene(drop(fog({.02, .02, .03}, {.01, .02, .02}, .3)), {lamp({5, 6, 38}), lamp({60, 20, 80})});
  expectSameAsScalar(scene, kOutside, GetParam());
  const ViewResult v = look(scene, kOutside, GetParam());
  EXPECT_GT(total(v, "caustic.R"), 0);
  EXPECT_GT(total(v, "direct.R"), 0);
  const Scene clear(drop({}), {lamp({5, 6, 38})});
  expectSameAsScalar(clear, kOutside, GetParam());
}

TEST_P(ViewLanesAndReference, SeeFromEverywhere) {
  const Scene scene(drop(fog({.02, .03, .04}, {.02, .01, .03})), {sun({.2, .1, -1})});
  for (const Camera& camera : {cameraAt({5, 5, 35}, {18, 24, 20}), cameraAt({18, 24, 20}, {30, 24, 21}),
                               cameraAt({18, 24, 200}, {18, 24.1, 0}), cameraAt({-60, 24.5, 20.5}, {18, 24.5, 20.5}),
                               cameraAt({-600, 900, 500}, {18, 24, 20})}) {
    SCOPED_TRACE(testing::Message() << camera.position[0] << ' ' << camera.position[1] << ' ' << camera.position[2]);
    expectSameAsScalar(scene, camera, GetParam());
  }
}

TEST_P(ViewLanesAndReference, SeeInAnyResolutionAndNumberOfSamples) {
  const Scene scene(lens(fog({.03, .03, .03}, {.02, .02, .02})), {sun({.2, .1, -1})});
  for (const std::array<int, 2>& resolution :
       {std::array<int, 2>{1, 1}, {1, 97}, {97, 1}, {5, 3}, {4, 4}, {33, 34}, {64, 32}}) {
    SCOPED_TRACE(testing::Message() << resolution[0] << 'x' << resolution[1]);
    Camera camera = kOutside;
    camera.resolution = resolution;
    expectSameAsScalar(scene, camera, GetParam());
    ViewOptions options;
    options.samples = 3;
    options.step = 1.7;
    expectSameAsScalar(scene, camera, GetParam(), options);
  }
}

TEST_P(ViewLanes, SeeOnlyTheBackgroundBesideTheBox) {
  const Scene scene(drop(fog({.02, .03, .04}, {.02, .01, .03})), {sun({.2, .1, -1})});
  const ViewResult v = look(scene, cameraAt({20, -45, 30}, {18, -100, 20}), GetParam());
  EXPECT_EQ(v.steps, 0);
  EXPECT_EQ(total(v, "A"), 0);
  EXPECT_EQ(total(v, "R"), total(v, "background.R"));
  for (const float z : v.image.planes[v.image.find("depth.Z")]) ASSERT_TRUE(std::isinf(z));
}

TEST_P(ViewLanes, CountEveryRayThatReachesTheStepLimit) {
  const Scene scene(lens(fog({.01, .01, .01}, {.01, .01, .01})), {sun({.2, .1, -1})});
  const Camera inside = cameraAt({18, 24, 40}, {18, 25, 5}, {31, 17});
  ViewOptions options;
  options.maxSteps = 2;
  const ViewResult v = look(scene, inside, GetParam(), options);
  EXPECT_EQ(v.raysAtStepLimit, 31 * 17);
  EXPECT_EQ(v.steps, 2 * 31 * 17);
}

// What no medium should hold, and a damaged file might: the rays that meet it end there, and others do not notice.
TEST_P(ViewLanes, CountRaysThatLeaveTheFiniteNumbers) {
  const Medium medium = lens({});
  FlatMediumStorage flat = flattenMedium(medium, {}, {});
  for (std::size_t i = kernels::kFieldVoxels; i < flat.fields.size(); ++i) // all but the ambient medium's
    flat.fields[i].gx = std::numeric_limits<float>::quiet_NaN();
  const RadianceBricks light(kBox.dims);
  const ViewTables tables(flat.view(), light.caustic.view(), light.direct.view(), laneSet(GetParam()), {});
  kernels::ViewScene scene{flat.view(), tables.light(), tables.plan(), {}, {}, {}, {}};
  scene.camera = {{18, -40, 20}, {-.5, 1, .5}, {1, 0, 0}, {0, 0, -1}, 41, 39};
  std::vector<float> numbers(std::size_t{kernels::kPixelPlanes} * 41 * 39);
  kernels::PixelPlanes planes;
  for (int i = 0; i < kernels::kPixelPlanes; ++i) planes.of[i] = &numbers[std::size_t(i) * 41 * 39];
  const std::vector<std::int32_t> tiles{0, 1, 2, 3};
  const auto count = [&](const std::string& lanes) {
    return makeCpuViewer(scene, planes, laneSet(lanes), {})->add({0, 1, tiles});
  };
  const ViewCounts counts = count(GetParam()), reference = count("scalar");
  EXPECT_GT(reference.notFinite, 100);
  EXPECT_LT(reference.notFinite, 41 * 39);
  EXPECT_NEAR(double(counts.notFinite), double(reference.notFinite), .03 * double(reference.notFinite));
  EXPECT_NEAR(double(counts.steps), double(reference.steps), .1 * double(reference.steps));
  for (const float v : numbers) ASSERT_FALSE(std::isnan(v));
}

// L = scattering fluence / (4 pi) (1 - exp(-t d)) / t along a way d; parallel light is not dimmed where the fog's own
// fluence is set by hand.
TEST_P(ViewLanes, SeeTheClosedFormInUniformFog) {
  const Domain domain = unitCube(64);
  const Ambient uniform = fog({2, 1, .5}, {1, 1, .5});
  auto light = std::make_shared<RadianceBricks>(domain.dims);
  FluenceGrid& caustic = light->caustic;
  for (std::int64_t b = 0; b < caustic.brickCount(); ++b)
    caustic.setConstant(b, {kernels::Float3(3, 4, 5), kernels::Float3(0, 0, 0)});
  Camera camera;
  camera.position = {-4, .5, .5};
  camera.target = {.5, .5, .5};
  camera.fieldOfView = 1;
  camera.resolution = {9, 9};
  RunContext ctx;
  ctx.device = "cpu:" + GetParam();
  const Background black{{0, 0, 0}, {0, 0, 0}};
  const Image image = renderView(buildMedium({}, uniform, domain), {domain, light}, camera, black, {}, {}, ctx).image;
  const char* names[] = {"caustic.R", "caustic.G", "caustic.B"};
  for (int c = 0; c < 3; ++c) {
    const double t = uniform.attenuation[c],
                 expected = uniform.scattering[c] * (3 + c) / (4 * kPi) * -std::expm1(-t) / t;
    EXPECT_NEAR(image.planes[image.find(names[c])][40], expected, 1e-4 * expected) << names[c];
  }
  EXPECT_NEAR(image.planes[image.find("transmittance.R")][40], std::exp(-2), 1e-5);
}

TEST_P(ViewLanes, GiveTheSameBitsOnAnyNumberOfThreads) {
  const Scene scene(drop(fog({.02, .03, .04}, {.02, .01, .03}, .2)), {sun({.2, .1, -1}), lamp({5, 6, 38})});
  Camera camera = kOutside;
  camera.resolution = {131, 97};
  const ViewResult one = look(scene, camera, GetParam(), {}, 1);
  for (const int threads : {2, 5}) {
    const ViewResult v = look(scene, camera, GetParam(), {}, threads);
    EXPECT_EQ(v.image.planes, one.image.planes);
    EXPECT_EQ(v.steps, one.steps);
  }
}

TEST(ViewDevice, IsRefusedWhereNobodyHasIt) {
  const Scene scene(lens({}), {sun({0, 0, -1})});
  EXPECT_THROW((void)look(scene, kOutside, "sse"), Error);
}

std::vector<std::string> names(int width) {
  std::vector<std::string> n;
  for (const LaneSet& set : laneSets())
    if (set.width >= width) n.emplace_back(set.name);
  return n;
}
const auto kName = [](const testing::TestParamInfo<std::string>& set) { return set.param; };
INSTANTIATE_TEST_SUITE_P(All, ViewLanes, testing::ValuesIn(names(1)), kName);
INSTANTIATE_TEST_SUITE_P(Wide, ViewLanesAndReference, testing::ValuesIn(names(2)), kName);

} // namespace
} // namespace volcaustic::test
