#include "support/shared_data.h"
#include "unit/vdb_fixture.h"
#include "volcaustic/error.h"
#include "volcaustic/vdb.h"

#include <fstream>
#include <iterator>
#include <openvdb/io/Stream.h>
#include <set>

namespace volcaustic::test {
namespace {

std::string bytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

template <class GridType>
void expectSameGrid(const GridType& a, const GridType& b) {
  EXPECT_EQ(a.transform(), b.transform());
  EXPECT_EQ(a.background(), b.background());
  ASSERT_TRUE(a.tree().hasSameTopology(b.tree())) << a.getName();
  const auto access = b.getConstAccessor();
  for (auto value = a.cbeginValueOn(); value; ++value)
    ASSERT_EQ(*value, access.getValue(value.getCoord())) << a.getName();
}

openvdb::GridBase::Ptr readDirectly(const std::filesystem::path& path, const std::string& name) {
  openvdb::initialize();
  openvdb::io::File file(path);
  file.open(false);
  return file.readGrid(name);
}

TEST(VdbRoundTrip, HostsGetTheGridsThatTheyUse) {
  const TemporaryFolder folder;
  const auto names = [&](HostPreset preset, bool parts) {
    VdbWriteOptions options;
    options.preset = preset;
    options.parts = parts;
    writeVdb(folder / "light.vdb", ballLight(), ballMedium(), options);
    std::set<std::string> found;
    for (const GridInfo& grid : inspectVdb(folder / "light.vdb").grids) found.insert(grid.name);
    return found;
  };
  using Names = std::set<std::string>;
  EXPECT_EQ(names(HostPreset::None, false), (Names{"density", "direction", "emission", "radiance"}));
  EXPECT_EQ(names(HostPreset::Houdini, false), (Names{"density", "direction", "emission", "radiance"}));
  EXPECT_FALSE(readDirectly(folder / "light.vdb", "emission")->saveFloatAsHalf());
  for (const HostPreset preset : {HostPreset::Blender, HostPreset::Arnold, HostPreset::Renderman})
    EXPECT_EQ(names(preset, true), (Names{"caustic", "density", "direct", "emission", "radiance"}));
  EXPECT_TRUE(readDirectly(folder / "light.vdb", "emission")->saveFloatAsHalf());
  EXPECT_EQ(names(HostPreset::Unreal, false), (Names{"density", "emission"})); // four channels
  VdbWriteOptions options;
  options.preset = HostPreset::Unreal;
  writeVdb(folder / "medium.vdb", ballMedium(), options);
  EXPECT_EQ(inspectVdb(folder / "medium.vdb").grids.size(), 5U);
  EXPECT_FALSE(readDirectly(folder / "medium.vdb", "index")->saveFloatAsHalf());
}

TEST(VdbRoundTrip, MediumComesBackBitByBit) {
  const TemporaryFolder folder;
  const Medium written = ballMedium();
  writeVdb(folder / "medium.vdb", written);
  const Medium read = readMedium(folder / "medium.vdb");
  EXPECT_EQ(read.domain().dims, written.domain().dims);
  EXPECT_EQ(read.domain().minCorner, written.domain().minCorner);
  EXPECT_EQ(read.domain().voxelSize, written.domain().voxelSize);
  EXPECT_EQ(read.ambient().index, written.ambient().index);
  EXPECT_EQ(read.ambient().attenuation, written.ambient().attenuation);
  EXPECT_EQ(read.ambient().scattering, written.ambient().scattering);
  EXPECT_EQ(read.ambient().asymmetry, written.ambient().asymmetry);
  expectSameGrid(*written.grids().index, *read.grids().index);
  expectSameGrid(*written.grids().attenuation, *read.grids().attenuation);
  expectSameGrid(*written.grids().scattering, *read.grids().scattering);
  expectSameGrid(*written.grids().coverage, *read.grids().coverage);
  ASSERT_TRUE(read.grids().asymmetry);
  expectSameGrid(*written.grids().asymmetry, *read.grids().asymmetry);
}

float largest(const Vec3f& v) { return std::max({v[0], v[1], v[2]}); }

// A voxel in memory holds twenty bits of its largest channel (kernels::FluenceVoxel): both parts, and their sum that
// the file has, are as near as that. What has been read once stays as it is, bit by bit.
constexpr double kFluenceBits = 2e-6, kDirectionBits = 4e-6;

TEST(VdbRoundTrip, RadianceComesBack) {
  const TemporaryFolder folder;
  for (const double exposure : {0.0, 10.0, -0.3}) {
    SCOPED_TRACE(exposure);
    VdbWriteOptions options;
    options.exposure = exposure;
    const RadianceVolume light = ballLight();
    writeVdb(folder / "light.vdb", light, ballMedium(), options);
    const RadianceVolume read = readRadiance(folder / "light.vdb", ballDomain());
    const Vec3i dims = ballDomain().dims;
    for (int x = 0; x < dims[0]; ++x)
      for (int y = 0; y < dims[1]; ++y)
        for (int z = 0; z < dims[2]; ++z) {
          const Vec3i voxel{x, y, z};
          const Vec3f a = read.fluence(voxel), b = light.fluence(voxel);
          const Vec3f d = read.direction(voxel), e = light.direction(voxel);
          const float luminance = kernels::luminance(kernels::Float3(b[0], b[1], b[2]));
          for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(a[c], b[c], kFluenceBits * largest(b)) << x << ' ' << y << ' ' << z;
            ASSERT_NEAR(d[c] * luminance, e[c] * luminance, kDirectionBits * largest(b)) << x << ' ' << y << ' ' << z;
          }
        }
    writeVdb(folder / "again.vdb", read, ballMedium(), options);
    writeVdb(folder / "third.vdb", readRadiance(folder / "again.vdb", ballDomain()), ballMedium(), options);
    EXPECT_TRUE(bytesOf(folder / "again.vdb") == bytesOf(folder / "third.vdb"));
  }
}

TEST(VdbRoundTrip, PartsStayApart) {
  const TemporaryFolder folder;
  VdbWriteOptions options;
  options.parts = true;
  const RadianceVolume light = ballLight();
  writeVdb(folder / "light.vdb", light, ballMedium(), options);
  const RadianceVolume read = readRadiance(folder / "light.vdb", ballDomain());
  for (const Vec3i& voxel : {Vec3i{18, 19, 33}, Vec3i{17, 22, 3}, Vec3i{40, 5, 20}, Vec3i{40, 5, 2}}) {
    const Vec3f caustic = light.causticFluence(voxel), direct = light.directFluence(voxel);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(read.causticFluence(voxel)[c], caustic[c], kFluenceBits * largest(caustic));
      EXPECT_NEAR(read.directFluence(voxel)[c], direct[c], kFluenceBits * largest(direct));
    }
  }
}

