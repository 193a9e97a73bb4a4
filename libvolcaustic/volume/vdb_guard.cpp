#include "volume/vdb_guard.h"

#include "volume/nanovdb.h"

#include <cstring>
#include <fstream>
#include <openvdb/io/Stream.h>
#include <ostream>

namespace volcaustic {

namespace {

std::vector<std::size_t> selected(const GridSelection& selection, std::span<const GridName> names) {
  if (selection) return selection(names);
  std::vector<std::size_t> all(names.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  return all;
}

openvdb::GridPtrVec parseOpenVdb(const std::string& path, const GridSelection& selection, openvdb::MetaMap& metadata) {
  openvdb::io::File file(path);
  file.setCopyMaxBytes(0);
  file.open(/*delayLoad=*/false);
  metadata = *file.getMetadata();
  std::vector<GridName> names; // unique ones: File appends [1] and so on to a repeated name
  for (auto name = file.beginName(); name != file.endName(); ++name)
    names.push_back({name.gridName(), file.readGridMetadata(name.gridName())->type()});
  openvdb::GridPtrVec grids;
  for (const std::size_t i : selected(selection, names)) {
    grids.push_back(file.readGrid(names[i].name));
    grids.back()->setName(names[i].name);
  }
  return grids;
}

openvdb::GridPtrVec parseNanoVdb(const std::string& path, const GridSelection& selection, openvdb::MetaMap& metadata) {
  const openvdb::GridPtrVec all = readNanoVdb(path, metadata);
  std::vector<GridName> names;
  for (const auto& grid : all) names.push_back({grid->getName(), grid->type()});
  openvdb::GridPtrVec grids;
  for (const std::size_t i : selected(selection, names)) grids.push_back(all[i]);
  return grids;
}

} // namespace

VdbFormat vdbFormat(const std::string& path) {
  char head[24] = {};
  std::ifstream(path, std::ios::binary).read(head, sizeof head);
  if (std::memcmp(head, " BDV\0\0\0\0", 8) == 0) return VdbFormat::OpenVdb;
  if (std::memcmp(head, "NanoVDB", 7) == 0) return VdbFormat::NanoVdb;
  if (std::memcmp(head, "version https://git-lfs", 23) == 0)
    throw Error(ErrorKind::Input, path + ": is only a Git LFS pointer; fetch the file itself with git lfs pull");
  throw Error(ErrorKind::Input, path + ": is no OpenVDB or NanoVDB file; name a .vdb or .nvdb");
}

void normaliseVdb(const std::string& path, VdbFormat format, const GridSelection& selection, std::ostream& out) {
  openvdb::MetaMap metadata;
  const openvdb::GridPtrVec grids =
      format == VdbFormat::NanoVdb ? parseNanoVdb(path, selection, metadata) : parseOpenVdb(path, selection, metadata);
  openvdb::io::Stream stream(out);
  stream.setCompression(openvdb::io::COMPRESS_NONE);
  stream.setGridStatsMetadataEnabled(false); // keeps what the file says, and computing it would use threads
  stream.write(grids, metadata);
}

} // namespace volcaustic
