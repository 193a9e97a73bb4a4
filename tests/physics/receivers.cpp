// Opaque diffuse surfaces in the photon pass and before the camera, against closed forms.

#include "support/csv.h"
#include "support/shared_data.h"
#include "support/tracing.h"
#include "volcaustic/scene.h"
#include "volcaustic/view.h"

#include <gtest/gtest.h>

namespace volcaustic::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A square of edge `size` at height z about the unit cube's axis, facing up.
Receiver floorAt(double z, double size, int resolution = 64) {
  Placement p;
  p.translate = {.5, .5, z};
  p.scale = {size, size, 1};
  Receiver floor;
  floor.name = "floor";
  floor.placement = affine(p);
  floor.albedo = {.5, .5, .5};
  floor.resolution = resolution;
  return floor;
}

PhotonResult trace(const Medium& medium, const Light& light, const std::vector<Receiver>& receivers, int photons = 256,
                   const RunContext& ctx = {}) {
  PhotonOptions options;
  options.grid = {photons, photons};
  options.smooth = false;
  return tracePhotons(medium, std::span(&light, 1), {}, options, ctx, receivers);
}

const std::vector<float>& plane(const Image& image, const char* channel) { return image.planes[image.find(channel)]; }

Camera lookingDown(int size = 33) {
  Camera c;
  c.position = {.5, .5, 6};
  c.target = {.5, .5, 0};
  c.up = {0, 1, 0};
  c.fieldOfView = 20;
  c.resolution = {size, size};
  return c;
}

// Lambert's cosine law inside the box, beyond it, and through fog: E cos(angle) exp(-attenuation * way in the box).
TEST(Receivers, FloorUnderTheSun) {
  Ambient fog;
  fog.attenuation = {.5, 1, 2};
  const Medium medium = buildMedium({}, fog, unitCube(32));
  Light sun;
  sun.irradiance = {1, 2, 3};
  sun.direction = {0, 0, -1};
  const PhotonResult result = trace(medium, sun, {floorAt(.25, 3)});
  const ReceiverMap map = result.receivers.maps().at(0);
  ASSERT_EQ(map.image.width, 64);
  const auto at = [&](const char* channel, double x, double y) {
    const int column = static_cast<int>((x - .5 + 1.5) / 3 * 64), row = static_cast<int>((.5 + 1.5 - y) / 3 * 64);
    return plane(map.image, channel)[static_cast<std::size_t>(row) * 64 + column];
  };
  EXPECT_NEAR(at("R", -.5, .5), 1, 1e-4); // beside the box
  EXPECT_NEAR(at("B", -.5, .5), 3, 1e-4);
  EXPECT_NEAR(at("R", .5, .5), std::exp(-.5 * .75), 1e-3);
  EXPECT_NEAR(at("B", .5, .5), 3 * std::exp(-2 * .75), 1e-3);
  EXPECT_EQ(at("caustic.R", .5, .5), 0);

  // The camera sees albedo E / pi, through the same fog.
  const Image image = renderView(medium, result.radiance, lookingDown(), {}, {}, {}, {}, {}, result.receivers).image;
  const std::size_t centre = 16 * 33 + 16;
  const double expected = .5 / kPi * std::exp(-2 * .5 * .75);
  EXPECT_NEAR(plane(image, "receiver.R")[centre], expected, 2e-3 * expected);
  EXPECT_NEAR(plane(image, "A")[centre], 1, 1e-6);
  EXPECT_NEAR(plane(image, "depth.Z")[centre], 5.75, 1e-3);

  sun.direction = {std::sqrt(.75), 0, -.5};
  const ReceiverMap slanted = trace(medium, sun, {floorAt(.25, 3)}).receivers.maps().at(0);
  EXPECT_NEAR(plane(slanted.image, "R")[5], .5, 1e-4);
}

TEST(Receivers, PointLightFallsOffWithDistanceAndCosine) {
  const Medium medium = buildMedium({}, {}, unitCube(16));
  Light lamp;
  lamp.type = LightType::Point;
  lamp.intensity = {2, 2, 2};
  for (const double height : {.6, 3.0}) { // inside the box, and above it
    lamp.position = {.5, .5, height};
    const ReceiverMap map = trace(medium, lamp, {floorAt(.1, 2)}, 64).receivers.maps().at(0);
    double worst = 0;
    for (int row = 0; row < 64; row += 7)
      for (int column = 0; column < 64; column += 7) {
        const double x = (column + .5) / 32 - 1, y = (row + .5) / 32 - 1, d = height - .1;
        const double expected = 2 * d / std::pow(x * x + y * y + d * d, 1.5);
        worst = std::max(worst, std::abs(plane(map.image, "R")[row * 64 + column] / expected - 1));
      }
    EXPECT_LT(worst, 5e-3) << height;
  }
}

