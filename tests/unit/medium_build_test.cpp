// The whole way from bodies and functions to OpenVDB grids, and between grids and bricks.
#include "unit/voxelise_support.h"
#include "volcaustic/error.h"
#include "volcaustic/openvdb.h"
#include "volume/grids.h"

#include <gtest/gtest.h>
#include <set>

namespace volcaustic::test {
namespace {

TEST(DomainAround, CentresTheBoxAndCountsWholeVoxels) {
  const Domain d = domainAround({{-1, 2, 5}, {2, 3.5, 5.1}}, 30, 0, 3);
  EXPECT_DOUBLE_EQ(d.voxelSize, 0.1);
  EXPECT_EQ(d.dims, (Vec3i{36, 21, 7}));
  EXPECT_NEAR(d.minCorner[0], -1.3, 1e-12);
  EXPECT_NEAR(0.5 * (d.minCorner[2] + d.maxCorner()[2]), 5.05, 1e-12);
  const Domain sized = domainAround({{0, 0, 0}, {1, 1, 1}}, 256, 0.3, 0);
  EXPECT_EQ(sized.dims, (Vec3i{4, 4, 4}));
  EXPECT_DOUBLE_EQ(sized.minCorner[0], -0.1);
}

TEST(DomainAround, RefusesWhatIsNotABox) {
  const double inf = std::numeric_limits<double>::infinity(), max = std::numeric_limits<float>::max();
  const auto kindOf = [](const Box& b, int resolution = 10, double h = 0, int padding = 0) {
    try {
      domainAround(b, resolution, h, padding);
    } catch (const Error& e) {
      return e.kind();
    }
    return ErrorKind::Internal;
  };
  EXPECT_EQ(kindOf({{0, 0, 0}, {0, 0, 0}}), ErrorKind::Usage);
  EXPECT_EQ(kindOf({{1, 0, 0}, {0, 1, 1}}), ErrorKind::Usage);
  EXPECT_EQ(kindOf({{0, 0, 0}, {1, inf, 1}}), ErrorKind::Usage);
  EXPECT_EQ(kindOf({{-max, -max, -max}, {max, max, max}}), ErrorKind::Input);
  EXPECT_EQ(kindOf({{0, 0, 0}, {1, 1, 1}}, 40000), ErrorKind::Usage);
  EXPECT_EQ(kindOf({{0, 0, 0}, {1, 1, 1}}, 10, 1e-9), ErrorKind::Usage);
  EXPECT_EQ(kindOf({{0, 0, 0}, {1, 1, 1}}, 10, 0, -1), ErrorKind::Usage);
}

TEST(Grids, BricksSurviveTheRoundTripAndTilesStayTiles) {
  openvdb::initialize();
  const Domain domain{{1, 2, 3}, 0.5, {300, 20, 140}}; // more than one internal node, edges not whole bricks
  BrickGrid<float> bricks(domain.dims, 1.0f);
  for (std::int64_t b = 0; b < bricks.brickCount(); ++b) bricks.setConstant(b, b % 3 ? 1.5f : 1.0f);
  const std::int64_t varying = bricks.brickIndex({36, 1, 16});
  bricks.allocate(varying);
  for (int v = 0; v < kBrickVoxels; ++v) bricks.voxels(varying)[v] = float(v);
  const auto grid = toFloatGrid(bricks, domain, "index");
  EXPECT_EQ(grid->getName(), "index");
  EXPECT_EQ(grid->background(), 1.0f);
  EXPECT_EQ(grid->indexToWorld(openvdb::Vec3d(0, 0, 0)), openvdb::Vec3d(1.25, 2.25, 3.25));
  EXPECT_EQ(grid->tree().getValue({36 * 8 + 3, 8 + 2, 16 * 8 + 1}), float(brickOffset(3, 2, 1)));
  EXPECT_EQ(grid->tree().getValue({299, 20, 139}), 1.0f); // beyond dims
  EXPECT_FALSE(grid->tree().isValueOn({299, 20, 139}));
  for (const Vec3i& at : {Vec3i{299, 19, 139}, Vec3i{0, 0, 0}, Vec3i{8, 8, 8}, Vec3i{16, 0, 8}}) {
    const bool expected = bricks.at(at[0], at[1], at[2]) != 1.0f;
    EXPECT_EQ(grid->tree().isValueOn({at[0], at[1], at[2]}), expected);
  }
  const BrickGrid<float> back = fromFloatGrid(*grid, domain.dims);
  for (int x = 0; x < 300; ++x)
    for (int y = 0; y < 20; ++y)
      for (int z = 0; z < 140; ++z) ASSERT_EQ(back.at(x, y, z), bricks.at(x, y, z)) << x << ' ' << y << ' ' << z;
  EXPECT_EQ(back.activeBrickCount(), 1);
}

TEST(Grids, WholeNodesBecomeOneTile) {
  openvdb::initialize();
  const Domain domain = cubeDomain(256);
  BrickGrid<float> bricks(domain.dims, 1.0f);
  for (std::int64_t b = 0; b < bricks.brickCount(); ++b) {
    const Vec3i c = bricks.brickCoord(b);
    if (c[0] < 16 && c[1] < 16 && c[2] < 16) bricks.setConstant(b, 1.5f);
  }
  const auto grid = toFloatGrid(bricks, domain, "index");
  EXPECT_EQ(grid->tree().leafCount(), 0u);
  EXPECT_EQ(grid->tree().activeTileCount(), 1u);
  EXPECT_EQ(grid->activeVoxelCount(), 128u * 128 * 128);
}

TEST(Grids, VectorsKeepTheirComponents) {
  openvdb::initialize();
  const Domain domain = cubeDomain(24);
  BrickGrid<Vec3f> bricks(domain.dims, {1, 2, 3});
  const std::int64_t b = bricks.brickIndex({1, 2, 0});
  bricks.allocate(b)[brickOffset(5, 6, 7)] = {4, 5, 6};
  const auto grid = toVec3Grid(bricks, domain, "attenuation");
  EXPECT_EQ(grid->tree().getValue({13, 22, 7}), openvdb::Vec3s(4, 5, 6));
  const BrickGrid<Vec3f> back = fromVec3Grid(*grid, domain.dims);
  EXPECT_EQ(back.at(13, 22, 7), (Vec3f{4, 5, 6}));
  EXPECT_EQ(back.at(0, 0, 0), (Vec3f{1, 2, 3}));
  EXPECT_EQ(back.activeBrickCount(), 1);
}

TEST(BuildMedium, NamesVoxelsThatNoTransformHolds) {
  const Domain tiny{{0, 0, 0}, 2e-6, {8, 8, 8}};
  try {
    buildMedium({}, {}, tiny);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Usage);
    EXPECT_NE(std::string(e.what()).find("1.45e-5"), std::string::npos);
  }
  const Domain small{{0, 0, 0}, 1.5e-5, {8, 8, 8}};
  EXPECT_EQ(buildMedium({}, {}, small).grids().index->activeVoxelCount(), 0u);
}

TEST(BuildMedium, AGlassBallInFog) {
  Body ball = bodyOf(icosphere({0, 0, 0}, 1, 5));
  ball.material.index = 1.5;
  ball.material.attenuation = {0.5, 0.25, 0.125};
  Ambient fog;
  fog.attenuation = fog.scattering = {0.1, 0.1, 0.1};
  const Domain domain = domainAround({{-1, -1, -1}, {1, 1, 1}}, 60, 0, 10);
  std::set<std::string, std::less<>> stages;
  RunContext ctx;
  ctx.onProgress = [&](std::string_view stage, double fraction) {
    stages.emplace(stage);
    EXPECT_TRUE(fraction >= 0 && fraction <= 1);
  };
  const Medium medium = buildMedium(std::span(&ball, 1), fog, domain, {}, ctx);
  EXPECT_TRUE(stages.contains("voxelise") && stages.contains("blend") && stages.contains("blur"));
  const MediumGrids& g = medium.grids();
  const openvdb::Coord centre(40, 40, 40), corner(1, 1, 1);
  EXPECT_EQ(g.index->tree().getValue(centre), 1.5f);
  EXPECT_EQ(g.index->tree().getValue(corner), 1.0f);
  EXPECT_EQ(g.index->background(), 1.0f);
  EXPECT_EQ(g.attenuation->tree().getValue(centre), openvdb::Vec3s(0.5f, 0.25f, 0.125f));
  EXPECT_EQ(g.attenuation->background(), openvdb::Vec3s(0.1f));
  EXPECT_EQ(g.scattering->tree().getValue(centre), openvdb::Vec3s(0.0f));
  EXPECT_EQ(g.coverage->tree().getValue(centre), 1.0f);
  EXPECT_EQ(g.coverage->getGridClass(), openvdb::GRID_FOG_VOLUME);
  EXPECT_EQ(g.asymmetry, nullptr);
  double volume = 0;
  for (auto it = g.coverage->cbeginValueOn(); it; ++it) volume += *it * double(it.getVoxelCount());
  EXPECT_NEAR(volume * std::pow(domain.voxelSize, 3), signedVolume(*ball.mesh), 1e-3);
}

TEST(BuildMedium, PriorityDecidesWhateverTheOrder) {
  std::vector<Body> bodies{bodyOf(box({4, 4, 4}, {12, 12, 12}), 5), bodyOf(box({2, 2, 2}, {14, 14, 14}), -1)};
  bodies[0].material.index = 1.33;
  bodies[1].material.index = 1.5;
  VoxeliseOptions sharp;
  sharp.blur = 1;
  const auto indexAt = [&](int x) {
    return buildMedium(bodies, {}, cubeDomain(16), sharp).grids().index->tree().getValue({x, 8, 8});
  };
  EXPECT_EQ(indexAt(8), 1.33f);
  EXPECT_EQ(indexAt(3), 1.5f);
  std::swap(bodies[0], bodies[1]);
  EXPECT_EQ(indexAt(8), 1.33f);
  bodies[0].priority = bodies[1].priority; // now the later one wins, and that is still the liquid
  EXPECT_EQ(indexAt(8), 1.33f);
}

TEST(BuildMedium, RefusesBadOptionsAndKeepsToTheMemoryLimit) {
  const Body cube = bodyOf(box({1, 1, 1}, {5, 5, 5}));
  VoxeliseOptions options;
  options.supersample = 3;
  EXPECT_THROW(buildMedium(std::span(&cube, 1), {}, cubeDomain(8), options), Error);
  options = {};
  options.blur = 4;
  EXPECT_THROW(buildMedium(std::span(&cube, 1), {}, cubeDomain(8), options), Error);
  EXPECT_THROW(buildMedium(std::span(&cube, 1), {}, cubeDomain(0)), Error);
  RunContext small;
  small.memoryLimit = 1 << 20;
  EXPECT_THROW(buildMedium(std::span(&cube, 1), {}, cubeDomain(4096), {}, small), Error);
  std::atomic<bool> stop = true;
  RunContext cancelled;
  cancelled.cancel = &stop;
  try {
    buildMedium(std::span(&cube, 1), {}, cubeDomain(64), {}, cancelled);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Cancelled);
  }
}