TEST(VdbRoundTrip, HalfFloatsKeepElevenBits) {
  const TemporaryFolder folder;
  VdbWriteOptions options;
  options.half = true;
  const Medium written = ballMedium();
  writeVdb(folder / "half.vdb", written, options);
  writeVdb(folder / "full.vdb", written);
  EXPECT_LT(std::filesystem::file_size(folder / "half.vdb"), std::filesystem::file_size(folder / "full.vdb"));
  const Medium read = readMedium(folder / "half.vdb");
  EXPECT_EQ(read.ambient().index, written.ambient().index);
  for (auto value = written.grids().index->cbeginValueOn(); value; ++value)
    ASSERT_NEAR(read.grids().index->tree().getValue(value.getCoord()), *value, *value / 2048);
}

TEST(VdbRoundTrip, LightBeyondSixteenBitsKeepsThirtyTwo) {
  const TemporaryFolder folder;
  writeVdb(folder / "light.vdb", ballLight(), ballMedium());
  const auto radiance = [&](double exposure, bool half) {
    std::vector<std::string> warnings;
    RunContext ctx;
    ctx.onLog = [&](LogLevel, std::string_view line) { warnings.emplace_back(line); };
    VdbWriteOptions options;
    options.half = half;
    options.exposure = exposure;
    writeVdb(folder / "light.vdb", ballLight(), ballMedium(), options, ctx);
    const auto grid = openvdb::gridPtrCast<openvdb::Vec3SGrid>(readDirectly(folder / "light.vdb", "radiance"));
    const bool kept = !grid->saveFloatAsHalf();
    EXPECT_EQ(kept && half, std::any_of(warnings.begin(), warnings.end(), [](const std::string& line) {
                return line.find("\"radiance\" keeps 32 bits") != std::string::npos;
              }));
    double sum = 0;
    for (auto value = grid->cbeginValueOn(); value; ++value) sum += value->length();
    return std::pair(kept, sum / std::exp2(exposure));
  };
  const double sum = radiance(0, false).second;
  ASSERT_GT(sum, 0);
  for (const double exposure : {-40.0, 40.0}) { // lost, and infinite, in 16 bits
    const auto [kept, found] = radiance(exposure, true);
    EXPECT_TRUE(kept);
    EXPECT_NEAR(found, sum, 1e-6 * sum);
  }
  const auto [kept, found] = radiance(0, true);
  EXPECT_FALSE(kept);
  EXPECT_NEAR(found, sum, 1e-3 * sum);
}

