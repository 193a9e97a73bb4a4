#include "core/hashed_file.h"
#include "support/shared_data.h"
#include "unit/vdb_fixture.h"
#include "volume/vdb_archive.h"

#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <openvdb/io/File.h>

namespace volcaustic::test {
namespace {

constexpr std::size_t kUuidOffset = 21, kUuidSize = 36;

std::string bytesWithoutUuid(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  return bytes.replace(kUuidOffset, kUuidSize, kUuidSize, '0');
}

/// Leaves with no, one, two and many inactive values, and fully active ones, in every order of magnitude.
template <class GridType>
typename GridType::Ptr motley(const char* name, openvdb::GridClass gridClass) {
  using Value = typename GridType::ValueType;
  auto grid = GridType::create(Value(3));
  const auto value = [](int i) { return Value(1) * static_cast<typename openvdb::VecTraits<Value>::ElementType>(i); };
  for (int leaf = 0; leaf < 150; ++leaf)
    for (int v = 0; v < 512; ++v) {
      const openvdb::Coord at(8 * leaf + (v >> 6), v >> 3 & 7, v & 7);
      if (leaf % 5 == 4 || v % 7 < 3)
        grid->tree().setValueOn(at, value(v * v % 97 + leaf));
      else if (leaf % 5 > 0)
        grid->tree().setValueOff(at, value(v % 3 < leaf % 5 ? -3 : leaf % 5 == 3 ? v : 5));
    }
  grid->tree().addTile(1, openvdb::Coord(4096, 0, 0), value(2), true);
  grid->setName(name);
  grid->setGridClass(gridClass);
  return grid;
}

openvdb::GridPtrVec gridsOfEveryKind() {
  openvdb::initialize();
  auto half = motley<openvdb::FloatGrid>("half", openvdb::GRID_UNKNOWN);
  half->setSaveFloatAsHalf(true);
  auto halfVectors = motley<openvdb::Vec3SGrid>("half vectors", openvdb::GRID_FOG_VOLUME);
  halfVectors->setSaveFloatAsHalf(true);
  const auto fog = motley<openvdb::FloatGrid>("fog", openvdb::GRID_FOG_VOLUME);
  const auto sharing = fog->copy();
  sharing->setName("sharing");
  auto mask = openvdb::BoolGrid::create(false);
  mask->tree().setValueOn({1, 2, 3}, true);
  mask->setName("mask");
  return {fog,
          motley<openvdb::FloatGrid>("level", openvdb::GRID_LEVEL_SET),
          motley<openvdb::DoubleGrid>("twice", openvdb::GRID_UNKNOWN),
          motley<openvdb::DoubleGrid>("twice", openvdb::GRID_FOG_VOLUME),
          motley<openvdb::Int32Grid>("int32", openvdb::GRID_UNKNOWN),
          motley<openvdb::Int64Grid>("", openvdb::GRID_UNKNOWN),
          motley<openvdb::Vec3SGrid>("vectors", openvdb::GRID_STAGGERED),
          motley<openvdb::Vec3DGrid>("vec3d", openvdb::GRID_UNKNOWN),
          motley<openvdb::Vec3IGrid>("vec3i", openvdb::GRID_UNKNOWN),
          half,
          halfVectors,
          sharing,
          mask,
          openvdb::FloatGrid::create(1)};
}

TEST(VdbArchive, WritesWhatOpenVdbWrites) {
  const TemporaryFolder folder;
  const openvdb::GridPtrVec grids = gridsOfEveryKind();
  openvdb::MetaMap metadata;
  metadata.insertMeta("shot", openvdb::StringMetadata("12"));
  openvdb::io::File theirs(folder / "theirs.vdb");
  theirs.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC);
  theirs.write(grids, metadata);
  for (const int threads : {1, 2}) {
    std::ofstream(folder / "ours.vdb").close();
    RunContext ctx;
    ctx.threads = threads;
    HashedFile file(folder / "ours.vdb");
    writeArchive(file, grids, metadata, ctx);
    EXPECT_TRUE(bytesWithoutUuid(folder / "ours.vdb") == bytesWithoutUuid(folder / "theirs.vdb")) << threads;
  }
}

TEST(VdbArchive, LeavesCanBeLoadedLater) {
  const TemporaryFolder folder;
  const auto grid = motley<openvdb::FloatGrid>("fog", openvdb::GRID_FOG_VOLUME);
  std::ofstream(folder / "a.vdb").close();
  {
    HashedFile file(folder / "a.vdb");
    writeArchive(file, {grid}, {}, {});
  }
  openvdb::initialize();
  openvdb::io::File file(folder / "a.vdb");
  file.setCopyMaxBytes(0);
  file.open(/*delayLoad=*/true);
  const auto read = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("fog"));
  ASSERT_TRUE(read->tree().cbeginLeaf()->buffer().isOutOfCore());
  for (auto value = grid->cbeginValueAll(); value; ++value)
    ASSERT_EQ(read->tree().getValue(value.getCoord()), *value) << value.getCoord();
}

} // namespace
} // namespace volcaustic::test
