#include "volume/nanovdb.h"

#include "core/parallel.h"
#include "volcaustic/error.h"

#include <cstring>
#include <fstream>
#include <ostream>
#include <sstream>
#include <vector>

// Parallel loops that pass exceptions on, and the codecs of foreign files.
#define NANOVDB_USE_OPENVDB
#define NANOVDB_USE_TBB
#define NANOVDB_USE_ZIP
#define NANOVDB_USE_BLOSC

// NanoVDB's headers and namespaces moved: OpenVDB 10 has util/OpenToNanoVDB.h, 11 util/CreateNanoGrid.h, and 12
// tools/CreateNanoGrid.h in the namespace tools.
#if __has_include(<nanovdb/tools/CreateNanoGrid.h>)
#include <nanovdb/io/IO.h>
#include <nanovdb/tools/CreateNanoGrid.h>
#include <nanovdb/tools/NanoToOpenVDB.h>
namespace nanotools = nanovdb::tools;
#elif __has_include(<nanovdb/util/CreateNanoGrid.h>)
#include <nanovdb/util/CreateNanoGrid.h>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/NanoToOpenVDB.h>
namespace nanotools = nanovdb;
#else
#include <nanovdb/util/GridChecksum.h>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/NanoToOpenVDB.h>
#include <nanovdb/util/OpenToNanoVDB.h>
namespace nanotools = nanovdb;
#endif

namespace volcaustic {

namespace {

using Handle = nanovdb::GridHandle<nanovdb::HostBuffer>;

// The layout of a .nvdb: segments of one header, a record and a name for each grid, then the grids' bytes. Written out
// here because NanoVDB trusts all of it.
struct SegmentHeader {
  std::uint64_t magic;
  std::uint32_t version; // major in the top 11 bits
  std::uint16_t gridCount, codec;
};
struct GridRecord {
  std::uint64_t gridSize, fileSize, nameKey, voxelCount;
  std::uint32_t gridType, gridClass;
  double worldBox[6];
  std::int32_t indexBox[6];
  double voxelSize[3];
  std::uint32_t nameSize, nodeCount[4], tileCount[3];
  std::uint16_t codec, padding;
  std::uint32_t version;
};
static_assert(sizeof(SegmentHeader) == 16 && sizeof(GridRecord) == 176);

/// What follows a grid's tree for each of its blind data.
struct BlindRecord {
  std::int64_t dataOffset; // from the record itself
  std::uint64_t count;
  std::uint32_t valueSize, semantic, dataClass, type; // zero but for the size: unknown
  char name[256];
};
static_assert(sizeof(BlindRecord) == sizeof(nanovdb::GridBlindMetaData));
constexpr const char* kGridMetadata = "openvdb_grid_metadata"; // a MetaMap as a .vdb has it
constexpr const char* kFileMetadata = "openvdb_file_metadata";

class ClaimChecker {
public:
  explicit ClaimChecker(const std::string& path)
      : mPath(path), mFile(path, std::ios::binary | std::ios::ate), mLeft(static_cast<std::uint64_t>(mFile.tellg())) {
    mFile.seekg(0);
  }
  void check() {
    while (mLeft > 0) checkSegment();
  }

private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorKind::Input, mPath + ": damaged: " + what + "; write it again with the program that made it");
  }
  template <class T>
  T take(const char* what) {
    T value{};
    skip(sizeof value, what);
    mFile.seekg(-static_cast<std::streamoff>(sizeof value), std::ios::cur);
    mFile.read(reinterpret_cast<char*>(&value), sizeof value);
    return value;
  }
  void skip(std::uint64_t bytes, const char* what) {
    if (bytes > mLeft) fail(std::string(what) + " reaches beyond the end of the file");
    mFile.seekg(static_cast<std::streamoff>(bytes), std::ios::cur);
    mLeft -= bytes;
  }
  void checkSegment() {
    const auto header = take<SegmentHeader>("a segment header");
    if (std::memcmp(&header.magic, "NanoVDB", 7) != 0) fail("a segment does not start with NanoVDB's magic number");
    if (header.version >> 21 != NANOVDB_MAJOR_VERSION_NUMBER)
      throw Error(ErrorKind::Input, mPath + ": is of NanoVDB version " + std::to_string(header.version >> 21) +
                                        ", this program reads " + std::to_string(NANOVDB_MAJOR_VERSION_NUMBER) +
                                        "; convert it with nanovdb_convert");
    if (header.gridCount == 0) fail("a segment without grids");
    if (header.codec > static_cast<unsigned>(nanovdb::io::Codec::BLOSC)) fail("unknown compression");
    std::vector<GridRecord> records;
    for (int i = 0; i < header.gridCount; ++i) {
      records.push_back(take<GridRecord>("a grid record"));
      skip(records.back().nameSize, "a grid's name");
    }
    for (const GridRecord& record : records) checkGrid(record, header.codec);
  }
  void checkGrid(const GridRecord& record, std::uint16_t codec) {
    if (record.gridSize < sizeof(nanovdb::GridData)) fail("a grid is smaller than its own header");
    if (codec == static_cast<std::uint16_t>(nanovdb::io::Codec::NONE)) {
      if (record.fileSize != record.gridSize) fail("an uncompressed grid whose sizes disagree");
      return skip(record.fileSize, "a grid");
    }
    // Compressed grids are chunks, each after its own size, of at most 1 GiB before compression.
    const std::uint64_t chunks =
        codec == static_cast<std::uint16_t>(nanovdb::io::Codec::ZIP) ? 1 : (record.gridSize - 1) / (1u << 30) + 1;
    for (std::uint64_t i = 0; i < chunks; ++i) skip(take<std::uint64_t>("a compressed grid"), "a compressed grid");
  }