TEST(VdbWrite, BytesDependOnNothingButTheGrids) {
  const TemporaryFolder folder;
  RunContext one, two;
  one.threads = 1;
  two.threads = 2;
  for (const char* name : {"a.vdb", "a.nvdb"}) {
    writeVdb(folder / name, ballLight(), ballMedium(), {}, one);
    const std::string first = bytesOf(folder / name);
    writeVdb(folder / name, ballLight(), ballMedium(), {}, two);
    EXPECT_TRUE(first == bytesOf(folder / name)) << name;
  }
  writeVdb(folder / "b.vdb", ballMedium());
  writeVdb(folder / "a.vdb", ballLight(), ballMedium());
  EXPECT_NE(bytesOf(folder / "a.vdb").substr(21, 36), bytesOf(folder / "b.vdb").substr(21, 36))
      << "UUIDs of different files";
}

TEST(VdbWrite, GridsHaveTheTypesClassesAndMetadataOfTheFormatPage) {
  const TemporaryFolder folder;
  VdbWriteOptions options;
  options.metadata = {{"scene_hash", "0123"}, {"frame", "7"}};
  options.parts = true;
  writeVdb(folder / "light.vdb", ballLight(), ballMedium(), options);
  const VdbInfo info = inspectVdb(folder / "light.vdb");
  EXPECT_EQ(info.metadata.at("software"), "volcaustic");
  EXPECT_EQ(info.metadata.at("frame"), "7");
  EXPECT_EQ(info.metadata.at("volcaustic_dims"), "[45, 40, 50]");
  std::map<std::string, GridInfo> grids;
  for (const GridInfo& grid : info.grids) grids[grid.name] = grid;
  ASSERT_EQ(grids.size(), 6u);
  for (const char* name : {"radiance", "caustic", "direct", "emission"}) {
    EXPECT_EQ(grids.at(name).type, "Tree_vec3s_5_4_3") << name;
    EXPECT_EQ(grids.at(name).gridClass, "fog volume") << name;
    EXPECT_EQ(grids.at(name).vectorType, "invariant") << name;
    EXPECT_EQ(grids.at(name).metadata.at("scene_hash"), "0123") << name;
  }
  EXPECT_EQ(grids.at("direction").vectorType, "contravariant relative");
  EXPECT_EQ(grids.at("density").type, "Tree_float_5_4_3");
  EXPECT_EQ(grids.at("density").gridClass, "fog volume");
  EXPECT_EQ(grids.at("radiance").metadata.at("unit"), "W/(m2 sr)");
  EXPECT_EQ(grids.at("radiance").metadata.at("software"), "volcaustic");
  // The fog fills the box, so density and its bounds are the domain's.
  EXPECT_EQ(grids.at("density").activeVoxels, 45u * 40u * 50u);
  EXPECT_NEAR(grids.at("density").world.min[0], ballDomain().minCorner[0], 1e-9);
  EXPECT_NEAR(grids.at("density").world.max[2], ballDomain().maxCorner()[2], 1e-9);
}

