#include "volume/vdb_archive.h"

#include "core/hash.h"
#include "core/hashed_file.h"
#include "core/parallel.h"

#include <cassert>
#include <map>
#include <memory>
#include <openvdb/io/Archive.h>
#include <openvdb/io/DelayedLoadMetadata.h>
#include <openvdb/io/GridDescriptor.h>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace volcaustic {

namespace {

using openvdb::GridBase;
using openvdb::io::DelayedLoadMetadata;

constexpr std::int64_t kLeavesPerPiece = 64;
constexpr std::size_t kUuidOffset = 8 + 4 + 2 * 4 + 1; // magic, file version, library version, has-offsets flag
constexpr std::size_t kUuidSize = 36;

/// Bytes between the compression code of a leaf and the size of its compressed values: inactive values that could not
/// be left out, and a mask that says which of two each one is.
template <class Leaf>
std::int64_t inactiveBytes(std::int8_t code) {
  constexpr std::int64_t kValue = sizeof(typename Leaf::ValueType), kMask = sizeof(typename Leaf::NodeMaskType);
  switch (code) {
  case openvdb::io::NO_MASK_AND_ONE_INACTIVE_VAL:
    return kValue;
  case openvdb::io::MASK_AND_NO_INACTIVE_VALS:
    return kMask;
  case openvdb::io::MASK_AND_ONE_INACTIVE_VAL:
    return kValue + kMask;
  case openvdb::io::MASK_AND_TWO_INACTIVE_VALS:
    return 2 * kValue + kMask;
  default:
    return 0;
  }
}

/// The leaves of a tree as a file holds them, and what a reader has to know to load some of them later.
struct EncodedLeaves {
  std::vector<std::string> pieces;
  DelayedLoadMetadata sizes;
};

/// \pre `compression` compresses: only then is there a size before the values of a leaf
template <class GridType>
void encodeLeaves(const GridType& grid, std::uint32_t compression, EncodedLeaves& encoded, const RunContext& ctx) {
  using Leaf = typename GridType::TreeType::LeafNodeType;
  std::vector<const Leaf*> leaves;
  grid.tree().getNodes(leaves);
  const auto count = static_cast<std::int64_t>(leaves.size());
  encoded.pieces.resize((leaves.size() + kLeavesPerPiece - 1) / kLeavesPerPiece);
  encoded.sizes.resizeMask(leaves.size());
  encoded.sizes.resizeCompressedSize(leaves.size());
  parallelFor(count, kLeavesPerPiece, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    std::ostringstream out;
    openvdb::io::setDataCompression(out, compression);
    openvdb::io::setGridBackgroundValuePtr(out, &grid.background());
    for (std::int64_t i = begin; i < end; ++i) {
      const std::size_t code = out.view().size() + sizeof(typename Leaf::NodeMaskType);
      leaves[i]->writeBuffers(out, grid.saveFloatAsHalf());
      const auto mask = static_cast<std::int8_t>(out.view()[code]);
      const auto rest = static_cast<std::int64_t>(out.view().size() - code - sizeof mask);
      encoded.sizes.setMask(i, mask);
      encoded.sizes.setCompressedSize(i, rest - inactiveBytes<Leaf>(mask));
    }
    encoded.pieces[begin / kLeavesPerPiece] = std::move(out).str();
  });
}

/// The types whose leaves OpenVDB can load later.
using DelayedTypes = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                                       openvdb::Vec3IGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid>;

class ParallelArchive : public openvdb::io::Archive {
public:
  explicit ParallelArchive(const RunContext& ctx) : mCtx(ctx) {
    setCompression(openvdb::io::COMPRESS_ACTIVE_MASK | (hasBloscCompression()  ? openvdb::io::COMPRESS_BLOSC
                                                        : hasZLibCompression() ? openvdb::io::COMPRESS_ZIP
                                                                               : openvdb::io::COMPRESS_NONE));
  }