// What a receiver takes does not light the volume behind it, and is accounted for.
TEST(Receivers, ShadowTheVolumeAndKeepTheBalance) {
  Ambient fog;
  fog.attenuation = fog.scattering = {.3, .3, .3};
  const Medium medium = buildMedium(std::vector{glassBall({.5, .5, .65}, .2, 1.5)}, fog, unitCube(64));
  const PhotonResult open = trace(medium, Light(), {}), result = trace(medium, Light(), {floorAt(.25, .6)});
  EXPECT_LT(result.balance.relativeImbalance(), 1e-5);
  for (int z : {2, 8, 14}) {
    EXPECT_EQ(result.radiance.fluence({32, 32, z})[0], 0);
    EXPECT_GT(open.radiance.fluence({32, 32, z})[0], .1);
    // Beside the floor.
    EXPECT_NEAR(result.radiance.directFluence({3, 3, z})[0], open.radiance.directFluence({3, 3, z})[0], 1e-4);
  }
  for (int z : {20, 40})
    EXPECT_NEAR(result.radiance.fluence({32, 32, z})[0], open.radiance.fluence({32, 32, z})[0], .02);
  // The map's power is what the balance says has landed, and what no longer escapes.
  const ReceiverMap map = result.receivers.maps().at(0);
  double landed = 0;
  for (const float e : plane(map.image, "R")) landed += e * .6 * .6 / (64 * 64);
  EXPECT_NEAR(landed, result.balance.received[0], 5e-3 * landed);
  EXPECT_LT(result.balance.escaped[0], open.balance.escaped[0] - .9 * landed);
  EXPECT_GT(result.balance.received[0], .2);
}

// Light that leaves the box lands on what is beyond it.
TEST(Receivers, CatchLightBeyondTheBox) {
  const Medium medium = buildMedium(std::vector{glassBall({.5, .5, .5}, .3, 1.2)}, {}, unitCube(64));
  const PhotonResult result = trace(medium, Light(), {floorAt(-1, 8, 128)});
  // n = 1.2 bends light by 67 degrees at most, but for a few rays that go round in the skin.
  EXPECT_GT(result.balance.received[0], .96);
  EXPECT_NEAR(result.balance.received[0] + result.balance.escaped[0], 1, 1e-5);
  const ReceiverMap map = result.receivers.maps().at(0);
  double landed = 0, caustic = 0;
  for (const float e : plane(map.image, "caustic.R")) caustic += e * 64.0 / (128 * 128);
  EXPECT_GT(caustic, kPi * .09); // a skin's outside bends light, too
  for (const float e : plane(map.image, "R")) landed += e * 64.0 / (128 * 128);
  EXPECT_NEAR(landed, 64, .02 * 64); // and all the light beside the box
}

/// Where a ray at distance b from the axis meets the plane at t behind the centre of a ball of n = 1.5.
class BallLens {
public:
  explicit BallLens(const Table& table) : mTable(table) {}
  /// Power of 1 W/m2 that comes into a disc around the axis, of the light that goes through the ball.
  [[nodiscard]] double powerInDisc(double radius, double t) const {
    double power = 0;
    const std::vector<double>& bs = mTable.at("b");
    for (std::size_t i = 0; i + 1 < bs.size(); ++i) {
      constexpr int kParts = 64; // the table is fine enough to be straight in between
      for (int k = 0; k < kParts; ++k) {
        const double u = (k + .5) / kParts, b = mix(i, u, "b");
        const double exit = mix(i, u, "r_exit_signed"), from = mix(i, u, "t_exit"),
                     crossing = mix(i, u, "t_axis_crossing");
        if (std::abs(exit * (crossing - t) / (crossing - from)) < radius)
          power += 2 * kPi * b * (bs[i + 1] - bs[i]) / kParts;
      }
    }
    return power;
  }

private:
  [[nodiscard]] double mix(std::size_t i, double u, const char* column) const {
    const std::vector<double>& values = mTable.at(column);
    return values[i] * (1 - u) + values[i + 1] * u;
  }
  const Table& mTable;
};

