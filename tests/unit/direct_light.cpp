// Direct light against its definition: whatever is stored, whatever is evaluated, and what is read between voxels.

#include "unit/direct_scene.h"

#include <functional>
#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {
namespace {

// Lamps stand beside the voxels' corners: a ray in a face would belong to either side.
const std::vector<Box> kBoxes{{{8, 10, 30}, {15, 22, 41}}, {{22, 5, 12}, {30.5, 16, 19}}, {{20, 30, 35}, {33, 37, 52}}};
constexpr Vec3i kDims{37, 50, 61};

struct NamedScene {
  const char* name;
  Vec3i dims;
  std::vector<Light> lights;
  int grid = 300;
  Rgb fog{0, 0, 0};
  bool jitter = false;

  [[nodiscard]] DirectScene make() const { return DirectScene(dims, kBoxes, lights, grid, fog, jitter); }
};
const NamedScene kScenes[] = {{"alongAnAxis", kDims, {sun({0, 0, -1})}},
                              {"alongAnAxisCoarse", {24, 40, 32}, {sun({0, -1, 0})}, 20},
                              {"slanted", kDims, {sun({.3, -.2, -1})}},
                              {"jittered", kDims, {sun({-.6, .5, .4})}, 300, {0, 0, 0}, true},
                              {"fog", kDims, {sun({.5, -.6, .7})}, 300, {.01, .03, .1}},
                              {"pointOutside", kDims, {lamp({90, 60, 80})}},
                              {"pointNearby", kDims, {lamp({18.3, 20.2, 64.1})}, 500},
                              {"pointInside", {70, 66, 64}, {lamp({38.3, 33.2, 30.6})}, 800, {.02, 0, .01}},
                              {"several",
                               {80, 70, 90},
                               {sun({.3, -.2, -1}), lamp({120, 60, 80}, {900, 9000, 5000}), lamp({5.3, 40.4, 20.2})},
                               700}};

class DirectField : public testing::TestWithParam<NamedScene> {};
INSTANTIATE_TEST_SUITE_P(Scenes, DirectField, testing::ValuesIn(kScenes),
                         [](const auto& scene) { return std::string(scene.param.name); });
void PrintTo(const NamedScene& scene, std::ostream* out) { *out << scene.name; }

// Voxels by the rays that cross them, smoothed where a shadow's edge is near. Where light is evaluated instead, the
// Gaussian would change it by no more than the lamp's own curvature does.
TEST_P(DirectField, IsWhatTheRaysOfEachVoxelSay) {
  const DirectScene scene = GetParam().make();
  const Values sharp = bruteForce(scene), smoothed = gaussian(scene, sharp);
  for (const bool smooth : {false, true}) {
    const auto direct = scene.direct(smooth);
    const kernels::DirectField field = direct->view();
    double off = 0, all = 0;
    int stored = 0, evaluated = 0;
    scene.forVoxels([&](const Int3& v) {
      double most = 0; // of the light here when nothing stands in the way
      for (const Light& light : scene.lights) {
        const Value open = openLight(scene, light, v);
        most += std::max({open[0], open[1], open[2]});
      }
      const bool isStored = field.stored.entries[field.stored.brickOf(v)] != 0;
      ++(isStored ? stored : evaluated);
      const Value& expected = (smooth && isStored ? smoothed : sharp)[scene.number(v)];
      for (int i = 0; i < 6 && smooth && !isStored; ++i)
        ASSERT_NEAR(smoothed[scene.number(v)][i], expected[i], changeByGaussian(scene, v))
            << v.x << ' ' << v.y << ' ' << v.z << " is near an edge";
      const kernels::Light got = field.at(v);
      for (int i = 0; i < 6; ++i) {
        const double value = i < 3 ? got.fluence[i] : got.towards[i - 3];
        // Rays' lengths are good to 1e-4, and a voxel that a face divides has a few dozen rays.
        ASSERT_NEAR(value, expected[i], 3e-3 * most) << v.x << ' ' << v.y << ' ' << v.z << " number " << i;
        off += std::abs(value - expected[i]);
        all += std::abs(expected[i]);
      }
    });
    EXPECT_LT(off, 2e-5 * all);
    EXPECT_GT(stored, 1000);
    EXPECT_GT(evaluated, 1000);
  }
}

// Bricks wholly in light are not stored, and neither are those wholly in shadow, but where they are neighbours.
TEST_P(DirectField, StoresEdgesOnly) {
  const DirectScene scene = GetParam().make();
  const auto direct = scene.direct(true), sharp = scene.direct(false);
  const kernels::DirectField field = direct->view();
  std::vector<std::vector<double>> parts(scene.lights.size());
  for (const DirectScene::Raster& raster : scene.rasters) {
    const std::vector<double> p = litParts(scene, raster);
    auto& all = parts[raster.light];
    all.resize(p.size());
    std::transform(all.begin(), all.end(), p.begin(), all.begin(), std::plus<>());
  }
  scene.forVoxels([&](const Int3& v) {
    const std::int64_t brick = field.stored.brickOf(v);
    if (!sharp->stored.isDark(brick)) {
      ASSERT_FALSE(direct->stored.isDark(brick)) << "an edge is stored when it is smoothed, too";
    }
    if (!direct->stored.isDark(brick)) return;
    Value expected{};
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
      const double part = parts[i][scene.number(v)];
      ASSERT_TRUE(part < 1e-9 || part > 1 - 1e-9) << part << " of a voxel's light is not an edge";
      const Value open = openLight(scene, scene.lights[i], v);
      for (int n = 0; n < 6 && part > .5; ++n) expected[n] += open[n];
    }
    const kernels::Light got = field.at(v);
    const double most = std::max({expected[0], expected[1], expected[2]});
    for (int c = 0; c < 3; ++c) {
      ASSERT_NEAR(got.fluence[c], expected[c], 1e-5 * most);
      ASSERT_NEAR(got.towards[c], expected[3 + c], 1e-5 * most);
    }
  });
}

