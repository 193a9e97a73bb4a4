// Volumes made by others in a medium: what their grids become at the domain's voxels, beside each other and under
// bodies.
#include "core/parallel.h"
#include "support/ray_tables.h"
#include "support/shared_data.h"
#include "support/solids.h"
#include "volcaustic/error.h"
#include "volcaustic/medium_volume.h"
#include "volcaustic/openvdb.h"
#include "volcaustic/scene.h"
#include "volcaustic/session.h"
#include "volume/flatten.h"

#include <cstring>
#include <functional>

namespace volcaustic::test {
namespace {

using ValueAt = std::function<float(const openvdb::Vec3d& world)>;

openvdb::math::Transform::Ptr cubes(double h, const openvdb::Vec3d& corner = openvdb::Vec3d(0)) {
  auto transform = openvdb::math::Transform::createLinearTransform(h);
  transform->postTranslate(corner);
  return transform;
}

/// A file of one grid of numbers, given at the centres of its voxels.
void writeGrid(const std::filesystem::path& path, const std::string& name, const openvdb::CoordBBox& box,
               const openvdb::math::Transform::Ptr& transform, float background, const ValueAt& value) {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(background);
  grid->setName(name);
  grid->setTransform(transform);
  auto voxels = grid->getAccessor();
  for (auto at = box.begin(); at; ++at) voxels.setValue(*at, value(transform->indexToWorld(*at)));
  openvdb::io::File(path.string()).write(openvdb::GridPtrVec{grid});
}

MediumVolume volumeOf(const std::filesystem::path& path, std::vector<PropertyGrid> properties) {
  std::vector<std::string> names;
  for (const PropertyGrid& p : properties) names.push_back(p.mapping.grid);
  return {readVolumeGrids(path, names), std::move(properties), kIdentity, "smoke"};
}

PropertyGrid property(OpticalProperty what, const std::string& grid, const Rgb& scale = {1, 1, 1},
                      const Rgb& offset = {0, 0, 0}) {
  return {what, {grid, scale, offset}};
}

Medium mediumOf(const std::vector<MediumVolume>& volumes, const Domain& domain, const Ambient& ambient = {},
                const std::vector<Body>& bodies = {}, const RunContext& ctx = {}) {
  VoxeliseOptions sharp;
  sharp.blur = 1;
  return buildMedium(bodies, volumes, ambient, domain, sharp, ctx);
}

std::string errorOf(const std::function<void()>& body, ErrorKind kind) {
  try {
    body();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}

class Volumes : public testing::Test {
protected:
  /// 20^3 voxels of 0.1 about the origin, in grid `density`: value(world) inside, 0 outside.
  std::filesystem::path smoke(const ValueAt& value, const std::string& name = "smoke.vdb") {
    writeGrid(mFolder / name, "density", {openvdb::Coord(-10), openvdb::Coord(9)}, cubes(.1, openvdb::Vec3d(.05)), 0,
              value);
    return mFolder / name;
  }
  TemporaryFolder mFolder;
};

Domain aroundOrigin(double half, int voxels) {
  return {{-half, -half, -half}, 2 * half / voxels, {voxels, voxels, voxels}};
}

/// Every voxel of a grid over a domain, at its centre.
template <class GridType, class Visit>
void forEachVoxel(const GridType& grid, const Domain& domain, const Visit& visit) {
  const auto voxels = grid.getConstAccessor();
  for (auto at = openvdb::CoordBBox({0, 0, 0}, {domain.dims[0] - 1, domain.dims[1] - 1, domain.dims[2] - 1}).begin();
       at; ++at)
    visit(grid.indexToWorld(*at), voxels.getValue(*at));
}

// A linear field is what trilinear interpolation keeps under any affine placement, at any resolution.
TEST_F(Volumes, AnyAffinePlacementKeepsALinearField) {
  const auto value = [](const openvdb::Vec3d& p) { return static_cast<float>(2 + p[0] + .5 * p[1] - .25 * p[2]); };
  MediumVolume volume = volumeOf(smoke(value), {property(OpticalProperty::Attenuation, "density", {1, 2, 3})});
  Placement placement;
  placement.rotate = {30, 40, 50};
  placement.scale = {1.5, -1, .8};
  placement.shear = {.2, 0, .1};
  placement.translate = {.3, .2, .1};
  const Affine m = volume.placement = affine(placement);
  const openvdb::Mat3R linear(m[0][0], m[0][1], m[0][2], m[1][0], m[1][1], m[1][2], m[2][0], m[2][1], m[2][2]);
  const openvdb::Mat3R back = linear.inverse();
  for (const int voxels : {24, 90}) { // coarser than the grid, and finer
    const Domain domain = aroundOrigin(1.7, voxels);
    int inside = 0;
    forEachVoxel(*mediumOf({volume}, domain).grids().attenuation, domain,
                 [&](const openvdb::Vec3d& world, const openvdb::Vec3s& found) {
                   const openvdb::Vec3d local = back * (world - openvdb::Vec3d(m[0][3], m[1][3], m[2][3]));
                   const double margin = voxels == 24 ? .2 : .06;
                   if (std::max({std::abs(local[0]), std::abs(local[1]), std::abs(local[2])}) < 1 - margin) {
                     ASSERT_NEAR(found[1], 2 * value(local), 2e-5);
                     ASSERT_NEAR(found[2], 3 * value(local), 3e-5);
                     ++inside;
                   } else if (std::max({std::abs(local[0]), std::abs(local[1]), std::abs(local[2])}) > 1 + margin) {
                     ASSERT_EQ(found, openvdb::Vec3s(0));
                   }
                 });
    EXPECT_GT(inside, voxels * voxels * voxels / 40);
  }
}

// What has voxels much smaller than the domain's is averaged, not picked from: nothing of it gets lost.
TEST_F(Volumes, FineVoxelsAreAveraged) {
  const auto speckled = [](const openvdb::Vec3d& p) {
    const auto i =
        static_cast<int>(std::lround(std::floor(p[0] * 10) + 3 * std::floor(p[1] * 10) + 7 * std::floor(p[2] * 10)));
    return i % 5 == 0 ? 5.0f : 0.0f;
  };
  const Domain domain = aroundOrigin(1.6, 8);
  const Medium medium =
      mediumOf({volumeOf(smoke(speckled), {property(OpticalProperty::Attenuation, "density")})}, domain);
  double expected = 0, found = 0;
  for (auto at = openvdb::CoordBBox(openvdb::Coord(-10), openvdb::Coord(9)).begin(); at; ++at)
    expected += speckled(cubes(.1, openvdb::Vec3d(.05))->indexToWorld(*at)) * .001;
  forEachVoxel(*medium.grids().attenuation, domain,
               [&](const openvdb::Vec3d&, const openvdb::Vec3s& v) { found += v[0] * .4 * .4 * .4; });
  EXPECT_NEAR(found, expected, .01 * expected);
}

TEST_F(Volumes, ExtinctionsAddIndicesDifferAndAsymmetryIsWeighted) {
  Ambient ambient;
  ambient.index = 1.1;
  ambient.attenuation = {.3, .3, .3};
  ambient.scattering = {.2, .2, .2};
  ambient.asymmetry = .8;
  const auto path = smoke([](const openvdb::Vec3d&) { return 2.0f; });
  const auto one = volumeOf(path, {property(OpticalProperty::Index, "density", {.02, 0, 0}, {1.1, 0, 0}),
                                   property(OpticalProperty::Attenuation, "density", {.5, .6, .7}),
                                   property(OpticalProperty::Scattering, "density", {.4, .4, .4}),
                                   property(OpticalProperty::Asymmetry, "density", {0, 0, 0}, {-.4, 0, 0})});
  const auto two = volumeOf(path, {property(OpticalProperty::Index, "density", {.05, 0, 0}, {1.1, 0, 0}),
                                   property(OpticalProperty::Scattering, "density", {.1, .1, .1})}); // absorbs nothing
  const Domain domain = aroundOrigin(2, 40);
  const MediumGrids grids = mediumOf({one, two}, domain, ambient).grids();
  const auto middle = openvdb::Coord(20), outside = openvdb::Coord(1);
  EXPECT_FLOAT_EQ(grids.index->tree().getValue(middle), 1.1f + .04f + .1f);
  EXPECT_TRUE(
      grids.attenuation->tree().getValue(middle).eq({.3f + 1 + .2f, .3f + 1.2f + .2f, .3f + 1.4f + .2f}, 1e-6f));
  EXPECT_TRUE(grids.scattering->tree().getValue(middle).eq(openvdb::Vec3s(.2f + .8f + .2f), 1e-6f));
  EXPECT_FLOAT_EQ(grids.asymmetry->tree().getValue(middle), (.2f * .8f + .8f * -.4f + .2f * .8f) / 1.2f);
  EXPECT_FLOAT_EQ(grids.index->tree().getValue(outside), 1.1f);
  EXPECT_EQ(grids.attenuation->tree().getValue(outside), openvdb::Vec3s(.3f));
  EXPECT_FLOAT_EQ(grids.asymmetry->tree().getValue(outside), .8f);
}

// The mapped background goes on beyond the grid: no step where the file happens to end.
TEST_F(Volumes, ABackgroundGoesOnBeyondTheGrid) {
  const auto warm = [](const openvdb::Vec3d& p) {
    return static_cast<float>(300 + 20 * std::max(0.0, 1 - p.length()));
  };
  writeGrid(mFolder / "warm.vdb", "temperature", {openvdb::Coord(-10), openvdb::Coord(9)},
            cubes(.1, openvdb::Vec3d(.05)), 300, warm);
  const auto volume =
      volumeOf(mFolder / "warm.vdb", {property(OpticalProperty::Index, "temperature", {-1e-3, 0, 0}, {1.5, 0, 0})});
  const Domain domain = aroundOrigin(3, 48);
  const MediumGrids grids = mediumOf({volume}, domain).grids();
  forEachVoxel(*grids.index, domain, [&](const openvdb::Vec3d& world, float n) {
    ASSERT_NEAR(n, 1.5 - 1e-3 * warm(world), 4e-4);
    if (world.length() > 1.3) {
      ASSERT_FLOAT_EQ(n, 1.2f);
    }
  });
  EXPECT_EQ(grids.attenuation->activeVoxelCount(), 0u) << "nothing says that it attenuates";
}

TEST_F(Volumes, BodiesTakeThePlaceOfSmoke) {
  const auto volume =
      volumeOf(smoke([](const openvdb::Vec3d&) { return 3.0f; }), {property(OpticalProperty::Attenuation, "density")});
  const Domain domain = aroundOrigin(.8, 40);
  Material clear;
  clear.index = 1.5;
  const MediumGrids grids = mediumOf({volume}, domain, {}, {{ball({0, 0, 0}, .5), clear, 0, "ball"}}).grids();
  forEachVoxel(*grids.attenuation, domain, [&](const openvdb::Vec3d& world, const openvdb::Vec3s& attenuation) {
    const float c = grids.coverage->tree().getValue(openvdb::Coord::round(grids.coverage->worldToIndex(world)));
    ASSERT_NEAR(attenuation[0], 3 * (1 - c), 1e-5) << "the glass is clear";
  });
}

TEST_F(Volumes, TheNumberOfThreadsChangesNoBit) {
  const auto wavy = [](const openvdb::Vec3d& p) {
    return static_cast<float>(1 + std::sin(9 * p[0] + 5 * p[1] * p[2]));
  };
  const auto volume = volumeOf(smoke(wavy), {property(OpticalProperty::Scattering, "density"),
                                             property(OpticalProperty::Index, "density", {.01, 0, 0}, {1, 0, 0})});
  const Domain domain = aroundOrigin(1.2, 80);
  const auto flat = [&](int threads) {
    RunContext ctx;
    ctx.threads = threads;
    return flattenMedium(mediumOf({volume}, domain, {}, {}, ctx), {}, ctx);
  };
  const FlatMediumStorage one = flat(1), two = flat(2);
  ASSERT_EQ(one.optics.size(), two.optics.size());
  EXPECT_EQ(std::memcmp(one.optics.data(), two.optics.data(), one.optics.size() * sizeof one.optics[0]), 0);
  ASSERT_EQ(one.voxelOptics.size(), two.voxelOptics.size());
  EXPECT_TRUE(std::equal(one.voxelOptics.begin(), one.voxelOptics.end(), two.voxelOptics.begin()));
  ASSERT_EQ(one.fields.size(), two.fields.size());
  EXPECT_EQ(std::memcmp(one.fields.data(), two.fields.data(), one.fields.size() * sizeof one.fields[0]), 0);

  // More than 2^17 optics are rounded to 11 bits, and none of them by more than half of the last.
  ASSERT_LE(one.optics.size(), std::size_t{1} << 17);
  ASSERT_GT(one.optics.size(), 1000u);
  const MediumGrids grids = mediumOf({volume}, domain).grids();
  const kernels::FlatMedium view = one.view();
  const auto h = static_cast<float>(domain.voxelSize);
  for (int x = 0; x < 80; ++x)
    for (int y = 0; y < 80; ++y)
      for (int z = 0; z < 80; ++z) {
        const float exact = grids.attenuation->tree().getValue({x, y, z})[0];
        ASSERT_NEAR(view.opticsAt({x, y, z}).attenuation.x / h, exact, exact / 4096 * 1.001f);
      }
}

TEST_F(Volumes, WhatCannotBeIsOneLine) {
  const auto path = smoke([](const openvdb::Vec3d& p) { return static_cast<float>(p[0]); });
  const Domain domain = aroundOrigin(1, 16);
  const std::string absent = errorOf([&] { readVolumeGrids(path, {"heat"}); }, ErrorKind::Input);
  EXPECT_NE(absent.find("'heat'"), std::string::npos);
  EXPECT_NE(absent.find("density (Tree_float"), std::string::npos) << absent;
  const auto build = [&](std::vector<PropertyGrid> properties) {
    return [&, properties] { mediumOf({volumeOf(path, properties)}, domain); };
  };
  using enum OpticalProperty;
  const auto starts = [](const std::string& line) { EXPECT_TRUE(line.starts_with("smoke: ")) << line; };
  starts(errorOf(build({property(Index, "density")}), ErrorKind::Input));
  starts(
      errorOf(build({property(Attenuation, "density"), property(Scattering, "density", {2, 1, 1})}), ErrorKind::Input));
  starts(errorOf(build({property(Asymmetry, "density")}), ErrorKind::Usage));
  starts(errorOf(build({property(Attenuation, "density"), property(Attenuation, "density")}), ErrorKind::Usage));
  starts(errorOf(build({property(Attenuation, "density", {1, 1, std::nan("")})}), ErrorKind::Usage));
  starts(errorOf(build({}), ErrorKind::Usage));
  MediumVolume flat = volumeOf(path, {property(Attenuation, "density")});
  flat.placement[2] = {0, 0, 0, 0};
  starts(errorOf([&] { mediumOf({flat}, domain); }, ErrorKind::Usage));

  RunContext small;
  small.memoryLimit = 1 << 20;
  flat.placement = kIdentity;
  errorOf([&] { mediumOf({flat}, aroundOrigin(1, 256), {}, {}, small); }, ErrorKind::Input);

  std::vector<std::string> warnings;
  RunContext ctx;
  ctx.onLog = [&](LogLevel level, std::string_view line) {
    if (level == LogLevel::Warning) warnings.emplace_back(line);
  };
  mediumOf({flat}, domain, {}, {}, ctx); // half of it is below zero
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("clamped"), std::string::npos);
}

TEST_F(Volumes, ASceneFindsItsBoxAndRunsAgainWhenSomethingChanges) {
  smoke([](const openvdb::Vec3d&) { return 1.0f; });
  const std::string text = R"({"volcaustic": 1, "volume": {"margin": 0, "resolution": 30}, "materials": {},
    "objects": [{"volume": "smoke.vdb", "scale": [2, 2, 2], "translate": [5, 0, 0],
                 "grids": [{"name": "density", "property": "attenuation", "scale": [3, 2, 1]}]}]})";
  const Scene scene = parseScene(text, mFolder / "scene.json");
  Session session(scene);
  const Domain domain = session.medium().domain();
  EXPECT_NEAR(domain.minCorner[0], 3, 1e-6);
  EXPECT_NEAR(domain.maxCorner()[0], 7, 1e-6);
  EXPECT_EQ(session.medium().grids().attenuation->tree().getValue(openvdb::Coord(15)), openvdb::Vec3s(3, 2, 1));
  EXPECT_EQ(sceneToJson(parseScene(sceneToJson(scene), "x.json")), sceneToJson(scene));

