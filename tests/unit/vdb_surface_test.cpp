#include "support/shared_data.h"
#include "unit/vdb_fixture.h"
#include "volcaustic/error.h"
#include "volcaustic/mesh.h"
#include "volcaustic/vdb.h"
#include "volume/sharpen_coverage.h"

#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/LevelSetUtil.h>

namespace volcaustic::test {
namespace {

constexpr double kRadius = 10, kVoxel = 0.5;

double signedVolume(const Mesh& mesh) {
  double six = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    six += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return six / 6;
}

openvdb::FloatGrid::Ptr ballLevelSet() {
  openvdb::initialize();
  auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(kRadius, openvdb::Vec3f(1, 2, 3), kVoxel);
  grid->setName("ball");
  return grid;
}

Mesh surfaceOfFile(const TemporaryFolder& folder, const openvdb::GridBase::Ptr& grid,
                   const SurfaceOptions& options = {}) {
  openvdb::io::File(folder / "grid.vdb").write(openvdb::GridPtrVec{grid});
  return surfaceFromVdb(folder / "grid.vdb", options);
}

TEST(Surface, FacesOutwardsForEveryKindOfGrid) {
  const TemporaryFolder folder;
  const double exact = 4.0 / 3 * M_PI * kRadius * kRadius * kRadius;
  const auto levelSet = ballLevelSet();
  EXPECT_NEAR(signedVolume(surfaceOfFile(folder, levelSet)), exact, 0.01 * exact);

  const auto fog = levelSet->deepCopy();
  openvdb::tools::sdfToFogVolume(*fog, 3 * float(kVoxel));
  EXPECT_NEAR(signedVolume(surfaceOfFile(folder, fog)), exact, 0.25 * exact); // the half-way value lies inside

  auto mask = openvdb::BoolGrid::create(false);
  auto counts = openvdb::Int32Grid::create(0);
  auto doubles = openvdb::DoubleGrid::create(0);
  for (const auto& grid : openvdb::GridPtrVec{mask, counts, doubles}) grid->setTransform(levelSet->transformPtr());
  for (auto value = fog->cbeginValueOn(); value; ++value)
    for (auto at = value.getBoundingBox().begin(); at; ++at) {
      mask->tree().setValueOn(*at, true);
      counts->tree().setValueOn(*at, 1);
      doubles->tree().setValueOn(*at, 1);
    }
  for (const auto& grid : openvdb::GridPtrVec{mask, counts, doubles})
    EXPECT_NEAR(signedVolume(surfaceOfFile(folder, grid)), exact, 0.05 * exact) << grid->type();

  const auto mirrored = levelSet->deepCopy();
  mirrored->transform().postScale(openvdb::Vec3d(-1, 1, 1));
  EXPECT_NEAR(signedVolume(surfaceOfFile(folder, mirrored)), exact, 0.01 * exact);
}

TEST(Surface, LiesOnTheBallAndIsClosed) {
  const TemporaryFolder folder;
  for (const double adaptivity : {0.0, 0.2}) {
    SurfaceOptions options;
    options.adaptivity = adaptivity;
    const Mesh mesh = surfaceOfFile(folder, ballLevelSet(), options);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& t : mesh.triangles)
      for (int e = 0; e < 3; ++e) ++edges[std::minmax(t[e], t[(e + 1) % 3])];
    for (const auto& [edge, faces] : edges) ASSERT_EQ(faces, 2) << "welded and closed";
    for (const Vec3d& p : mesh.positions)
      ASSERT_NEAR(std::hypot(p[0] - 1, p[1] - 2, p[2] - 3), kRadius, adaptivity > 0 ? 0.5 * kVoxel : 0.05 * kVoxel);
  }
}

TEST(Surface, KeepsItsPrecisionFarFromTheOrigin) {
  const TemporaryFolder folder;
  const auto grid = ballLevelSet();
  grid->transform().postTranslate(openvdb::Vec3d(1e6, 0, 0));
  double mean = 0;
  const Mesh mesh = surfaceOfFile(folder, grid);
  for (const Vec3d& p : mesh.positions) {
    ASSERT_NEAR(std::hypot(p[0] - 1e6 - 1, p[1] - 2, p[2] - 3), kRadius, 0.05 * kVoxel);
    mean += p[0];
  }
  EXPECT_NEAR(mean / double(mesh.positions.size()), 1e6 + 1, 1e-3);
}

TEST(Surface, OfAMediumIsItsHalfCoverage) {
  const double radius = 12 * ballDomain().voxelSize, exact = 4.0 / 3 * M_PI * radius * radius * radius;
  SurfaceOptions options;
  options.sharpen = false; // its coverage is a ramp along the normal, which no solid has
  EXPECT_NEAR(signedVolume(surfaceFromMedium(ballMedium(), options)), exact, 0.02 * exact);
}

TEST(Surface, IsTheSameWithOneAndTwoThreads) {
  const TemporaryFolder folder;
  writeVdb(folder / "m.vdb", ballMedium());
  RunContext one, two;
  one.threads = 1;
  two.threads = 2;
  const Mesh a = surfaceFromVdb(folder / "m.vdb", {}, one), b = surfaceFromVdb(folder / "m.vdb", {}, two);
  EXPECT_TRUE(a.positions == b.positions);
  EXPECT_TRUE(a.triangles == b.triangles);
}

TEST(Surface, NamesWhatAFileHolds) {
  const TemporaryFolder folder;
  writeVdb(folder / "m.vdb", ballMedium());
  for (const char* wanted : {"no such grid", "coverag"}) {
    SurfaceOptions options;
    options.grid = wanted;
    try {
      (void)surfaceFromVdb(folder / "m.vdb", options);
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Input);
      EXPECT_NE(std::string(error.what()).find("coverage (Tree_float_5_4_3)"), std::string::npos) << error.what();
    }
  }
}