TEST(BuildMedium, NoBodiesIsTheAmbientMedium) {
  Ambient water;
  water.index = 1.33;
  const Medium medium = buildMedium({}, water, cubeDomain(16));
  EXPECT_EQ(medium.grids().index->background(), 1.33f);
  EXPECT_EQ(medium.grids().index->activeVoxelCount(), 0u);
}

TEST(SampleMedium, SamplesVoxelCentresAndKeepsConstantsAsTiles) {
  const Domain domain{{-1, -1, -1}, 0.05, {40, 40, 37}};
  const auto lens = [](const Vec3d& p) {
    const double r2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    return r2 < 0.25 ? std::sqrt(2 - r2 / 0.25) : 1.0;
  };
  const Medium medium = sampleMedium(domain, {}, lens);
  const auto& index = *medium.grids().index;
  for (const Vec3i& at : {Vec3i{20, 20, 20}, Vec3i{12, 25, 18}, Vec3i{0, 0, 0}, Vec3i{39, 39, 36}}) {
    const openvdb::Vec3d p = index.indexToWorld(openvdb::Coord(at[0], at[1], at[2]));
    EXPECT_FLOAT_EQ(index.tree().getValue({at[0], at[1], at[2]}), float(lens({p[0], p[1], p[2]})));
  }
  EXPECT_LT(index.tree().leafCount(), 100u);
  EXPECT_EQ(medium.grids().coverage->activeVoxelCount(), 0u);
  EXPECT_THROW(sampleMedium(domain, {}, [](const Vec3d&) { return std::nan(""); }), Error);
}

TEST(MediumFromGrids, ChecksTransformsAndFillsIn) {
  const Domain domain = cubeDomain(16, 0.1);
  const Medium made = sampleMedium(domain, {}, [](const Vec3d& p) { return 1 + p[0]; });
  MediumGrids only;
  only.index = made.grids().index;
  Ambient fog;
  fog.attenuation = {0.5, 0.5, 0.5};
  const Medium medium = mediumFromGrids(domain, fog, only);
  EXPECT_EQ(medium.grids().attenuation->background(), openvdb::Vec3s(0.5f));
  EXPECT_EQ(medium.grids().coverage->background(), 0.0f);
  EXPECT_THROW(mediumFromGrids(cubeDomain(16, 0.2), fog, only), Error);
  EXPECT_THROW(mediumFromGrids(domain, fog, {}), Error);
}

} // namespace
} // namespace volcaustic::test