TEST(VdbWrite, EmissionIsScatteringTimesRadianceAndDensityALuminance) {
  const TemporaryFolder folder;
  writeVdb(folder / "light.vdb", ballLight(), ballMedium());
  const auto emission = openvdb::gridPtrCast<openvdb::Vec3SGrid>(readDirectly(folder / "light.vdb", "emission"));
  const auto density = openvdb::gridPtrCast<openvdb::FloatGrid>(readDirectly(folder / "light.vdb", "density"));
  const Medium medium = ballMedium();
  const RadianceVolume light = ballLight();
  for (const Vec3i& v : {Vec3i{22, 20, 25}, Vec3i{3, 4, 45}, Vec3i{20, 20, 2}, Vec3i{3, 3, 3}}) {
    const openvdb::Coord at(v[0], v[1], v[2]);
    const openvdb::Vec3s s = medium.grids().scattering->tree().getValue(at),
                         t = medium.grids().attenuation->tree().getValue(at);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(emission->tree().getValue(at)[c], s[c] * light.fluence(v)[c] / (4 * M_PI), 1e-6 * s[c]);
    EXPECT_NEAR(density->tree().getValue(at), 0.2126 * t[0] + 0.7152 * t[1] + 0.0722 * t[2], 1e-6);
  }
  EXPECT_FALSE(emission->tree().isValueOn({3, 3, 3})) << "no light there, so nothing is stored";
}

TEST(VdbWrite, AFailedWriteLeavesTheOldFile) {
  const TemporaryFolder folder;
  std::ofstream(folder / "old.txt") << "old";
  EXPECT_THROW(writeVdb(folder / "old.txt", ballMedium()), Error);
  EXPECT_EQ(bytesOf(folder / "old.txt"), "old");
  EXPECT_THROW(writeVdb(folder / "absent" / "x.vdb", ballMedium()), Error);
  try {
    writeVdb("/dev/full", ballMedium());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
  }
}

TEST(VdbCompare, FindsADifferenceOfKnownSize) {
  const TemporaryFolder folder;
  writeVdb(folder / "a.vdb", ballMedium());
  for (const Difference& d : compareVdb(folder / "a.vdb", folder / "a.vdb")) EXPECT_EQ(d.maximum, 0) << d.name;

  const Medium medium = ballMedium();
  MediumGrids grids = medium.grids();
  const auto coverage = grids.coverage->deepCopy();
  coverage->tree().setValueOn({22, 20, 25}, 0.25F);                               // was 1
  coverage->tree().sparseFill(openvdb::CoordBBox({8, 8, 8}, {15, 15, 15}), 0.5F); // a tile where the other has none
  grids.coverage = coverage;
  writeVdb(folder / "b.vdb", mediumFromGrids(medium.domain(), medium.ambient(), grids));
  for (const Difference& d : compareVdb(folder / "a.vdb", folder / "b.vdb")) {
    if (d.name != "coverage") {
      EXPECT_EQ(d.maximum, 0) << d.name;
      continue;
    }
    EXPECT_FLOAT_EQ(d.maximum, 0.75);
    std::uint64_t active = 0;
    double sum = 0.75;
    for (auto v = coverage->cbeginValueOn(); v; ++v) active += v.getVoxelCount();
    for (int i = 0; i < 512; ++i) {
      const openvdb::Coord at(8 + i / 64, 8 + i / 8 % 8, 8 + i % 8);
      sum += std::abs(0.5 - medium.grids().coverage->tree().getValue(at));
    }
    EXPECT_NEAR(d.meanAbsolute, sum / double(active), 1e-9);
  }
  writeVdb(folder / "c.vdb", ballLight(), ballMedium());
  EXPECT_THROW((void)compareVdb(folder / "a.vdb", folder / "c.vdb"), Error);
  Domain moved = ballDomain();
  moved.minCorner[1] += 0.5;
  writeVdb(folder / "d.vdb", ballMedium(moved));
  EXPECT_THROW((void)compareVdb(folder / "a.vdb", folder / "d.vdb"), Error);
}