  const auto runsAfter = [&](const std::function<void(Scene&)>& change) {
    Scene changed = session.scene();
    change(changed);
    session.setScene(changed);
    session.medium();
    return session.runs().size();
  };
  const std::size_t first = session.runs().size();
  EXPECT_EQ(runsAfter([](Scene&) {}), first);
  EXPECT_EQ(runsAfter([](Scene& s) { s.objects[0].grids[0].mapping.scale[0] = 4; }), first + 1);
  EXPECT_EQ(runsAfter([](Scene& s) { s.objects[0].placement.translate[0] = 4; }), first + 2);
  EXPECT_EQ(session.medium().grids().attenuation->tree().getValue(openvdb::Coord(15))[0], 4);
}

// A simulation's first frame may hold no smoke yet.
TEST_F(Volumes, AnEmptyGridIsItsBackground) {
  writeGrid(mFolder / "none.vdb", "density", {}, cubes(.1), .5f, {});
  const auto volume = volumeOf(mFolder / "none.vdb", {property(OpticalProperty::Attenuation, "density")});
  EXPECT_FALSE(bounds(*volume.grids));
  const auto smoky =
      volumeOf(smoke([](const openvdb::Vec3d&) { return 2.0f; }), {property(OpticalProperty::Attenuation, "density")});
  const MediumGrids grids = mediumOf({volume, smoky}, aroundOrigin(2, 40)).grids();
  EXPECT_EQ(grids.attenuation->tree().getValue(openvdb::Coord(1)), openvdb::Vec3s(.5f));
  EXPECT_EQ(grids.attenuation->tree().getValue(openvdb::Coord(20)), openvdb::Vec3s(2.5f));
}