  void writeTo(std::ostream& out, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata) const {
    auto streamMetadata = std::make_shared<openvdb::io::StreamMetadata>();
    openvdb::io::setStreamMetadataPtr(out, streamMetadata);
    openvdb::io::setDataCompression(out, compression());
    openvdb::io::setWriteGridStatsMetadata(out, true);
    writeHeaderWithoutUuid(out);
    metadata.writeMeta(out);
    const auto count = static_cast<std::int32_t>(grids.size());
    out.write(reinterpret_cast<const char*>(&count), sizeof count);

    const std::vector<std::string> names = uniqueNames(grids);
    std::map<std::pair<const openvdb::TreeBase*, bool>, std::string> written; // tree and half floats: the first grid
    for (std::size_t i = 0; i < grids.size(); ++i) {
      mCtx.throwIfCancelled();
      const GridBase& grid = *grids[i];
      openvdb::io::GridDescriptor descriptor(names[i], grid.type(), grid.saveFloatAsHalf());
      const auto [first, isFirst] = written.try_emplace({&grid.baseTree(), grid.saveFloatAsHalf()}, names[i]);
      if (isFirst) {
        if (!writeEncoded(descriptor, grid, out)) writeGrid(descriptor, grids[i], out, /*seekable=*/true);
      } else {
        descriptor.setInstanceParentName(first->second);
        writeGridInstance(descriptor, grids[i], out, /*seekable=*/true);
      }
      openvdb::io::setDataCompression(out, compression()); // which each grid changes to its own
    }
  }

private:
  /// OpenVDB puts a random UUID into every file.
  void writeHeaderWithoutUuid(std::ostream& out) const {
    std::ostringstream header;
    writeHeader(header, /*seekable=*/true);
    std::string bytes = std::move(header).str();
    assert(bytes[kUuidOffset + 8] == '-' && bytes[kUuidOffset + 23] == '-');
    out << bytes.replace(kUuidOffset, kUuidSize, kUuidSize, '0');
  }

  /// Grids of one name, or none, are told apart by an invisible number after it.
  static std::vector<std::string> uniqueNames(const openvdb::GridPtrVec& grids) {
    using openvdb::io::GridDescriptor;
    std::map<std::string, int> count;
    for (const auto& grid : grids) ++count[grid->getName()];
    std::set<std::string> taken;
    std::vector<std::string> names;
    for (const auto& grid : grids) {
      const std::string own = grid->getName();
      std::string name = own.empty() || count[own] > 1 ? GridDescriptor::addSuffix(own, 0) : own;
      for (int n = 1; !taken.insert(name).second; ++n) name = GridDescriptor::addSuffix(own, n);
      names.push_back(name);
    }
    return names;
  }

  /// The compression that OpenVDB chooses for the grid.
  [[nodiscard]] std::uint32_t compressionOf(const GridBase& grid) const {
    std::ostringstream out;
    setGridCompression(out, grid);
    return openvdb::io::getDataCompression(out);
  }

  /// What Archive::writeGrid writes, where there are leaves to compress. False, and nothing written, where there are
  /// none, and for types whose leaves do not begin with a mask and a code.
  bool writeEncoded(openvdb::io::GridDescriptor& descriptor, const GridBase& grid, std::ostream& out) const {
    const std::uint32_t compression = compressionOf(grid);
    if (grid.baseTree().leafCount() == 0 || !(compression & (openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ZIP)))
      return false;
    EncodedLeaves leaves;
    if (!grid.apply<DelayedTypes>([&](const auto& typed) { encodeLeaves(typed, compression, leaves, mCtx); }))
      return false;

    descriptor.writeHeader(out);
    const auto offsets = out.tellp();
    descriptor.writeStreamPos(out);
    descriptor.setGridPos(out.tellp());
    setGridCompression(out, grid);
    withMetadata(grid, compression, leaves.sizes)->writeMeta(out);
    grid.writeTransform(out);
    grid.writeTopology(out);
    descriptor.setBlockPos(out.tellp());
    for (const std::string& piece : leaves.pieces) out.write(piece.data(), static_cast<std::streamsize>(piece.size()));
    descriptor.setEndPos(out.tellp());
    out.seekp(offsets);
    descriptor.writeStreamPos(out);
    descriptor.seekToEnd(out);
    return true;
  }

  [[nodiscard]] GridBase::ConstPtr withMetadata(const GridBase& grid, std::uint32_t compression,
                                                const DelayedLoadMetadata& sizes) const {
    const GridBase::Ptr result = std::const_pointer_cast<GridBase>(grid.copyGrid());
    withThreads(mCtx, [&] { result->addStatsMetadata(); });
    result->insertMeta(GridBase::META_FILE_COMPRESSION,
                       openvdb::StringMetadata(openvdb::io::compressionToString(compression)));
    result->insertMeta(GridBase::META_FILE_DELAYED_LOAD, sizes);
    return result;
  }

  const RunContext& mCtx;
};

/// Marked as one of the writer's own making (version 8).
std::string uuidOf(std::uint64_t digest) {
  Hash hash;
  const std::string a = hash.value(digest).hex(), b = hash.text("second half").hex();
  return a.substr(0, 8) + '-' + a.substr(8, 4) + "-8" + a.substr(13, 3) + "-8" + b.substr(1, 3) + '-' + b.substr(4, 12);
}

} // namespace

void writeArchive(HashedFile& file, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata,
                  const RunContext& ctx) {
  std::ostream out(&file);
  out.exceptions(std::ios::failbit | std::ios::badbit);
  ParallelArchive(ctx).writeTo(out, grids, metadata);
  out.flush();
  const std::string uuid = uuidOf(file.digest());
  out.seekp(kUuidOffset);
  out << uuid;
  out.flush();
}

} // namespace volcaustic