TEST(Receivers, BallLensFocusesAsTheClosedFormSays) {
  const auto path = sharedPath("reference/ball_sphere15_R0.3.csv");
  VOLCAUSTIC_NEED_SHARED(path);
  const Table table = readCsv(path);
  Body body = glassBall({.5, .5, .65}, .3, 1.5);
  body.mesh = ball({.5, .5, .65}, .3, 256);
  VoxeliseOptions sharp;
  sharp.supersample = 8;
  sharp.blur = 7;
  const Medium medium = buildMedium(std::span(&body, 1), {}, unitCube(256), sharp);
  constexpr double kAt = .4;
  const ReceiverMap map = trace(medium, Light(), {floorAt(.65 - kAt, .5, 512)}, 1024).receivers.maps().at(0);
  const auto& caustic = plane(map.image, "caustic.R");
  for (const double radius : {.01, .02, .05, .1, .2}) {
    double power = 0;
    for (int row = 0; row < 512; ++row)
      for (int column = 0; column < 512; ++column)
        if (std::hypot(column - 255.5, row - 255.5) * .5 / 512 < radius)
          power += caustic[row * 512 + column] * .25 / (512.0 * 512);
    const double expected = BallLens(table).powerInDisc(radius, kAt);
    std::printf("  disc %.3f: %.5f W, closed form %.5f\n", radius, power, expected);
    EXPECT_NEAR(power, expected, .05 * expected) << radius;
  }
}

TEST(Receivers, AreSeenThroughGlass) {
  const Medium slab = sampleMedium(unitCube(64), {}, [](const Vec3d& p) {
    return 1 + .25 * (std::erf((p[2] - .4) * 30) - std::erf((p[2] - .7) * 30));
  });
  const PhotonResult result = trace(slab, Light(), {floorAt(.1, 1.2)}, 512);
  const ReceiverMap map = result.receivers.maps().at(0);
  EXPECT_NEAR(plane(map.image, "R")[32 * 64 + 32], 1, .02); // all light comes through
  const Image image = renderView(slab, result.radiance, lookingDown(), {}, {}, {}, {}, {}, result.receivers).image;
  EXPECT_NEAR(plane(image, "receiver.G")[16 * 33 + 16], .5 / kPi, .02 * .5 / kPi);
}

// Furnace: a white floor under an even sky has E = pi L, and sends back the sky's own radiance: it cannot be seen.
TEST(Receivers, AWhiteFloorUnderAnEvenSkyCannotBeSeen) {
  const Medium medium = buildMedium({}, {}, unitCube(16));
  Light sky;
  sky.type = LightType::Environment;
  sky.environment.bottom = sky.environment.top = {2, 2, 2};
  sky.samples = 512;
  Receiver floor = floorAt(.5, 4);
  floor.albedo = {1, 1, 1};
  const PhotonResult result = trace(medium, sky, {floor}, 128);
  const ReceiverMap map = result.receivers.maps().at(0);
  EXPECT_NEAR(plane(map.image, "R")[32 * 64 + 32], 2 * kPi, .02 * 2 * kPi);
  const Image image =
      renderView(medium, result.radiance, lookingDown(9), sky.environment, {}, {}, {}, {}, result.receivers).image;
  EXPECT_NEAR(plane(image, "R")[40], 2, .04);
}

// A ball that stands on the floor: rays land in the midst of its skin, and reflected ones wait for them.
TEST(Receivers, RaysEndOnAFloorThatAReflectingBallStandsOn) {
  const Medium medium = buildMedium(std::vector{glassBall({.5, .5, .5}, .3, 1.5)}, {}, unitCube(64));
  const PhotonResult result = trace(medium, Light(), {floorAt(.2, 4)});
  Camera camera = lookingDown(48);
  camera.position = {.5, -3, 1.5};
  camera.target = {.5, .5, .4};
  camera.up = {0, 0, 1};
  ViewOptions options;
  options.fresnel = true;
  options.maxSteps = 4000;
  const ViewResult view = renderView(medium, result.radiance, camera, {}, {}, options, {}, {}, result.receivers);
  EXPECT_EQ(view.raysAtStepLimit, 0);
  EXPECT_EQ(view.raysNotFinite, 0);
  EXPECT_LT(view.steps, 48 * 48 * 200);
}