  const std::string& mPath;
  std::ifstream mFile;
  std::uint64_t mLeft;
};

std::string gridName(const Handle& handle) {
  const auto& data = *reinterpret_cast<const nanovdb::GridData*>(handle.data());
  return {data.mGridName, strnlen(data.mGridName, sizeof data.mGridName)};
}

/// True when every node that the tree points to lies inside the grid's own bytes.
template <class Value>
bool nodesInside(const nanovdb::NanoGrid<Value>& grid, const Handle& handle) {
  const auto begin = reinterpret_cast<std::uintptr_t>(handle.data()), end = begin + handle.size();
  const auto inside = [&](const void* node, std::size_t bytes) {
    const auto address = reinterpret_cast<std::uintptr_t>(node);
    return address % NANOVDB_DATA_ALIGNMENT == 0 && address >= begin && address <= end && bytes <= end - address;
  };
  if (!inside(&grid.tree(), sizeof(grid.tree()))) return false;
  const auto& root = grid.tree().root();
  if (!inside(&root, sizeof root) || !inside(&root + 1, sizeof(*root.data()->tile(0)) * root.data()->mTableSize))
    return false;
  for (std::uint32_t t = 0; t < root.data()->mTableSize; ++t) {
    const auto* tile = root.data()->tile(t);
    if (!tile->isChild()) continue;
    const auto* upper = root.data()->getChild(tile);
    if (!inside(upper, sizeof *upper)) return false;
    for (auto l = upper->childMask().beginOn(); l; ++l) {
      const auto* lower = upper->data()->getChild(*l);
      if (!inside(lower, sizeof *lower)) return false;
      for (auto leaf = lower->childMask().beginOn(); leaf; ++leaf)
        if (const auto* node = lower->data()->getChild(*leaf); !inside(node, sizeof *node)) return false;
    }
  }
  return true;
}

/// The metadata that are blind data of this name; empty where there are none.
openvdb::MetaMap metadataOf(const Handle& handle, const std::string& name, const std::string& place) {
  openvdb::MetaMap map;
  const auto& grid = *reinterpret_cast<const nanovdb::GridData*>(handle.data());
  const auto inside = [&](std::int64_t begin, std::uint64_t bytes) {
    return begin >= 0 && static_cast<std::uint64_t>(begin) <= handle.size() && bytes <= handle.size() - begin;
  };
  for (std::uint32_t i = 0; i < grid.mBlindMetadataCount; ++i) {
    const auto at = static_cast<std::int64_t>(static_cast<std::uint64_t>(grid.mBlindMetadataOffset) +
                                              std::uint64_t{i} * sizeof(BlindRecord));
    if (!inside(at, sizeof(BlindRecord))) throw Error(ErrorKind::Input, place + " is damaged: its blind data are cut");
    BlindRecord record;
    std::memcpy(&record, handle.data() + at, sizeof record);
    if (name != std::string(record.name, strnlen(record.name, sizeof record.name))) continue;
    const auto data =
        static_cast<std::int64_t>(static_cast<std::uint64_t>(at) + static_cast<std::uint64_t>(record.dataOffset));
    if (!inside(data, record.count)) throw Error(ErrorKind::Input, place + " is damaged: its metadata are cut");
    std::istringstream in(std::string(reinterpret_cast<const char*>(handle.data()) + data, record.count));
    map.readMeta(in);
  }
  return map;
}