void expectClosed(const Mesh& mesh) {
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(report.openEdges, 0u);
  EXPECT_EQ(report.inconsistentEdges, 0u);
  EXPECT_GT(report.signedVolume, 0);
  EXPECT_EQ(report.degenerateFaces, 0u);
}

TEST(Surface, FollowsEveryTransform) {
  const TemporaryFolder folder;
  const double exact = 4.0 / 3 * M_PI * kRadius * kRadius * kRadius;
  const auto squeezed = ballLevelSet(), rotated = ballLevelSet(), mirrored = ballLevelSet();
  squeezed->transform().postScale(openvdb::Vec3d(.5, 1, 3));
  rotated->transform().postRotate(.7, openvdb::math::X_AXIS);
  rotated->transform().postScale(openvdb::Vec3d(.5, 1, 3));
  mirrored->transform().postRotate(.7, openvdb::math::X_AXIS);
  mirrored->transform().postScale(openvdb::Vec3d(.5, -1, 3));
  for (const auto& grid : {squeezed, rotated, mirrored})
    for (const double adaptivity : {0.0, 0.3}) {
      SurfaceOptions options;
      options.adaptivity = adaptivity;
      const Mesh mesh = surfaceOfFile(folder, grid, options);
      expectClosed(mesh);
      EXPECT_NEAR(signedVolume(mesh), 1.5 * exact, (adaptivity > 0 ? 0.2 : 0.015) * exact);
    }
}

TEST(Surface, IsClosedWhereItLeavesTheGrid) {
  const TemporaryFolder folder;
  const auto half = ballLevelSet(), fog = ballLevelSet();
  openvdb::tools::sdfToFogVolume(*fog, 3 * float(kVoxel));
  const openvdb::CoordBBox box({-100, -100, -100}, {100, 100, 9}); // a little above the middle
  for (const auto& grid : {half, fog}) grid->clip(box);
  for (const auto& grid : {half, fog})
    for (const double adaptivity : {0.0, 0.3, 1.0}) {
      SCOPED_TRACE(adaptivity);
      SurfaceOptions options;
      options.adaptivity = adaptivity;
      expectClosed(surfaceOfFile(folder, grid, options));
    }
}

TEST(Surface, OfVectorsIsOneOfTheirLength) {
  const TemporaryFolder folder;
  openvdb::initialize();
  auto vectors = openvdb::Vec3DGrid::create();
  for (auto at = openvdb::CoordBBox(openvdb::Coord(-12), openvdb::Coord(12)).begin(); at; ++at)
    vectors->tree().setValueOn(*at, (*at).asVec3d());
  vectors->setName("v");
  SurfaceOptions options;
  options.grid = "v";
  options.isovalue = 7;
  options.automaticIsovalue = false;
  // Longer outside than in, up to the faces of the block, where it falls to zero: a block with a hollow ball. The
  // block's faces lie .4 to .65 voxel beyond its last voxels.
  const Mesh mesh = surfaceOfFile(folder, vectors, options);
  expectClosed(mesh);
  const double hollow = 4. / 3 * M_PI * 7 * 7 * 7;
  EXPECT_GT(signedVolume(mesh), std::pow(24.8, 3) - 1.01 * hollow - 100);
  EXPECT_LT(signedVolume(mesh), std::pow(25.3, 3) - .99 * hollow);
  options.grid.clear();
  EXPECT_THROW((void)surfaceOfFile(folder, vectors, options), Error) << "vectors only where they are named";
}

TEST(Surface, SaysTheRangeWhereThereIsNone) {
  const TemporaryFolder folder;
  SurfaceOptions options;
  options.isovalue = 77;
  options.automaticIsovalue = false;
  try {
    (void)surfaceOfFile(folder, ballLevelSet(), options);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Input);
    EXPECT_NE(std::string(error.what()).find(" to 1.5, choose"), std::string::npos) << error.what();
  }
}

