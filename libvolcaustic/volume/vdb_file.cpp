#include "volume/vdb_file.h"

#include "core/atomic_file.h"
#include "core/guarded_process.h"
#include "core/hashed_file.h"
#include "volume/host_grids.h"
#include "volume/nanovdb.h"
#include "volume/vdb_archive.h"
#include "volume/vdb_guard.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <istream>
#include <mutex>
#include <openvdb/io/Stream.h>
#include <sstream>
#include <unistd.h>

namespace volcaustic {

namespace {

void copyToStandardOutput(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(1 << 20);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())), file.gcount() > 0)
    for (const char *p = block.data(), *end = p + file.gcount(); p < end;) {
      const ssize_t written = write(STDOUT_FILENO, p, static_cast<std::size_t>(end - p));
      if (written < 0 && errno != EINTR)
        throw Error(ErrorKind::File, "-: cannot write to standard output: " + std::string(std::strerror(errno)));
      p += std::max<ssize_t>(written, 0);
    }
}

/// Who wrote it and what the caller adds, on the file or on a grid.
void addCommonMetadata(openvdb::MetaMap& target, const VdbWriteOptions& options) {
  target.insertMeta("software", openvdb::StringMetadata("volcaustic"));
  target.insertMeta("version", openvdb::StringMetadata(VOLCAUSTIC_VERSION));
  for (const auto& [key, value] : options.metadata) target.insertMeta(key, openvdb::StringMetadata(value));
}

template <class Value>
double largestComponent(const Value& value) {
  if constexpr (openvdb::VecTraits<Value>::IsVec) {
    double largest = 0;
    for (int axis = 0; axis < openvdb::VecTraits<Value>::Size; ++axis)
      largest = std::max(largest, std::abs(static_cast<double>(value[axis])));
    return largest;
  } else {
    return std::abs(static_cast<double>(value));
  }
}

/// The largest magnitude of all numbers in a grid of floats or of their vectors; 0 for other types.
double largestMagnitude(const openvdb::GridBase& base) {
  using Floating = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid>;
  double largest = 0;
  base.apply<Floating>([&](const auto& grid) {
    auto tile = grid.tree().cbeginValueAll();
    tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1);
    for (; tile; ++tile) largest = std::max(largest, largestComponent(*tile));
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
      const auto* values = leaf->buffer().data();
      for (openvdb::Index i = 0; i < leaf->buffer().size(); ++i)
        largest = std::max(largest, largestComponent(values[i]));
    }
  });
  return largest;
}

/// Whether 16 bits hold numbers up to the given: none is beyond the greatest half, and not all have less than 11
/// digits.
bool fitHalf(double largest) { return largest == 0 || (largest >= 0x1p-14 && largest <= 65504); }

/// Shallow copies that carry the file's common metadata and, where wanted and of use, the half-float flag.
openvdb::GridPtrVec prepared(const std::filesystem::path& path, const openvdb::GridPtrVec& grids,
                             const VdbWriteOptions& options, const RunContext& ctx) {
  openvdb::GridPtrVec result;
  for (const auto& grid : gridsForHost(grids, options.preset)) {
    result.push_back(grid->copyGrid());
    addCommonMetadata(*result.back(), options);
    result.back()->setCreator("volcaustic " VOLCAUSTIC_VERSION);
    if (options.half) result.back()->setSaveFloatAsHalf(true);
    if (!result.back()->saveFloatAsHalf() || path.extension() == ".nvdb") continue;
    if (const double largest = largestMagnitude(*grid); !fitHalf(largest)) {
      result.back()->setSaveFloatAsHalf(false);
      std::ostringstream line;
      line << path.string() << ": grid \"" << grid->getName() << "\" keeps 32 bits: its largest number is " << largest
           << ", and 16 bits hold 6e-5 to 65504 well";
      ctx.warn(line.str());
    }
  }
  return result;
}

} // namespace

void initialiseOpenVdb() {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

openvdb::GridBase::Ptr VdbFile::find(const std::string& name) const {
  for (const auto& grid : grids)
    if (grid->getName() == name) return grid;
  return nullptr;
}

std::string listGrids(std::span<const GridName> grids) {
  std::string text;
  for (const GridName& grid : grids) text += (text.empty() ? "" : ", ") + grid.name + " (" + grid.type + ")";
  return text.empty() ? "no grid" : text;
}

GridSelection gridsNamed(std::vector<std::string> names) {
  return [wanted = std::move(names)](std::span<const GridName> grids) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < grids.size(); ++i)
      if (std::find(wanted.begin(), wanted.end(), grids[i].name) != wanted.end()) found.push_back(i);
    return found;
  };
}

VdbFile readVdbFile(const std::filesystem::path& path, const RunContext& ctx, const GridSelection& selection) {
  initialiseOpenVdb();
  const std::string place = path.string();
  const std::uint64_t size = readableFileSize(place);
  const VdbFormat format = vdbFormat(place);
  ctx.throwIfCancelled();
  const GuardedBytes plain = runGuarded(place, GuardLimits::forFile(size, ctx), ctx,
                                        [&](std::ostream& out) { normaliseVdb(place, format, selection, out); });
  ctx.requireMemory(plain.bytes().size(), place);

  VdbFile file;
  try {
    MemoryBuffer buffer(plain.bytes());
    std::istream in(&buffer);
    openvdb::io::Stream stream(in, /*delayLoad=*/false);
    if (const auto grids = stream.getGrids()) file.grids = *grids;
    if (const auto metadata = stream.getMetadata()) file.metadata = *metadata;
  } catch (const std::exception& error) {
    throw Error(ErrorKind::Input, place + ": damaged: " + error.what());
  }
  return file;
}

void writeVdbFile(const std::filesystem::path& path, const openvdb::GridPtrVec& grids, openvdb::MetaMap metadata,
                  const VdbWriteOptions& options, const RunContext& ctx) {
  initialiseOpenVdb();
  const bool toStandardOutput = path == "-";
  const bool nano = path.extension() == ".nvdb";
  if (!toStandardOutput && !nano && path.extension() != ".vdb")
    throw Error(ErrorKind::Usage, path.string() + ": is neither .vdb nor .nvdb; name the file by one of them");
  addCommonMetadata(metadata, options);
  const openvdb::GridPtrVec finished = prepared(path, grids, options, ctx);

  AtomicFile file(toStandardOutput ? std::filesystem::temp_directory_path() / "volcaustic.vdb" : path);
  try {
    if (nano) {
      std::ofstream out(file.path(), std::ios::binary);
      out.exceptions(std::ios::failbit | std::ios::badbit);
      writeNanoVdb(out, finished, metadata, options.half, path.string(), ctx);
      out.close();
    } else {
      HashedFile out(file.path());
      writeArchive(out, finished, metadata, ctx);
    }
  } catch (const std::ios::failure&) {
    throw Error(ErrorKind::File,
                path.string() + ": cannot be written: " + std::strerror(errno) + "; check the space on the disk");
  }
  if (toStandardOutput)
    copyToStandardOutput(file.path());
  else
    file.commit();
}

} // namespace volcaustic