/// From index space to the world. Set anew, because the converter of OpenVDB 10 transposes it: rotations turn the other
/// way. NanoVDB multiplies columns by rows of the matrix, OpenVDB rows by its columns.
openvdb::math::Transform::Ptr transformOf(const nanovdb::Map& map) {
  openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix(row, column) = map.mMatD[3 * column + row];
    matrix(3, row) = map.mVecD[row];
  }
  return openvdb::math::Transform::createLinearTransform(matrix);
}

/// Converts the grid when it is of this value type.
template <class Value>
bool convertIf(const Handle& handle, const std::string& place, openvdb::GridBase::Ptr& result) {
  const auto* grid = handle.grid<Value>();
  if (!grid) return false;
  if (!nodesInside<Value>(*grid, handle))
    throw Error(ErrorKind::Input,
                place + " is damaged: it points outside its own data; write it again with the program that made it");
  result = nanotools::nanoToOpenVDB(*grid);
  result->setTransform(transformOf(grid->map()));
  return true;
}

template <class... Value>
openvdb::GridBase::Ptr convertAny(const Handle& handle, const std::string& path) {
  const std::string place = path + ": grid '" + gridName(handle) + "'";
  if (handle.gridMetaData()->gridSize() > handle.size())
    throw Error(ErrorKind::Input, place + " is damaged: larger than its own data");
  openvdb::GridBase::Ptr result;
  if (!(convertIf<Value>(handle, place, result) || ...))
    throw Error(ErrorKind::Input,
                place + " is of a type that has no OpenVDB counterpart here; leave it out of the file");
  result->insertMeta(metadataOf(handle, kGridMetadata, place));
  return result;
}

/// Value types that OpenVDB registers, and NanoVDB's quantised floats. Every type more costs half a minute of
/// compilation.
openvdb::GridBase::Ptr toOpenVdb(const Handle& handle, const std::string& path) {
  return convertAny<float, double, std::int32_t, std::int64_t, bool, nanovdb::Vec3f, nanovdb::Vec3d, nanovdb::Fp4,
                    nanovdb::Fp8, nanovdb::Fp16, nanovdb::FpN>(handle, path);
}

std::size_t aligned(std::size_t bytes) { return (bytes + NANOVDB_DATA_ALIGNMENT - 1) & ~(NANOVDB_DATA_ALIGNMENT - 1); }

struct BlindData {
  const char* name;
  std::string bytes;
};

std::string bytesOf(const openvdb::MetaMap& metadata) {
  std::ostringstream out;
  metadata.writeMeta(out);
  return std::move(out).str();
}

/// The grid with blind data behind it. \pre it has none
Handle withBlindData(const Handle& grid, const std::vector<BlindData>& blind) {
  const std::size_t records = aligned(grid.size());
  std::size_t at = records + aligned(blind.size() * sizeof(BlindRecord));
  std::vector<std::size_t> places;
  for (const BlindData& data : blind) {
    places.push_back(at);
    at += aligned(data.bytes.size());
  }
  auto buffer = nanovdb::HostBuffer::create(at);
  auto* out = reinterpret_cast<char*>(buffer.data());
  std::memcpy(out, grid.data(), grid.size());
  std::memset(out + grid.size(), 0, at - grid.size());
  for (std::size_t i = 0; i < blind.size(); ++i) {
    const std::size_t place = records + i * sizeof(BlindRecord);
    BlindRecord record{static_cast<std::int64_t>(places[i] - place), blind[i].bytes.size(), 1, 0, 0, 0, {}};
    std::strncpy(record.name, blind[i].name, sizeof record.name - 1);
    std::memcpy(out + place, &record, sizeof record);
    std::memcpy(out + places[i], blind[i].bytes.data(), blind[i].bytes.size());
  }
  auto& data = *reinterpret_cast<nanovdb::GridData*>(out);
  data.mGridSize = at;
  data.mBlindMetadataOffset = static_cast<std::int64_t>(records);
  data.mBlindMetadataCount = static_cast<std::uint32_t>(blind.size());
  return Handle(std::move(buffer));
}