// What the view pass reads: at voxel centres the voxels; across the faces of bricks, and where reading goes over from
// voxels to lamps half a voxel beside them, no step.
TEST_P(DirectField, SamplesAreContinuous) {
  const DirectScene scene = GetParam().make();
  const auto direct = scene.direct(true);
  const kernels::DirectField field = direct->view();
  const auto largest = [](const kernels::Light& l) { return kernels::maxComponent(l.fluence); };
  std::mt19937_64 random(6);
  std::uniform_real_distribution<float> u(0, 1);
  for (int i = 0; i < 300000; ++i) {
    float p[3];
    for (int a = 0; a < 3; ++a) p[a] = .5f + u(random) * static_cast<float>(scene.domain.dims[a] - 1);
    const Int3 v(static_cast<int>(p[0]), static_cast<int>(p[1]), static_cast<int>(p[2]));
    const kernels::Light centre = field.sample(Float3(v) + Float3(.5f)), voxel = field.at(v);
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(centre.fluence[c], voxel.fluence[c], 1e-5 * largest(voxel));

    const int axis = i % 3;
    const float face = std::round(p[axis] / 8) * 8;
    if (face == 0 || face + 1 > static_cast<float>(scene.domain.dims[axis])) continue;
    double nearest = 1e30; // lamp
    for (const Light& light : scene.lights)
      if (light.type == LightType::Point)
        nearest =
            std::min(nearest, std::hypot(p[0] - light.position[0], p[1] - light.position[1], p[2] - light.position[2]));
    if (nearest < 10) continue;
    for (const float at : {face, face - .5f, face + .5f}) {
      constexpr float kStep = 1e-3f;
      const auto sampleAt = [&](float along) {
        p[axis] = along;
        return field.sample({p[0], p[1], p[2]});
      };
      const kernels::Light low = sampleAt(at - kStep), high = sampleAt(at + kStep);
      // All of the light may go within two voxels, the Gaussian's edge; a lamp's curvature over a voxel is
      // 1/distance^2; and in fog the way to the box's faces has kinks where the nearest of them changes.
      const double kink = scene.flat.attenuates ? .05 : 0;
      const double most = std::max(largest(low), largest(high)) + 1e-6 * largest(field.at({0, 0, 0}));
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(low.fluence[c], high.fluence[c], (4 * kStep + 1 / (nearest * nearest) + kink) * most + 2 * kStep)
            << p[0] << ' ' << p[1] << ' ' << p[2];
    }
  }
}

TEST_P(DirectField, IsTheSameBitsOnAnyNumberOfThreads) {
  const DirectScene scene = GetParam().make();
  RunContext one, three;
  one.threads = 1;
  three.threads = 3;
  const auto a = scene.direct(true, one), b = scene.direct(true, three);
  scene.forVoxels([&](const Int3& v) {
    const kernels::Light x = a->view().at(v), y = b->view().at(v);
    for (int c = 0; c < 3; ++c) {
      ASSERT_EQ(x.fluence[c], y.fluence[c]);
      ASSERT_EQ(x.towards[c], y.towards[c]);
    }
  });
}

class DirectFieldInClearAir : public DirectField {};
INSTANTIATE_TEST_SUITE_P(Scenes, DirectFieldInClearAir, testing::ValuesIn([] {
                           std::vector<NamedScene> scenes(std::begin(kScenes), std::end(kScenes));
                           std::erase_if(scenes, [](const NamedScene& s) { return s.fog != Rgb{0, 0, 0}; });
                           return scenes;
                         }()),
                         [](const auto& scene) { return std::string(scene.param.name); });

// Power times the length of its straight way through the box, ray by ray, is fluence times volume, voxel by voxel.
TEST_P(DirectFieldInClearAir, KeepsTheEnergyOfItsRays) {
  const DirectScene scene = GetParam().make();
  Double3 rays(0, 0, 0), voxels(0, 0, 0);
  for (const DirectScene::Raster& r : scene.rasters)
    for (std::int64_t cell = 0; cell < r.frame.cells(); ++cell) {
      const kernels::EmissionRay ray = r.frame.ray(cell);
      const kernels::Span span = kernels::clipToBox(scene.flat.dims, ray.origin, ray.direction);
      const double from = r.frame.point ? std::max(span.entry, 0.0) : span.entry;
      const double to = std::min(span.exit, r.entry[cell] + r.frame.depth0);
      if (to > from) rays += r.frame.power(cell) * (to - from);
    }
  const auto direct = scene.direct(true);
  const kernels::DirectField field = direct->view();
  scene.forVoxels([&](const Int3& v) { voxels += Double3(field.at(v).fluence); });
  // Coarse rasters, and a lamp's nearest voxels, are known by their middles only.
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(voxels[c], rays[c], .01 * rays[c]) << "channel " << c;
}