TEST(Surface, RefusesMoreThanTheMemory) {
  const TemporaryFolder folder;
  openvdb::initialize();
  auto vast = openvdb::FloatGrid::create(0);
  vast->tree().root().addTile(openvdb::Coord(0), 1, true);
  RunContext ctx;
  ctx.memoryLimit = 256 << 20;
  openvdb::io::File(folder / "vast.vdb").write(openvdb::GridPtrVec{vast});
  EXPECT_THROW((void)surfaceFromVdb(folder / "vast.vdb", {}, ctx), Error);
}

// A solid plane as thin as a third of a voxel, and a wire: half coverage has neither.
TEST(Surface, SharpeningBringsThinPartsBack) {
  const TemporaryFolder folder;
  openvdb::initialize();
  for (const bool wire : {false, true}) {
    auto grid = openvdb::FloatGrid::create(0);
    for (int i = 0; i < 40; ++i)
      for (int j = 0; j < (wire ? 1 : 40); ++j) grid->tree().setValueOn({i, j, 7}, .3F);
    grid->setName("coverage");
    const Mesh mesh = surfaceOfFile(folder, grid);
    expectClosed(mesh);
    for (const Vec3d& p : mesh.positions) EXPECT_LE(std::abs(p[2] - 7), .5);
    SurfaceOptions plain;
    plain.sharpen = false;
    EXPECT_THROW((void)surfaceOfFile(folder, grid, plain), Error) << "nothing reaches one half";
  }
}

// At voxels of exactly the isovalue the vertices of all cells around them would be one point.
TEST(Surface, HasNoTriangleWithoutArea) {
  const TemporaryFolder folder;
  openvdb::initialize();
  for (const float background : {0.F, 5.F})
    for (const char* name : {"coverage", "density"}) {
      auto grid = openvdb::FloatGrid::create(background);
      std::uint32_t random = 7;
      for (int v = 0; v < 4096; ++v) {
        random = random * 1664525u + 1013904223u;
        if (random >> 30 == 0)
          grid->tree().setValueOn({v >> 8, v >> 4 & 15, v & 15}, random >> 29 & 1 ? .5F : 1 - background / 5);
      }
      grid->setName(name);
      for (const double adaptivity : {0.0, .5})
        for (const bool sharpen : {false, true}) {
          SurfaceOptions options;
          options.adaptivity = adaptivity;
          options.sharpen = sharpen;
          const Mesh mesh = surfaceOfFile(folder, grid, options);
          EXPECT_EQ(checkMesh(mesh).degenerateFaces, 0u) << name << ' ' << background << ' ' << adaptivity;
          EXPECT_EQ(checkMesh(mesh).openEdges, 0u) << name << ' ' << background << ' ' << adaptivity;
        }
    }
}

TEST(Sharpening, KnowsWhatAPlaneLeavesOfAVoxel) {
  const PlaneCoverage plane;
  for (const std::array<float, 3>& normal : {std::array<float, 3>{1, 0, 0}, {0, -3, 0}, {1, 1, 0}, {.3F, .5F, -.9F}})
    for (int i = 1; i < 40; ++i) { // planes at even steps through 3^3 voxels, by counting points
      const double length = std::hypot(normal[0], normal[1], normal[2]), d = -1.2 + i * .06;
      constexpr int kPoints = 48;
      double block = 0, centre = 0;
      for (int x = 0; x < kPoints; ++x)
        for (int y = 0; y < kPoints; ++y)
          for (int z = 0; z < kPoints; ++z) {
            const auto at = [](int v) { return 3 * (v + .5) / kPoints - 1.5; };
            const bool below = (normal[0] * at(x) + normal[1] * at(y) + normal[2] * at(z)) / length < d;
            const auto middle = [](int v) { return 3 * v >= kPoints && 3 * v < 2 * kPoints; };
            block += below;
            centre += below && middle(x) && middle(y) && middle(z);
          }
      const auto mean = static_cast<float>(block / std::pow(kPoints, 3));
      EXPECT_NEAR(plane.centre(mean, normal), centre / std::pow(kPoints / 3, 3), .04) << mean;
    }
}

TEST(Surface, OfRealFilesIsClosed) {
  const auto folder = sharedPath("data/vdb");
  VOLCAUSTIC_NEED_SHARED(folder);
  for (const auto& file : std::filesystem::directory_iterator(folder))
    for (const GridInfo& grid : inspectVdb(file.path()).grids) {
      if (grid.type != "Tree_float_5_4_3") continue;
      SCOPED_TRACE(file.path().filename().string() + ": " + grid.name);
      SurfaceOptions options;
      options.grid = grid.name;
      options.automaticIsovalue = grid.gridClass == "level set";
      options.isovalue = .3 * grid.minimum + .7 * grid.mean;
      for (const double adaptivity : {0.0, 0.5}) {
        SCOPED_TRACE(adaptivity);
        options.adaptivity = adaptivity;
        expectClosed(surfaceFromVdb(file.path(), options));
      }
    }
}

} // namespace
} // namespace volcaustic::test
