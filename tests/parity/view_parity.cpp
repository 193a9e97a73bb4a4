// The camera pass on a CUDA device against the CPU's reference, one ray at a time, for the same pictures.

#include "parity/gpu_required.h"
#include "support/fields.h"
#include "support/lights.h"
#include "support/solids.h"
#include "volcaustic/scene.h"
#include "volcaustic/view.h"

#include <cmath>
#include <gtest/gtest.h>

namespace volcaustic::test {
namespace {

struct ViewParity : testing::TestWithParam<double> {
  void SetUp() override { VOLCAUSTIC_NEED_GPU(); }

  /// A ball of glass in fog with asymmetry, a lamp beside it.
  static Medium medium(double asymmetry) {
    Ambient fog;
    fog.attenuation = {.4, .5, .6};
    fog.scattering = {.3, .3, .3};
    fog.asymmetry = asymmetry;
    Body body;
    body.mesh = ball({.5, .5, .55}, .3);
    body.material.index = 1.5;
    body.material.attenuation = {.2, 2, 4};
    body.material.scattering = {.1, .2, .3};
    return buildMedium(std::span(&body, 1), fog, unitCube(64));
  }
  static ViewResult look(const Medium& m, const RadianceVolume& light, const char* device, const ViewOptions& options,
                         const LitReceivers& receivers = {}) {
    Camera camera;
    camera.position = {.3, -2, .9};
    camera.target = {.5, .5, .5};
    camera.fieldOfView = 30;
    camera.resolution = {131, 97};
    RunContext ctx;
    ctx.device = device;
    return renderView(m, light, camera, {}, {}, options, ctx, {}, receivers);
  }
};

// Device and host round differently, and a ray that grazes the ball magnifies that; all others agree.
TEST_P(ViewParity, PicturesAgreeWithTheReference) {
  const Medium m = medium(GetParam());
  const Light lights[] = {lamp({.1, .2, .9}, {3, 2, 1}), sun({.2, .1, -1})};
  const RadianceVolume light = tracePhotons(m, lights).radiance;
  ViewOptions options;
  options.samples = 2;
  const ViewResult gpu = look(m, light, "cuda", options), cpu = look(m, light, "cpu:scalar", options);
  EXPECT_EQ(gpu.raysNotFinite, 0);
  EXPECT_EQ(gpu.samples, cpu.samples);
  EXPECT_NEAR(double(gpu.steps), double(cpu.steps), .02 * double(cpu.steps));
  for (const char* channel : {"R", "G", "B", "A", "caustic.G", "direct.G", "background.B", "transmittance.R"}) {
    const std::vector<float>&a = gpu.image.planes[gpu.image.find(channel)],
          &b = cpu.image.planes[cpu.image.find(channel)];
    double sum = 0, difference = 0;
    std::size_t beyond = 0;
    for (std::size_t i = 0; i < b.size(); ++i) {
      const double d = std::abs(double(a[i]) - b[i]);
      sum += std::abs(b[i]);
      difference += d;
      beyond += d > 1e-4 * std::abs(b[i]) + 1e-7;
    }
    EXPECT_LE(difference, 5e-4 * sum) << channel;
    EXPECT_LE(double(beyond), .03 * double(b.size())) << channel;
  }
}

TEST_P(ViewParity, RunsRepeatToTheBit) {
  const Medium m = medium(GetParam());
  const Light light = lamp({.1, .2, .9}, {3, 2, 1});
  const RadianceVolume volume = tracePhotons(m, std::span(&light, 1)).radiance;
  ViewOptions options;
  options.samples = 4;
  options.noise = .02;
  const ViewResult a = look(m, volume, "cuda", options), b = look(m, volume, "cuda", options);
  EXPECT_EQ(a.image.planes, b.image.planes);
  EXPECT_EQ(a.samples, b.samples);
}

// A floor that light falls on, inside the box and beyond it, seen directly, through the glass and in its reflections.
TEST_P(ViewParity, ReceiversAndReflectionsAgreeWithTheReference) {
  const Medium m = medium(GetParam());
  Placement place;
  place.translate = {.5, .5, .1};
  place.scale = {3, 3, 1};
  Receiver floor;
  floor.placement = affine(place);
  floor.resolution = 128;
  const Light light = sun({.2, .1, -1});
  PhotonOptions photons;
  photons.fresnel = true;
  const auto traced = [&](const char* device) {
    RunContext ctx;
    ctx.device = device;
    return tracePhotons(m, std::span(&light, 1), {}, photons, ctx, std::span(&floor, 1));
  };
  const PhotonResult gpu = traced("cuda"), cpu = traced("cpu:scalar");
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(gpu.balance.received[c], cpu.balance.received[c], 1e-3 * cpu.balance.received[c]);
    EXPECT_NEAR(gpu.balance.escaped[c], cpu.balance.escaped[c], 1e-3 * cpu.balance.received[c]);
  }
  const ReceiverMap mapA = gpu.receivers.maps().at(0), mapB = cpu.receivers.maps().at(0);
  const auto total = [](const ReceiverMap& map, const char* channel) {
    double sum = 0;
    for (const float v : map.image.planes[map.image.find(channel)]) sum += v;
    return sum;
  };
  for (const char* channel : {"direct.R", "caustic.G"})
    EXPECT_NEAR(total(mapA, channel), total(mapB, channel), 2e-3 * total(mapB, channel)) << channel;

  ViewOptions options;
  options.fresnel = true;
  const ViewResult a = look(m, cpu.radiance, "cuda", options, cpu.receivers),
                   b = look(m, cpu.radiance, "cpu:scalar", options, cpu.receivers);
  for (const char* channel : {"R", "G", "B", "receiver.G"}) {
    const std::vector<float>&p = a.image.planes[a.image.find(channel)], &q = b.image.planes[b.image.find(channel)];
    double sum = 0, difference = 0;
    for (std::size_t i = 0; i < q.size(); ++i) sum += std::abs(q[i]), difference += std::abs(p[i] - q[i]);
    EXPECT_LE(difference, 2e-3 * sum) << channel;
  }
}

INSTANTIATE_TEST_SUITE_P(Asymmetry, ViewParity, testing::Values(0.0, .6));

} // namespace
} // namespace volcaustic::test
