#include "volume/vdb_file.h"

#include "core/atomic_file.h"
#include "core/guarded_process.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "volume/nanovdb.h"
#include "volume/vdb_guard.h"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <istream>
#include <mutex>
#include <openvdb/io/Stream.h>
#include <unistd.h>

namespace volcaustic {

namespace {

/// OpenVDB's own file writer does not look at the state of its stream; this one writes the same bytes to any seekable
/// stream.
class SeekableArchive : public openvdb::io::Archive {
public:
  void writeTo(std::ostream& out, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata) const {
    write(out, grids, /*seekable=*/true, metadata);
  }
};

/// OpenVDB puts a random UUID into every file. Here it becomes a hash of all other bytes, so that the same grids give
/// the same file, and different ones (nearly) always different UUIDs, which is what readers use it for.
void stampUuid(std::iostream& file) {
  constexpr std::streamoff kUuidOffset = 8 + 4 + 2 * 4 + 1; // magic, file version, library version, has-offsets flag
  constexpr std::size_t kUuidSize = 36;
  std::string uuid(kUuidSize, '0');
  file.seekg(kUuidOffset);
  file.read(uuid.data(), kUuidSize);
  assert(uuid[8] == '-' && uuid[13] == '-' && uuid[18] == '-' && uuid[23] == '-');

  Hash hash;
  std::vector<char> block(1 << 20);
  const auto hashFrom = [&](std::streamoff begin, std::streamoff end) {
    for (file.seekg(begin); begin < end;) {
      const auto size = std::min<std::streamoff>(end - begin, static_cast<std::streamoff>(block.size()));
      file.read(block.data(), size);
      hash.bytes(block.data(), static_cast<std::size_t>(size));
      begin += size;
    }
  };
  file.seekg(0, std::ios::end);
  const std::streamoff end = file.tellg();
  hashFrom(0, kUuidOffset);
  hashFrom(kUuidOffset + static_cast<std::streamoff>(kUuidSize), end);

  const std::string a = hash.hex(), b = hash.text("second half").hex();
  uuid = a.substr(0, 8) + '-' + a.substr(8, 4) + "-8" + a.substr(13, 3) + "-8" + b.substr(1, 3) + '-' + b.substr(4, 12);
  file.seekp(kUuidOffset);
  file.write(uuid.data(), kUuidSize);
}

void writeOpenVdb(const std::filesystem::path& path, const openvdb::GridPtrVec& grids,
                  const openvdb::MetaMap& metadata) {
  using openvdb::io::Archive;
  SeekableArchive archive;
  archive.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK |
                         (Archive::hasBloscCompression()  ? openvdb::io::COMPRESS_BLOSC
                          : Archive::hasZLibCompression() ? openvdb::io::COMPRESS_ZIP
                                                          : openvdb::io::COMPRESS_NONE));
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary | std::ios::trunc);
  file.exceptions(std::ios::failbit | std::ios::badbit);
  archive.writeTo(file, grids, metadata);
  stampUuid(file);
  file.close();
}

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

/// Shallow copies that carry the file's common metadata and, where wanted, the half-float flag.
openvdb::GridPtrVec prepared(const openvdb::GridPtrVec& grids, const VdbWriteOptions& options) {
  openvdb::GridPtrVec result;
  for (const auto& grid : grids) {
    result.push_back(grid->copyGrid());
    addCommonMetadata(*result.back(), options);
    result.back()->setCreator("volcaustic " VOLCAUSTIC_VERSION);
    if (options.half) result.back()->setSaveFloatAsHalf(true);
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
  if (nano && options.half)
    throw Error(ErrorKind::Usage,
                path.string() + ": NanoVDB has no 16-bit floats of this kind; drop half or write a .vdb");
  addCommonMetadata(metadata, options);
  const openvdb::GridPtrVec finished = prepared(grids, options);

  AtomicFile file(toStandardOutput ? std::filesystem::temp_directory_path() / "volcaustic.vdb" : path);
  try {
    if (nano) {
      std::ofstream out(file.path(), std::ios::binary);
      out.exceptions(std::ios::failbit | std::ios::badbit);
      writeNanoVdb(out, finished, path.string(), ctx);
      out.close();
    } else {
      withThreads(ctx, [&] { writeOpenVdb(file.path(), finished, metadata); });
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