TEST(VdbConvert, NanoVdbAndBackChangesNoValue) {
  const TemporaryFolder folder;
  writeVdb(folder / "light.vdb", ballLight(), ballMedium());
  convertVdb(folder / "light.vdb", folder / "light.nvdb");
  convertVdb(folder / "light.nvdb", folder / "back.vdb");
  const auto differences = compareVdb(folder / "light.vdb", folder / "back.vdb");
  EXPECT_EQ(differences.size(), 4u);
  for (const Difference& d : differences) EXPECT_EQ(d.maximum, 0) << d.name;
  EXPECT_EQ(inspectVdb(folder / "light.nvdb").grids.size(), 4u);
}

template <class GridType>
openvdb::GridBase::Ptr gridOf(const char* name, const typename GridType::ValueType& background,
                              const typename GridType::ValueType& value, openvdb::GridClass gridClass) {
  auto grid = GridType::create(background);
  for (int i = 0; i < 50; ++i) grid->tree().setValueOn({i, i * i, -i}, value);
  grid->tree().sparseFill(openvdb::CoordBBox({64, 64, 64}, {127, 127, 127}), value); // tiles
  grid->setName(name);
  grid->setGridClass(gridClass);
  auto transform = openvdb::math::Transform::createLinearTransform(.5);
  transform->preScale(openvdb::Vec3d(1, 2, 3));
  transform->postRotate(.5, openvdb::math::Z_AXIS);
  transform->postTranslate({7, 8, 9});
  grid->setTransform(transform);
  grid->insertMeta("author", openvdb::StringMetadata(name));
  return grid;
}

openvdb::GridPtrVec gridsOfManyTypes() {
  openvdb::initialize();
  return {gridOf<openvdb::BoolGrid>("bool", false, true, openvdb::GRID_UNKNOWN),
          gridOf<openvdb::DoubleGrid>("double", .1, 1. / 3, openvdb::GRID_FOG_VOLUME),
          gridOf<openvdb::FloatGrid>("float", .25F, -.1F, openvdb::GRID_LEVEL_SET),
          gridOf<openvdb::Int32Grid>("int32", -1, 1 << 30, openvdb::GRID_UNKNOWN),
          gridOf<openvdb::Int64Grid>("int64", -1, std::int64_t{1} << 60, openvdb::GRID_UNKNOWN),
          gridOf<openvdb::Vec3SGrid>("vec3s", {1, 2, 3}, {.1F, .2F, .3F}, openvdb::GRID_STAGGERED)};
}

TEST(VdbConvert, EveryTypeGoesThroughNanoVdb) {
  const TemporaryFolder folder;
  openvdb::io::File(folder / "a.vdb").write(gridsOfManyTypes());
  convertVdb(folder / "a.vdb", folder / "a.nvdb");
  convertVdb(folder / "a.nvdb", folder / "back.vdb");
  for (const Difference& d : compareVdb(folder / "a.vdb", folder / "back.vdb")) EXPECT_EQ(d.maximum, 0) << d.name;
  const VdbInfo before = inspectVdb(folder / "a.vdb"), after = inspectVdb(folder / "back.vdb");
  ASSERT_EQ(after.grids.size(), 6u);
  for (std::size_t i = 0; i < before.grids.size(); ++i) {
    const GridInfo &a = before.grids[i], &b = after.grids[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.type, b.type);
    EXPECT_EQ(a.gridClass, b.gridClass) << a.name;
    EXPECT_EQ(a.activeVoxels, b.activeVoxels) << a.name;
    EXPECT_EQ(a.indexMin, b.indexMin) << a.name;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a.voxelSize[c], b.voxelSize[c], 1e-6) << a.name;
  }
}