TEST(Receivers, BacksAreBlack) {
  const Medium medium = buildMedium({}, {}, unitCube(16));
  Receiver ceiling = floorAt(.5, 4);
  const PhotonResult result = trace(medium, Light(), {ceiling}, 32);
  Camera below = lookingDown(9);
  below.position = {.5, .5, -5};
  const Image image = renderView(medium, result.radiance, below, {}, {}, {}, {}, {}, result.receivers).image;
  for (const char* channel : {"R", "G", "B"}) EXPECT_EQ(plane(image, channel)[40], 0);
  EXPECT_EQ(plane(image, "A")[40], 1);
}

// A ball of plaster in the sun: its shadow is its disc, its map holds what that takes.
TEST(Receivers, MeshesCollectLightAndCastShadows) {
  const Medium medium = buildMedium({}, {}, unitCube(64));
  Receiver statue;
  statue.mesh = ball({.5, .5, .6}, .2, 48);
  statue.resolution = 512;
  const PhotonResult result = trace(medium, Light(), {statue, floorAt(.1, 1, 256)}, 512);
  double shadow = 0;
  const auto maps = result.receivers.maps();
  for (const float e : plane(maps.at(1).image, "R")) shadow += (1 - e) / (256.0 * 256);
  EXPECT_NEAR(shadow, kPi * .04, .01 * kPi * .04);
  EXPECT_NEAR(result.balance.received[0], 1, 1e-3);
  for (const int x : {34, 40}) {
    EXPECT_EQ(result.radiance.fluence({x, 32, 12})[0], 0);
    EXPECT_NEAR(result.radiance.fluence({x, 32, 60})[0], 1, 1e-4);
  }
  // From the sun, a Lambertian ball looks as the cosine.
  const Image image = renderView(medium, result.radiance, lookingDown(65), {}, {}, {}, {}, {}, result.receivers).image;
  const double perPixel = 2 * std::tan(10 * kPi / 180) / 65 * 5.25; // near the ball's front
  for (const int column : {32, 35, 38}) {
    const double sine = (column - 32) * perPixel / .2;
    const double expected = .8 / kPi * std::sqrt(1 - sine * sine);
    EXPECT_NEAR(plane(image, "R")[32 * 65 + column], expected, .03 * expected) << column;
  }
}

TEST(Receivers, InstructionSetsAgree) {
  Ambient fog;
  fog.attenuation = fog.scattering = {.3, .3, .3};
  const Medium medium = buildMedium(std::vector{glassBall({.5, .5, .6}, .25, 1.5)}, fog, unitCube(48));
  const auto run = [&](const std::string& device) {
    RunContext ctx;
    ctx.device = device;
    return trace(medium, Light(), {floorAt(.1, .7, 64)}, 256, ctx);
  };
  const PhotonResult reference = run("cpu:scalar"), lanes = run("cpu"); // the widest that this processor has
  const EnergyBalance &a = reference.balance, &b = lanes.balance;
  EXPECT_NEAR(a.received[0], b.received[0], 1e-4);
  EXPECT_NEAR(a.escaped[0], b.escaped[0], 1e-4);
  EXPECT_NEAR(a.scattered[0], b.scattered[0], 1e-4);
  const ReceiverMap mapA = reference.receivers.maps().at(0), mapB = lanes.receivers.maps().at(0);
  const auto &p = plane(mapA.image, "R"), &q = plane(mapB.image, "R");
  double difference = 0, sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) difference += std::abs(p[i] - q[i]), sum += p[i];
  EXPECT_LT(difference, .02 * sum);
}

TEST(Receivers, SameBitsForAnyNumberOfThreads) {
  const Medium medium = buildMedium(std::vector{glassBall({.5, .5, .6}, .25, 1.5)}, {}, unitCube(48));
  std::vector<ReceiverMap> maps;
  for (const int threads : {1, 2}) {
    RunContext ctx;
    ctx.threads = threads;
    maps.push_back(trace(medium, Light(), {floorAt(.1, 1, 128)}, 256, ctx).receivers.maps().at(0));
  }
  EXPECT_EQ(maps[0].image.planes, maps[1].image.planes);
}

} // namespace
} // namespace volcaustic::test