/// `Build` says how NanoVDB stores a value: as what it is, or quantised.
template <class GridType, class Build>
Handle encode(const openvdb::GridBase& grid, const std::vector<BlindData>& blind) {
  const auto bare = nanotools::openToNanoVDB<nanovdb::HostBuffer, typename GridType::TreeType, Build>(
      static_cast<const GridType&>(grid));
  Handle result = withBlindData(bare, blind);
  nanovdb::updateChecksum(*result.grid<Build>());
  return result;
}

template <class GridType>
bool encodeIf(const openvdb::GridBase& grid, const std::vector<BlindData>& blind, bool half, Handle& result) {
  using Build = typename nanovdb::OpenToNanoType<typename GridType::TreeType::BuildType>::Type;
  if (!grid.isType<GridType>()) return false;
  if (std::is_same_v<GridType, openvdb::FloatGrid> && half)
    result = encode<openvdb::FloatGrid, nanovdb::Fp16>(grid, blind);
  else
    result = encode<GridType, Build>(grid, blind);
  return true;
}

/// The value types that NanoVDB's converter takes in OpenVDB 10: of vectors of doubles it says so only when it runs.
template <class... GridType>
Handle encodeAny(const openvdb::GridBase& grid, const std::vector<BlindData>& blind, bool half,
                 const std::string& place) {
  Handle result;
  if (!(encodeIf<GridType>(grid, blind, half, result) || ...))
    throw Error(ErrorKind::Input, place + ": grid '" + grid.getName() + "' of type " + grid.type() +
                                      " cannot be stored as NanoVDB; leave it out or write a .vdb");
  return result;
}

/// The grid's own, without what a .vdb has beside them about itself, and the file's if there are any.
std::vector<BlindData> blindData(const openvdb::GridBase& grid, const openvdb::MetaMap* file) {
  openvdb::MetaMap own = grid;
  for (const char* key : {openvdb::GridBase::META_FILE_BBOX_MIN, openvdb::GridBase::META_FILE_BBOX_MAX,
                          openvdb::GridBase::META_FILE_COMPRESSION, openvdb::GridBase::META_FILE_MEM_BYTES,
                          openvdb::GridBase::META_FILE_VOXEL_COUNT, openvdb::GridBase::META_FILE_DELAYED_LOAD,
                          openvdb::GridBase::META_SAVE_HALF_FLOAT})
    own.removeMeta(key);
  std::vector<BlindData> blind{{kGridMetadata, bytesOf(own)}};
  if (file) blind.push_back({kFileMetadata, bytesOf(*file)});
  return blind;
}

} // namespace

openvdb::GridPtrVec readNanoVdb(const std::string& path, openvdb::MetaMap& metadata) {
  ClaimChecker(path).check();
  RunContext serial;
  serial.threads = 1;
  openvdb::GridPtrVec grids;
  withThreads(serial, [&] {
    for (const Handle& handle : nanovdb::io::readGrids(path)) {
      grids.push_back(toOpenVdb(handle, path));
      metadata.insertMeta(metadataOf(handle, kFileMetadata, path + ": grid '" + gridName(handle) + "'"));
    }
  });
  return grids;
}

void writeNanoVdb(std::ostream& out, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata, bool half,
                  const std::string& place, const RunContext& ctx) {
  using namespace openvdb;
  withThreads(ctx, [&] {
    for (const auto& grid : grids) {
      ctx.throwIfCancelled();
      if (half && grid->isType<Vec3SGrid>())
        ctx.warn(place + ": grid '" + grid->getName() + "' keeps 32-bit floats: NanoVDB has no smaller vectors");
      const auto blind = blindData(*grid, grid == grids.front() ? &metadata : nullptr);
      nanovdb::io::writeGrid(
          out, encodeAny<FloatGrid, DoubleGrid, Int32Grid, Int64Grid, BoolGrid, Vec3SGrid>(*grid, blind, half, place),
          nanovdb::io::Codec::BLOSC);
    }
  });
}

} // namespace volcaustic
