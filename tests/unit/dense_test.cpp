#include "support/shared_data.h"
#include "unit/vdb_fixture.h"
#include "volcaustic/dense.h"
#include "volcaustic/error.h"
#include "volcaustic/vdb.h"

namespace volcaustic::test {
namespace {

/// Voxel by voxel, as OpenVDB reads the file that writeVdb has written.
template <class GridType>
void expectFileValues(const openvdb::GridBase& grid, const VoxelBox& box, const std::vector<float>& values) {
  const auto& typed = static_cast<const GridType&>(grid);
  const auto access = typed.getConstAccessor();
  std::size_t at = 0;
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i) {
        const auto value = access.getValue({box.first[0] + i, box.first[1] + j, box.first[2] + k});
        if constexpr (openvdb::VecTraits<typename GridType::ValueType>::IsVec) {
          for (int c = 0; c < 3; ++c) ASSERT_EQ(values[at++], value[c]) << grid.getName();
        } else {
          ASSERT_EQ(values[at++], value) << grid.getName();
        }
      }
}

void expectFileValues(const std::filesystem::path& path, const GridSummary& summary, const VoxelBox& box,
                      const std::vector<float>& values) {
  openvdb::initialize();
  openvdb::io::File file(path);
  file.open(false);
  const auto grid = file.readGrid(summary.name);
  ASSERT_EQ(grid->isType<openvdb::Vec3SGrid>(), summary.components == 3) << summary.name;
  const auto unit = grid->getMetadata<openvdb::StringMetadata>("unit");
  ASSERT_TRUE(unit);
  EXPECT_EQ(unit->value(), summary.unit);
  if (summary.components == 3)
    expectFileValues<openvdb::Vec3SGrid>(*grid, box, values);
  else
    expectFileValues<openvdb::FloatGrid>(*grid, box, values);
}

std::vector<float> arrayFor(const VoxelBox& box, const GridSummary& grid) {
  return std::vector<float>(std::size_t(box.size[0]) * box.size[1] * box.size[2] * grid.components, -1);
}

const VoxelBox kWhole{{0, 0, 0}, ballDomain().dims};
const VoxelBox kAcrossTheBorder{{-3, 9, 41}, {17, 8, 13}}; // and across bricks

TEST(Dense, VoxelsAreThoseOfTheFile) {
  const TemporaryFolder folder;
  const Medium medium = ballMedium();
  PhotonResult photons;
  photons.radiance = ballLight();
  PhotonResult one;
  one.light = "sun_1";
  one.radiance = ballLight();
  photons.lights.push_back(one);
  VdbWriteOptions options;
  options.parts = true;
  writeVdb(folder / "medium.vdb", medium);
  writeVdb(folder / "light.vdb", photons, medium, options);
  ASSERT_EQ(gridsOf(medium).size(), 5U);
  ASSERT_EQ(gridsOf(photons).size(), 9U);
  for (const VoxelBox& box : {kWhole, kAcrossTheBorder}) {
    for (const GridSummary& grid : gridsOf(medium)) {
      std::vector<float> values = arrayFor(box, grid);
      readVoxels(medium, grid.name, box, values);
      expectFileValues(folder / "medium.vdb", grid, box, values);
    }
    for (const GridSummary& grid : gridsOf(photons)) {
      std::vector<float> values = arrayFor(box, grid);
      readVoxels(photons, medium, grid.name, box, values);
      expectFileValues(folder / "light.vdb", grid, box, values);
    }
  }
}

TEST(Dense, WhatDoesNotFitIsRefused) {
  const Medium medium = ballMedium();
  std::vector<float> values(1000);
  const auto message = [&](const std::string& grid, const VoxelBox& box) -> std::string {
    try {
      readVoxels(medium, grid, box, values);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Usage);
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message("atenuation", {{0, 0, 0}, {10, 10, 10}}).find("nearest is attenuation"), std::string::npos);
  EXPECT_NE(message("index", {{0, 0, 0}, {10, 10, 9}}).find("900"), std::string::npos);
  EXPECT_NE(message("attenuation", {{0, 0, 0}, {10, 10, 10}}).find("3000"), std::string::npos);
  EXPECT_NE(message("index", {{0, 0, 0}, {0, 10, 10}}), "");
  EXPECT_NE(message("index", {{0, 0, 0}, {1 << 22, 1 << 22, 1 << 22}}), ""); // its product overflows
  EXPECT_EQ(message("index", {{0, 0, 0}, {10, 10, 10}}), "");
}

} // namespace
} // namespace volcaustic::test
