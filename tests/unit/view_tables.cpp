// What the camera's rays read: halves, light packed for them, and the plan of bricks.

#include "backends/view_tables.h"
#include "support/lights.h"
#include "support/solids.h"
#include "volcaustic/photons.h"
#include "volume/flatten.h"
#include "volume/radiance_bricks.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {
namespace {

using kernels::Float3;

TEST(HalfVoxels, KeepElevenBitsOfAnyNumberWithinTheirRange) {
  for (const float v : {0.0f, 1.0f, -1.0f, 0.5f, 2048.0f, 65504.0f, -0x1p-24f, 0x1p-14f, 3 * 0x1p-24f})
    EXPECT_EQ(kernels::floatOfHalf(kernels::halfOf(v)), v);
  EXPECT_EQ(kernels::floatOfHalf(kernels::halfOf(2049.0f)), 2048.0f); // of two, the even one
  EXPECT_EQ(kernels::floatOfHalf(kernels::halfOf(2051.0f)), 2052.0f);
  std::mt19937 random(1);
  for (int i = 0; i < 10000; ++i) {
    const float v = std::ldexp(std::uniform_real_distribution<float>(-1, 1)(random), int(random() % 28) - 12);
    ASSERT_NEAR(kernels::floatOfHalf(kernels::halfOf(v)), v, std::max(std::abs(v) * 0x1p-11f, 0x1p-25f));
  }
}

/// A body in fog in a box that no brick divides, under lamps inside and outside of it.
struct Lit {
  Medium medium;
  FlatMediumStorage flat;
  RadianceVolume light;

  explicit Lit(double asymmetry, bool inFog = true)
      : medium(make(asymmetry, inFog)), flat(flattenMedium(medium, {}, {})), light(trace(medium)) {}

private:
  static Medium make(double asymmetry, bool inFog) {
    Ambient fog;
    if (inFog) fog.attenuation = fog.scattering = {.02, .03, .04};
    fog.asymmetry = asymmetry;
    Body body;
    body.mesh = ball({18, 24, 20}, 9);
    body.material.index = 1.2;
    body.material.attenuation = body.material.scattering = {.05, .02, .2};
    return buildMedium(std::span(&body, 1), fog, {{0, 0, 0}, 1, {37, 50, 43}});
  }
  static RadianceVolume trace(const Medium& m) {
    const Light lights[] = {lamp({5, 6, 38}), sun({.2, .1, -1}), lamp({60, 20, 80})};
    PhotonOptions o;
    o.grid = {120, 120};
    return tracePhotons(m, lights, {}, o).radiance;
  }
};

class ViewTablesOf : public testing::TestWithParam<std::string> {};

TEST_P(ViewTablesOf, LightIsThatOfTheVolume) {
  const Lit scene(.3);
  const RadianceBricks& bricks = scene.light.bricks();
  const kernels::DirectField direct = bricks.direct.view();
  const kernels::FluenceField caustic = bricks.caustic.view();
  const ViewTables tables(scene.flat.view(), caustic, direct, laneSet(GetParam()), {});
  const kernels::ViewLight light = tables.light();
  std::mt19937 random(2);
  double causticSum = 0, directSum = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto along = [&](float dim) {
      const float c = std::uniform_real_distribution<float>(0, dim)(random);
      return i % 3 == 0 ? std::round(c) : i % 3 == 1 ? std::min(std::round(c) + .5f, dim) : c;
    };
    const Float3 p(along(37), along(50), along(43));
    const auto sample = light.sample<float>(p, true, true);
    const kernels::LightCellOf<float> cell(direct.stored.dims, p);
    const kernels::Light d = direct.sample<float>(p, cell, true, true), c = caustic.sample<float>(cell, true, true);
    // Of lamps between voxels, the volume has the exact value where the packed light may be between voxels.
    const float nearLamp = kernels::length(p - Float3(5, 6, 38)) < 12 ? 1.0f : 5e-3f;
    for (int a = 0; a < 3; ++a) {
      ASSERT_NEAR(sample.caustic[a], c.fluence[a], 1e-3 * kernels::maxComponent(c.fluence) + 1e-6)
          << p.x << ' ' << p.y << ' ' << p.z;
      ASSERT_NEAR(sample.direct[a], d.fluence[a], nearLamp * kernels::maxComponent(d.fluence) + 1e-6)
          << p.x << ' ' << p.y << ' ' << p.z;
      ASSERT_NEAR(sample.towards[a], d.towards[a] + c.towards[a],
                  nearLamp * kernels::luminance(d.fluence + c.fluence) + 1e-6);
    }
    causticSum += c.fluence.x;
    directSum += d.fluence.x;
  }
  EXPECT_GT(causticSum, 0);
  EXPECT_GT(directSum, 0);
}

TEST_P(ViewTablesOf, AreTheReferencesBricks) {
  const Lit scene(.3);
  const RadianceBricks& bricks = scene.light.bricks();
  const auto make = [&](const std::string& lanes) {
    return ViewTables(scene.flat.view(), bricks.caustic.view(), bricks.direct.view(), laneSet(lanes), {});
  };
  const ViewTables tables = make(GetParam()), reference = make("scalar");
  ASSERT_EQ(tables.lightVoxelCount(), reference.lightVoxelCount());
  const kernels::ViewLight a = tables.light(), b = reference.light();
  for (std::int64_t i = 0; i < tables.brickCount(); ++i) ASSERT_EQ(a.caustic.entries[i], b.caustic.entries[i]);
  std::int64_t others = 0;
  for (std::int64_t i = 0; i < tables.lightVoxelCount(); ++i)
    others += a.caustic.voxels[i].x != b.caustic.voxels[i].x; // lamps' exponentials differ in last places
  EXPECT_LT(double(others), .05 * double(tables.lightVoxelCount()));
}

TEST(ViewPlan, KeepsToWhatIsInAClearBox) {
  const Lit fog(0), clear(0, false);
  const auto make = [](const Lit& scene) {
    const RadianceBricks& bricks = scene.light.bricks();
    return ViewTables(scene.flat.view(), bricks.caustic.view(), bricks.direct.view(), laneSet(""), {});
  };
  const ViewTables inFog = make(fog), inClear = make(clear);
  EXPECT_EQ(inFog.plan().box.high.y, 50);
  EXPECT_EQ(inFog.light().towards.entries, nullptr) << "nothing has asymmetry";
  EXPECT_LT(inClear.plan().box.high.y, 50);
  EXPECT_LE(inClear.plan().box.low.y, 15 - 4);
  EXPECT_GE(inClear.plan().box.high.y, 33 + 4);
  EXPECT_LT(inClear.lightVoxelCount(), inFog.lightVoxelCount());
  // Nothing beside the body is worth a look there.
  EXPECT_EQ(inClear.plan().bricks[0], 0);
  EXPECT_NE(inFog.plan().bricks[0] & kernels::kPlanLit, 0);
}

std::vector<std::string> names() {
  std::vector<std::string> n;
  for (const LaneSet& set : laneSets()) n.emplace_back(set.name);
  return n;
}
INSTANTIATE_TEST_SUITE_P(All, ViewTablesOf, testing::ValuesIn(names()),
                         [](const testing::TestParamInfo<std::string>& set) { return set.param; });

} // namespace
} // namespace volcaustic::test
