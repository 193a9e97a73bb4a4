// Volumes made by others: what their grids become, and where.
#include "support/shared_data.h"
#include "volcaustic/error.h"
#include "volcaustic/openvdb.h"
#include "volcaustic/vdb.h"

#include <functional>
#include <openvdb/tools/LevelSetSphere.h>

namespace volcaustic::test {
namespace {

/// A file of one float grid `density` that is x + 10 y + 100 z (of the index) in a box, 2 elsewhere.
std::filesystem::path rampFile(const TemporaryFolder& folder, const openvdb::math::Transform::Ptr& transform) {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(2);
  for (auto at = openvdb::CoordBBox({-3, 0, 5}, {8, 9, 12}).begin(); at; ++at)
    grid->tree().setValue(*at, static_cast<float>((*at).x() + 10 * (*at).y() + 100 * (*at).z()));
  grid->setName("density");
  grid->setTransform(transform);
  openvdb::io::File(folder / "ramp.vdb").write(openvdb::GridPtrVec{grid});
  return folder / "ramp.vdb";
}

openvdb::math::Transform::Ptr uprightTransform(double h) {
  auto transform = openvdb::math::Transform::createLinearTransform(h);
  transform->postTranslate({1, 2, 3});
  return transform;
}

/// The value of a grid at a point of the world, in its nearest voxel.
template <class GridType>
auto valueAt(const GridType& grid, const openvdb::Vec3d& world) {
  return grid.tree().getValue(openvdb::Coord::round(grid.worldToIndex(world)));
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

TEST(Import, ScalesAndOffsetsOneGridToSeveralProperties) {
  const TemporaryFolder folder;
  const auto transform = uprightTransform(.25);
  const auto file = rampFile(folder, transform);
  MediumImport import;
  import.index = {"density", {1e-4, 1, 1}, { 1.25, 0, 0 }};
  import.attenuation = {"density", {2, 3, 4}, { .5, 0, 0 }};
  import.scattering = {"density", {1, 1, 1}, { 0, 0, 0 }};
  import.padding = 3;
  const Medium medium = importMedium(file, import);
  EXPECT_EQ(medium.domain().dims, (Vec3i{12 + 6, 10 + 6, 8 + 6}));
  EXPECT_EQ(medium.domain().voxelSize, .25);
  EXPECT_NEAR(medium.ambient().index, 1.2502, 1e-6);
  EXPECT_EQ(medium.ambient().attenuation, (Rgb{4.5, 6, 8}));
  for (const openvdb::Coord& at : {openvdb::Coord(-3, 0, 5), openvdb::Coord(8, 9, 12), openvdb::Coord(2, 4, 7)}) {
    const openvdb::Vec3d world = transform->indexToWorld(at);
    const float value = static_cast<float>(at.x() + 10 * at.y() + 100 * at.z());
    EXPECT_FLOAT_EQ(valueAt(*medium.grids().index, world), 1.25F + 1e-4F * value);
    EXPECT_EQ(valueAt(*medium.grids().attenuation, world), openvdb::Vec3s(2 * value + .5F, 3 * value, 4 * value));
    EXPECT_EQ(valueAt(*medium.grids().scattering, world), openvdb::Vec3s(value));
  }
}

TEST(Import, ComesBackFromTheFileThatItIsWrittenTo) {
  const TemporaryFolder folder;
  MediumImport import;
  import.scattering = {"density", {.1, .2, .3}, {}}; // and attenuation with it
  const Medium medium = importMedium(rampFile(folder, uprightTransform(.25)), import);
  writeVdb(folder / "medium.vdb", medium);
  const Medium read = readMedium(folder / "medium.vdb");
  EXPECT_EQ(read.domain().dims, medium.domain().dims);
  EXPECT_EQ(read.ambient().scattering, medium.ambient().scattering);
  EXPECT_EQ(read.ambient().attenuation, medium.ambient().scattering);
  for (auto value = medium.grids().scattering->cbeginValueOn(); value; ++value) {
    ASSERT_EQ(read.grids().scattering->tree().getValue(value.getCoord()), *value);
    ASSERT_EQ(read.grids().attenuation->tree().getValue(value.getCoord()), *value);
  }
}

// A linear field is what trilinear interpolation keeps, so it must be the same function of the world afterwards.
TEST(Import, ResamplesEveryLinearTransformToCubes) {
  const TemporaryFolder folder;
  const auto stretched = openvdb::math::Transform::createLinearTransform(1);
  stretched->preScale(openvdb::Vec3d(.5, .25, .4));
  const auto rotated = stretched->copy();
  rotated->postRotate(.4, openvdb::math::Y_AXIS);
  rotated->postTranslate({5, 6, 7});
  const auto mirrored = stretched->copy();
  mirrored->postScale(openvdb::Vec3d(-1, 1, 1));
  for (const auto& transform : {stretched, rotated, mirrored}) {
    MediumImport import;
    import.attenuation = {"density", {1, 1, 1}, {}};
    const Medium medium = importMedium(rampFile(folder, transform), import);
    EXPECT_DOUBLE_EQ(medium.domain().voxelSize, .25);
    int inside = 0;
    for (auto value = medium.grids().attenuation->cbeginValueOn(); value; ++value) {
      const openvdb::Vec3d index = transform->worldToIndex(medium.grids().attenuation->indexToWorld(value.getCoord()));
      if (!openvdb::BBoxd({-3, 0, 5}, {8, 9, 12}).isInside(index)) continue;
      ASSERT_NEAR((*value)[1], index[0] + 10 * index[1] + 100 * index[2], .01);
      ++inside;
    }
    const double expected = 11 * 9 * 7 * .5 * .25 * .4 / std::pow(.25, 3);
    EXPECT_NEAR(inside, expected, .25 * expected);
  }
}

TEST(Import, ChoosesTheVoxelSizeAskedFor) {
  const TemporaryFolder folder;
  MediumImport import;
  import.attenuation = {"density", {1, 1, 1}, {}};
  import.voxelSize = .125;
  import.padding = 0;
  const Medium medium = importMedium(rampFile(folder, uprightTransform(.25)), import);
  EXPECT_EQ(medium.domain().voxelSize, .125);
  EXPECT_NEAR(medium.domain().dims[0], 24, 1);
  EXPECT_NEAR(valueAt(*medium.grids().attenuation, {1 + 2 * .25, 2 + 4 * .25, 3 + 8 * .25})[0], 842, 60);
}

TEST(Import, LevelSetBecomesABody) {
  const TemporaryFolder folder;
  openvdb::initialize();
  const auto sphere = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(1, openvdb::Vec3f(3, 0, 0), .05F);
  sphere->setName("ball");
  openvdb::io::File(folder / "ball.vdb").write(openvdb::GridPtrVec{sphere});
  MediumImport import;
  import.body = "ball";
  import.material.index = 1.5;
  import.material.attenuation = {.1, .2, .3};
  for (const double voxelSize : {0.0, .08}) { // its own voxels, and resampled
    import.voxelSize = voxelSize;
    const Medium medium = importMedium(folder / "ball.vdb", import);
    double volume = 0;
    for (auto value = medium.grids().coverage->cbeginValueOn(); value; ++value)
      volume += *value * static_cast<double>(value.getVoxelCount());
    volume *= std::pow(medium.domain().voxelSize, 3);
    EXPECT_NEAR(volume, 4 * M_PI / 3, .01 * volume);
    EXPECT_FLOAT_EQ(valueAt(*medium.grids().index, {3, 0, 0}), 1.5F);
    EXPECT_FLOAT_EQ(valueAt(*medium.grids().index, {3, 0, 1.5}), 1);
    EXPECT_NEAR(valueAt(*medium.grids().index, {3, 1, 0}), 1.25, .1);
    EXPECT_EQ(valueAt(*medium.grids().attenuation, {3, 0, 0}), openvdb::Vec3s(.1F, .2F, .3F));
    EXPECT_EQ(valueAt(*medium.grids().attenuation, {3, 1.4, 0}), openvdb::Vec3s(0.0F));
  }
}

TEST(Import, NamesWhatCannotBe) {
  const TemporaryFolder folder;
  const auto file = rampFile(folder, uprightTransform(.25));
  const auto imported = [&](const MediumImport& import) { return [&] { (void)importMedium(file, import); }; };
  MediumImport import;
  EXPECT_NE(errorOf(imported(import), ErrorKind::Usage), "");
  import.attenuation = {"smoke", {1, 1, 1}, {}};
  EXPECT_NE(errorOf(imported(import), ErrorKind::Input).find("it holds density (Tree_float_5_4_3)"), std::string::npos);
  import = {};
  import.index = {"density", {-1, 1, 1}, { 1, 0, 0 }};
  EXPECT_NE(errorOf(imported(import), ErrorKind::Input).find("not above zero"), std::string::npos);
  import = {};
  import.attenuation = {"density", {1, 1, 1}, {}};
  import.scattering = {"density", {1, 1.1, 1}, {}};
  EXPECT_NE(errorOf(imported(import), ErrorKind::Input).find("scattering is more"), std::string::npos);
  import = {};
  import.attenuation = {"density", {1, 1, 1}, {}};
  import.voxelSize = 5e-5;
  EXPECT_NE(errorOf(imported(import), ErrorKind::Input).find("32768"), std::string::npos);
  import.voxelSize = 1e-6;
  EXPECT_NE(errorOf(imported(import), ErrorKind::Input).find("transform"), std::string::npos);
  import.voxelSize = 0;
  import.attenuation->scale[1] = NAN;
  EXPECT_NE(errorOf(imported(import), ErrorKind::Usage).find("finite"), std::string::npos);
}

TEST(Import, ClampsWithAWarning) {
  const TemporaryFolder folder;
  MediumImport import;
  import.attenuation = {"density", {-1, 1, 1}, { 600, 0, 0 }};
  RunContext ctx;
  std::string warnings;
  ctx.onLog = [&](LogLevel level, std::string_view line) {
    if (level == LogLevel::Warning) warnings += line;
  };
  const Medium medium = importMedium(rampFile(folder, uprightTransform(.25)), import, ctx);
  EXPECT_NE(warnings.find("clamped"), std::string::npos);
  float low, high;
  low = high = 0;
  for (auto value = medium.grids().attenuation->cbeginValueOn(); value; ++value) {
    low = std::min(low, (*value)[0]);
    high = std::max(high, (*value)[0]);
  }
  EXPECT_EQ(low, 0);
  EXPECT_EQ(high, 600 - 497);
}

TEST(Import, RefusesPointsAndFrustums) {
  const auto points = sharedPath("data/vdb/pointgrid.vdb");
  const TemporaryFolder folder;
  MediumImport import;
  import.attenuation = {"density", {1, 1, 1}, {}};
  const openvdb::math::Transform::Ptr frustum(new openvdb::math::Transform(openvdb::math::MapBase::Ptr(
      new openvdb::math::NonlinearFrustumMap(openvdb::BBoxd({0, 0, 0}, {9, 9, 9}), .5, 1))));
  const auto file = rampFile(folder, frustum);
  EXPECT_NE(errorOf([&] { (void)importMedium(file, import); }, ErrorKind::Input).find("frustum"), std::string::npos);
  VOLCAUSTIC_NEED_SHARED(points);
  import.attenuation->grid = inspectVdb(points).grids.at(0).name;
  EXPECT_NE(errorOf([&] { (void)importMedium(points, import); }, ErrorKind::Input).find("no field"), std::string::npos);
}

/// Every field of every real file, as the attenuation it may be.
TEST(Import, TakesEveryRealField) {
  const auto folder = sharedPath("data/vdb");
  VOLCAUSTIC_NEED_SHARED(folder);
  for (const auto& file : std::filesystem::directory_iterator(folder))
    for (const GridInfo& grid : inspectVdb(file.path()).grids) {
      SCOPED_TRACE(file.path().filename().string() + ": " + grid.name);
      if (grid.type.find("ptdata") != std::string::npos) continue;
      MediumImport import;
      if (grid.gridClass == "level set")
        import.body = grid.name;
      else
        import.attenuation = {grid.name, {1, 1, 1}, {}};
      const Medium medium = importMedium(file.path(), import);
      for (int a = 0; a < 3; ++a) {
        const double h = medium.domain().voxelSize;
        EXPECT_LE(medium.domain().minCorner[a], grid.world.min[a] + h);
        EXPECT_GE(medium.domain().maxCorner()[a], grid.world.max[a] - h);
      }
      EXPECT_GT(
          (import.body ? medium.grids().coverage->activeVoxelCount() : medium.grids().attenuation->activeVoxelCount()),
          grid.activeVoxels / 2);
    }
}

} // namespace
} // namespace volcaustic::test