// The six rasters around a lamp: every voxel once, so that a shell takes all that the lamp gives.
TEST(DirectLampInside, FacesAddUpWithoutGapOrOverlap) {
  for (const Vec3d& position : {Vec3d{32.1, 31.7, 32.4}, Vec3d{32, 32, 32}, Vec3d{30.5, 33.5, 31.5}}) {
    const DirectScene scene({64, 64, 64}, {}, {lamp(position, {3, 1, 2})}, 600);
    EXPECT_EQ(scene.rasters.size(), 6u);
    const auto direct = scene.direct(false);
    const kernels::DirectField field = direct->view();
    // A soft shell, r from 10 to 30: its volume sum is an integral to one part in a thousand.
    double shell = 0, weights = 0;
    const auto weight = [](double r) { return r > 10 && r < 30 ? 1 - std::cos((r - 10) / 20 * 2 * M_PI) : 0; };
    for (double r = 0; r < 40; r += 1e-3) weights += weight(r) * 1e-3;
    scene.forVoxels([&](const Int3& v) {
      const Value open = openLight(scene, scene.lights[0], v);
      const kernels::Light got = field.at(v);
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(got.fluence[c], open[c], 1e-5 * open[0]) << v.x << ' ' << v.y << ' ' << v.z;
        ASSERT_NEAR(got.towards[c], open[3 + c], 1e-5 * open[0]) << v.x << ' ' << v.y << ' ' << v.z;
      }
      const double r = std::hypot(v.x + .5 - position[0], v.y + .5 - position[1], v.z + .5 - position[2]);
      shell += got.fluence.x * weight(r);
    });
    EXPECT_NEAR(shell / weights, 3 * 4 * M_PI, 2e-3 * 3 * 4 * M_PI);
  }
}

TEST(DirectLights, AddUp) {
  const Light a = sun({.3, -.2, -1}), b = lamp({90, 60, 80}, {900, 9000, 5000}), c = lamp({5.3, 40.4, 20.2});
  const auto both = DirectScene(kDims, kBoxes, {a, b, c}), first = DirectScene(kDims, kBoxes, {a}),
             second = DirectScene(kDims, kBoxes, {b}), third = DirectScene(kDims, kBoxes, {c});
  const auto all = both.direct(true), one = first.direct(true), two = second.direct(true), three = third.direct(true);
  both.forVoxels([&](const Int3& v) {
    kernels::Light sum = one->view().at(v);
    sum += two->view().at(v);
    sum += three->view().at(v);
    const kernels::Light got = all->view().at(v);
    // A light is smoothed where any light's shadow has an edge.
    const double most = changeByGaussian(both, v);
    for (int n = 0; n < 3; ++n) {
      ASSERT_NEAR(got.fluence[n], sum.fluence[n], most);
      ASSERT_NEAR(got.towards[n], sum.towards[n], most);
    }
  });
}

TEST(DirectLights, NoneAreDark) {
  const DirectScene scene(kDims, kBoxes, {});
  const auto direct = scene.direct(true);
  const kernels::DirectField field = direct->view();
  scene.forVoxels([&](const Int3& v) {
    ASSERT_EQ(kernels::maxComponent(field.at(v).fluence), 0);
    ASSERT_EQ(kernels::maxComponent(field.sample(Float3(v)).fluence), 0);
  });
  for (std::int64_t b = 0; b < direct->stored.brickCount(); ++b) EXPECT_TRUE(direct->isConstant(b));
  const auto never = std::make_unique<DirectLight>(kDims); // of a volume that was read
  EXPECT_EQ(kernels::maxComponent(never->view().at({3, 4, 5}).fluence), 0);
}

TEST(DirectLights, BricksOfOneValueSaySo) {
  const DirectScene scene(kDims, kBoxes, {sun({.3, -.2, -1}), sun({-1, .2, .1})});
  const auto direct = scene.direct(true);
  const kernels::DirectField field = direct->view();
  int constant = 0;
  scene.forVoxels([&](const Int3& v) {
    if (!direct->isConstant(field.stored.brickOf(v))) return;
    ++constant;
    const Float3 a = field.at(v).fluence, b = field.at({v.x & ~7, v.y & ~7, v.z & ~7}).fluence;
    ASSERT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z);
  });
  EXPECT_GT(constant, 3000);
  const auto lit = DirectScene(kDims, {}, {lamp({90, 60, 80})}).direct(true);
  for (std::int64_t b = 0; b < lit->stored.brickCount(); ++b) EXPECT_FALSE(lit->isConstant(b)) << "falls with distance";
}

} // namespace
} // namespace volcaustic::test
