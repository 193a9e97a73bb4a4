// The way that a device builds a medium, taken by this machine: to the bit what the CPU's own way makes.
#include "volume/device_medium.h"
#include "backends/flat_pipeline.h"
#include "support/fields.h"
#include "support/host_machine.h"
#include "support/solids.h"
#include "volume/flatten.h"
#include "volume/medium_store.h"

#include <cstring>
#include <gtest/gtest.h>

namespace volcaustic::test {
namespace {

using Counted = CountedBody<HostMachine>;

Counted countedOn(HostMachine& machine, const Body& body, const Domain& domain, const VoxeliseOptions& options) {
  const CoveragePatch patch = voxeliseBody(body, domain, options.supersample, options.fill);
  const BodyCounts counts = countsOf(patch, options.supersample);
  return {counts.first,
          counts.bricks,
          counts.log2,
          machine.copyOf(counts.fills.data(), std::int64_t(counts.fills.size()), ""),
          machine.copyOf(counts.counted.data(), std::int64_t(counts.counted.size()), ""),
          machine.copyOf(counts.counts.data(), std::int64_t(counts.counts.size()), ""),
          pointOptics(body.material)};
}

struct Case {
  const char* name;
  Domain domain;
  Ambient ambient;
  std::vector<Body> bodies; ///< from low priority to high
  VoxeliseOptions voxelise;
  StepFieldOptions steps;
};

Body bodyOf(std::shared_ptr<const Mesh> mesh, double index, const Rgb& attenuation = {}, const Rgb& scattering = {},
            double asymmetry = 0) {
  Body body;
  body.mesh = std::move(mesh);
  body.material.index = index;
  body.material.attenuation = attenuation;
  body.material.scattering = scattering;
  body.material.asymmetry = asymmetry;
  return body;
}

std::vector<Case> cases() {
  const Domain odd{{0, 0, 0}, 1.0 / 61, {61, 45, 70}}, wide{{-.3, -.2, .1}, 1.0 / 64, {96, 64, 40}};
  const Domain tiny{{.3, .3, .3}, 1.0 / 40, {13, 9, 5}}, large{{0, 0, 0}, 1.0 / 150, {150, 150, 150}};
  Ambient fog;
  fog.index = 1.000293;
  fog.attenuation = {.5, .4, .3};
  fog.scattering = {.1, .1, .2};
  fog.asymmetry = .1;
  StepFieldOptions tight;
  tight.indexTolerance = tight.attenuationTolerance = 1e-5;
  StepFieldOptions none;
  none.indexTolerance = none.indexTolerance2 = none.attenuationTolerance = 0;
  const Body glass = bodyOf(ball({.5, .4, .5}, .3), 1.5, {2, 3, 4}, {1, 1, 2}, .4);
  const Body dye = bodyOf(ball({.8, .3, .9}, .2), 1.000293, {1, 5, 4}, {1, .5, 2}, .1);
  const Body liquid = bodyOf(ball({.5, .4, .5}, .24), 1.33, {.1, 0, 3}), bubble = bodyOf(ball({.55, .4, .45}, .07), 1);
  const Body clear = bodyOf(ball({.5, .4, .5}, .3), 1.5);
  const auto blurred = [](int blur, int supersample = 4) {
    VoxeliseOptions o;
    o.blur = blur;
    o.supersample = supersample;
    return o;
  };
  return {{"clear glass", odd, {}, {clear}, {}, {}},
          {"dye in fog", odd, fog, {glass, dye}, {}, {}},
          {"nested", wide, fog, {glass, liquid, bubble}, blurred(5, 2), tight},
          {"sharp", odd, {}, {glass, bubble}, blurred(1, 1), {}},
          {"widest blur", wide, fog, {glass, dye, liquid}, blurred(11, 8), {}},
          {"thin blur", wide, {}, {liquid, clear}, blurred(3), {}},
          {"no tolerance", odd, fog, {glass}, blurred(7), none},
          {"beyond the faces", tiny, fog, {glass, bubble}, {}, {}},
          {"nothing", odd, fog, {}, {}, {}},
          {"without a trace", odd, {}, {bodyOf(ball({.5, .4, .5}, .3), 1)}, {}, {}},
          {"large", large, fog, {glass, liquid}, {}, {}}};
}

class DeviceWay : public testing::TestWithParam<Case> {
protected:
  DeviceWay()
      : medium(buildMedium(GetParam().bodies, GetParam().ambient, GetParam().domain, GetParam().voxelise))
      , painted(machine, planOf(GetParam().domain, GetParam().ambient, GetParam().bodies, GetParam().voxelise.blur),
                counted()) {}