TEST_F(Volumes, LightFadesInSmokeAsBeerAndLambertSay) {
  smoke([](const openvdb::Vec3d&) { return 1.0f; }); // 2 thick, soft edges included
  const std::string text = R"({"volcaustic": 1,
    "volume": {"bounds": {"min": [-0.5, -0.5, -1.25], "max": [0.5, 0.5, 1.25]}, "resolution": 100},
    "objects": [{"volume": "smoke.vdb", "grids": [
      {"name": "density", "property": "attenuation", "scale": [0.2, 0.5, 1.2]},
      {"name": "density", "property": "scattering", "scale": [0.1, 0, 1.2]}]}],
    "lights": [{"direction": [0, 0, -1]}], "photons": {"grid": [32, 32]}})";
  Session session(parseScene(text, mFolder / "scene.json"));
  const EnergyBalance& balance = session.photons().balance;
  const Rgb optical{.4, 1, 2.4}, scattered{.5, 0, 1};
  for (int c = 0; c < 3; ++c) {
    const double lost = 1 - std::exp(-optical[c]);
    EXPECT_NEAR(balance.scattered[c] / balance.emitted[c], scattered[c] * lost, 2e-3) << c;
    EXPECT_NEAR(balance.absorbed[c] / balance.emitted[c], (1 - scattered[c]) * lost, 2e-3) << c;
  }
}

