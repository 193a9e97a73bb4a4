#include "support/shared_data.h"
#include "unit/vdb_fixture.h"
#include "volcaustic/error.h"
#include "volcaustic/mesh.h"
#include "volcaustic/vdb.h"

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
  EXPECT_NEAR(signedVolume(surfaceFromMedium(ballMedium())), exact, 0.02 * exact);
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
  for (const char* wanted : {"attenuation", "no such grid"}) {
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

TEST(Surface, OfRealFiles) {
  const auto sphere = sharedPath("data/vdb/sphere_v222.vdb"), nano = sharedPath("data/vdb/batch_sdf_blosc.nvdb");
  VOLCAUSTIC_NEED_SHARED(sphere);
  EXPECT_GT(signedVolume(surfaceFromVdb(sphere)), 0);
  EXPECT_GT(signedVolume(surfaceFromVdb(nano)), 0);
}

} // namespace
} // namespace volcaustic::test