  std::vector<Counted> counted() {
    std::vector<Counted> all;
    for (const Body& b : GetParam().bodies)
      all.push_back(countedOn(machine, b, GetParam().domain, GetParam().voxelise));
    return all;
  }

  HostMachine machine;
  Medium medium;
  PaintedMedium<HostMachine> painted;
};

template <class T>
bool sameBits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

template <class T>
void expectSame(const BrickGrid<T>& expected, const BrickGrid<T>& found, const char* name) {
  ASSERT_EQ(expected.dims(), found.dims());
  for (int x = 0; x < expected.dims()[0]; ++x)
    for (int y = 0; y < expected.dims()[1]; ++y)
      for (int z = 0; z < expected.dims()[2]; ++z)
        ASSERT_TRUE(sameBits(expected.at(x, y, z), found.at(x, y, z))) << name << " at " << x << ' ' << y << ' ' << z;
  EXPECT_EQ(expected.activeBrickCount(), found.activeBrickCount()) << name;
}

TEST_P(DeviceWay, PaintsAndSmoothsTheSameGrids) {
  const OpticsBricks found = painted.download({});
  const std::shared_ptr<const OpticsBricks> expected = bricksOf(medium, {});
  expectSame(expected->index, found.index, "index");
  expectSame(expected->coverage, found.coverage, "coverage");
  ASSERT_EQ(expected->attenuation.has_value(), found.attenuation.has_value());
  ASSERT_EQ(expected->scattering.has_value(), found.scattering.has_value());
  ASSERT_EQ(expected->asymmetry.has_value(), found.asymmetry.has_value());
  if (found.attenuation) expectSame(*expected->attenuation, *found.attenuation, "attenuation");
  if (found.scattering) expectSame(*expected->scattering, *found.scattering, "scattering");
  if (found.asymmetry) expectSame(*expected->asymmetry, *found.asymmetry, "asymmetry");
}

TEST_P(DeviceWay, FlattensToTheSameArrays) {
  const StepFieldOptions& steps = GetParam().steps;
  const FlatMediumStorage expected = flattenMedium(medium, steps, {});
  const FlatOnMachine<HostMachine> flat(painted, stepRules(steps, GetParam().domain), static_cast<float>(steps.cap));
  const FlatMediumStorage found = flat.download({});
  const kernels::FlatMedium e = expected.view(), f = found.view();
  EXPECT_EQ(e.ambientIndex, f.ambientIndex);
  EXPECT_EQ(e.ambientStep, f.ambientStep);
  EXPECT_EQ(e.attenuates, f.attenuates);
  EXPECT_EQ(e.opticsCount, f.opticsCount);
  for (std::int64_t b = 0; b < e.brickCount(); ++b) {
    ASSERT_EQ(e.fieldSlots[b] > 0, f.fieldSlots[b] > 0) << b;
    ASSERT_TRUE(sameBits(e.indexOffsets[b], f.indexOffsets[b])) << b;
    ASSERT_EQ(e.stepSlots[b], f.stepSlots[b]) << b;
    ASSERT_EQ(e.bends[b], f.bends[b]) << b;
    if (e.fieldSlots[b] > 0) {
      ASSERT_EQ(std::memcmp(e.fields + std::ptrdiff_t{e.fieldSlots[b]} * kernels::kFieldVoxels,
                            f.fields + std::ptrdiff_t{f.fieldSlots[b]} * kernels::kFieldVoxels,
                            kernels::kFieldVoxels * sizeof(kernels::FieldVoxel)),
                0)
          << b;
    }
  }
  ASSERT_EQ(e.stepCount, f.stepCount);
  EXPECT_EQ(std::memcmp(e.steps, f.steps, static_cast<std::size_t>(e.stepCount)), 0);
  EXPECT_EQ(e.voxelOpticsCount, f.voxelOpticsCount);
  for (int x = 0; x < e.dims.x; ++x)
    for (int y = 0; y < e.dims.y; ++y)
      for (int z = 0; z < e.dims.z; ++z)
        ASSERT_TRUE(sameBits(e.opticsAt({x, y, z}), f.opticsAt({x, y, z}))) << x << ' ' << y << ' ' << z;
}

INSTANTIATE_TEST_SUITE_P(DeviceMedium, DeviceWay, testing::ValuesIn(cases()),
                         [](const testing::TestParamInfo<Case>& tested) {
                           std::string name = tested.param.name;
                           std::erase(name, ' ');
                           return name;
                         });

} // namespace
} // namespace volcaustic::test