// Temperature on a lattice of its own, mapped to the index of the tables: rays turn back where they do in closed form.
TEST_F(Volumes, RaysThroughHotAirFollowTheTables) {
  for (const std::string name : {"mirage_linear", "mirage_exp"}) {
    const auto path = sharedPath("reference/analytic_" + name + ".csv");
    VOLCAUSTIC_NEED_SHARED(path);
    // 300 K where n is 1, 20 K warmer for each 0.01 of n below; twice as fine along z as across.
    const auto transform = openvdb::math::Transform::createLinearTransform(1);
    const double fine = 1 / 200.0;
    transform->preScale(openvdb::Vec3d(.1, .1, fine));
    const IndexField n = indexField(name);
    writeGrid(mFolder / (name + ".vdb"), "temperature", {{-2, -2, -8}, {12, 12, 208}}, transform, 300,
              [&](const openvdb::Vec3d& p) {
                return static_cast<float>(300 + 2000 * (1 - n({p[0], p[1], p[2]})));
              });
    const auto air = volumeOf(mFolder / (name + ".vdb"),
                              {property(OpticalProperty::Index, "temperature", {-5e-4, 0, 0}, {1.15, 0, 0})});
    const Table table = readCsv(path);
    auto rays = startsOf(table);
    constexpr int kVoxels = 96;
    traceRays(mediumOf({air}, unitCube(kVoxels)), rays);
    const ExitError e = rootMeanSquare(exitErrors(table, rays, n, kVoxels));
    std::printf("  %-14s position %.4f voxel rms, direction %.4f degrees rms\n", name.c_str(), e.position, e.direction);
    EXPECT_LE(e.position, .1) << name;
    EXPECT_LE(e.direction, .1) << name;
  }
}

} // namespace
} // namespace volcaustic::test