TEST(VdbConvert, NanoVdbKeepsMetadata) {
  const TemporaryFolder folder;
  openvdb::MetaMap metadata;
  metadata.insertMeta("shot", openvdb::StringMetadata("12"));
  openvdb::GridPtrVec grids = gridsOfManyTypes();
  grids.back()->setVectorType(openvdb::VEC_COVARIANT);
  openvdb::io::File(folder / "a.vdb").write(grids, metadata);
  convertVdb(folder / "a.vdb", folder / "a.nvdb");
  const VdbInfo info = inspectVdb(folder / "a.nvdb");
  EXPECT_EQ(info.metadata.at("shot"), "12");
  for (const GridInfo& grid : info.grids) EXPECT_EQ(grid.metadata.at("author"), grid.name);
  EXPECT_EQ(info.grids.back().vectorType, "covariant");
}

TEST(VdbConvert, AMediumGoesThroughNanoVdb) {
  const TemporaryFolder folder;
  const Medium written = ballMedium();
  writeVdb(folder / "medium.nvdb", written);
  const Medium read = readMedium(folder / "medium.nvdb");
  EXPECT_EQ(read.domain().dims, written.domain().dims);
  EXPECT_EQ(read.domain().minCorner, written.domain().minCorner);
  EXPECT_EQ(read.domain().voxelSize, written.domain().voxelSize);
  EXPECT_EQ(read.ambient().index, written.ambient().index);
  EXPECT_EQ(read.ambient().attenuation, written.ambient().attenuation);
  expectSameGrid(*written.grids().index, *read.grids().index);
}

TEST(VdbConvert, HalfNanoVdbHasSixteenBits) {
  const TemporaryFolder folder;
  int warnings = 0;
  RunContext ctx;
  ctx.onLog = [&](LogLevel level, std::string_view line) {
    warnings += level == LogLevel::Warning && line.find("32-bit") != line.npos;
  };
  writeVdb(folder / "full.nvdb", ballMedium());
  VdbWriteOptions half;
  half.half = true;
  writeVdb(folder / "half.nvdb", ballMedium(), half, ctx);
  EXPECT_EQ(warnings, 2) << "attenuation and scattering";
  EXPECT_LT(std::filesystem::file_size(folder / "half.nvdb"), std::filesystem::file_size(folder / "full.nvdb"));
  for (const Difference& d : compareVdb(folder / "full.nvdb", folder / "half.nvdb"))
    EXPECT_LE(d.maximum, d.name == "attenuation" || d.name == "scattering" ? 0 : 1. / 65535) << d.name;
}

TEST(VdbInfo, SaysWhatIsMirrored) {
  const TemporaryFolder folder;
  openvdb::GridPtrVec grids = gridsOfManyTypes();
  grids.front()->transform().postScale(openvdb::Vec3d(-1, 1, 1));
  openvdb::io::File(folder / "a.vdb").write(grids);
  const VdbInfo info = inspectVdb(folder / "a.vdb");
  EXPECT_TRUE(info.grids.front().mirrored);
  EXPECT_FALSE(info.grids.back().mirrored);
}

TEST(VdbConvert, NamesTheGridThatNanoVdbCannotHold) {
  const TemporaryFolder folder;
  openvdb::initialize();
  const auto doubles = gridOf<openvdb::Vec3DGrid>("motion", {1, 2, 3}, {.1, .2, .3}, openvdb::GRID_STAGGERED);
  openvdb::io::File(folder / "a.vdb").write(openvdb::GridPtrVec{doubles});
  try {
    convertVdb(folder / "a.vdb", folder / "a.nvdb");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Input);
    EXPECT_NE(std::string(error.what()).find("'motion'"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.nvdb"));
}

TEST(VdbConvert, AVdbKeepsItsMetadata) {
  const TemporaryFolder folder;
  openvdb::MetaMap metadata;
  metadata.insertMeta("shot", openvdb::StringMetadata("12"));
  openvdb::io::File(folder / "a.vdb").write(gridsOfManyTypes(), metadata);
  convertVdb(folder / "a.vdb", folder / "b.vdb");
  const VdbInfo info = inspectVdb(folder / "b.vdb");
  EXPECT_EQ(info.metadata.at("shot"), "12");
  for (const GridInfo& grid : info.grids) EXPECT_EQ(grid.metadata.at("author"), grid.name);
}

TEST(ReadMedium, TakesDoubles) {
  const TemporaryFolder folder;
  openvdb::initialize();
  auto index = openvdb::DoubleGrid::create(1.0);
  auto attenuation = openvdb::Vec3DGrid::create(openvdb::Vec3d(.5));
  index->setName("index");
  attenuation->setName("attenuation");
  index->fill(openvdb::CoordBBox({0, 0, 0}, {9, 9, 9}), 1.33);
  attenuation->fill(openvdb::CoordBBox({0, 0, 0}, {9, 9, 9}), openvdb::Vec3d(1, 2, 3));
  openvdb::io::File(folder / "doubles.vdb").write(openvdb::GridPtrVec{index, attenuation});
  const Medium medium = readMedium(folder / "doubles.vdb");
  EXPECT_EQ(medium.grids().attenuation->tree().getValue({5, 5, 5}), openvdb::Vec3s(1, 2, 3));
  EXPECT_EQ(medium.ambient().attenuation, (Rgb{.5, .5, .5}));
}

TEST(ReadMedium, ForeignIndexGridGivesTheBoxOfItsActiveVoxels) {
  const TemporaryFolder folder;
  openvdb::initialize();
  auto index = openvdb::DoubleGrid::create(1.0);
  index->setName("index");
  index->fill(openvdb::CoordBBox({-5, 3, 100}, {4, 22, 107}), 1.33);
  index->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  openvdb::io::File(folder / "foreign.vdb").write(openvdb::GridPtrVec{index});
  const Medium medium = readMedium(folder / "foreign.vdb");
  EXPECT_EQ(medium.domain().dims, (Vec3i{10, 20, 8}));
  EXPECT_EQ(medium.domain().minCorner, (Vec3d{-2.75, 1.25, 49.75}));
  EXPECT_EQ(medium.grids().index->tree().getValue({0, 0, 0}), 1.33F);
  EXPECT_EQ(medium.grids().index->tree().getValue({10, 0, 0}), 1.0F);
  EXPECT_EQ(medium.grids().index->activeVoxelCount(), 1600u);
}

TEST(ReadMedium, RefusesWhatNoMediumCanBe) {
  const TemporaryFolder folder;
  openvdb::initialize();
  const auto refused = [&](const openvdb::GridBase::Ptr& grid) {
    grid->setName("index");
    openvdb::io::File(folder / "bad.vdb").write(openvdb::GridPtrVec{grid});
    try {
      (void)readMedium(folder / "bad.vdb");
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Input) << error.what();
    }
  };
  auto nan = openvdb::FloatGrid::create(1);
  nan->tree().setValueOn({1, 1, 1}, NAN);
  refused(nan);
  auto negative = openvdb::FloatGrid::create(1);
  negative->tree().setValueOn({1, 1, 1}, -1);
  refused(negative);
  auto rotated = openvdb::FloatGrid::create(1);
  rotated->tree().setValueOn({1, 1, 1}, 2);
  rotated->transform().postRotate(0.3, openvdb::math::X_AXIS);
  refused(rotated);
  auto vast = openvdb::FloatGrid::create(1);
  vast->tree().setValueOn({0, 0, 0}, 2);
  vast->tree().setValueOn({2000000000, 0, 0}, 2);
  refused(vast);
  refused(openvdb::Int32Grid::create(1));
  refused(openvdb::FloatGrid::create(1));
}

} // namespace
} // namespace volcaustic::test
