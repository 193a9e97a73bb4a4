#include "volume/vdb_file.h"

namespace volcaustic {

void convertVdb(const std::filesystem::path& in, const std::filesystem::path& out, const VdbWriteOptions& options,
                const RunContext& ctx) {
  const VdbFile file = readVdbFile(in, ctx);
  if (file.grids.empty()) throw Error(ErrorKind::Input, in.string() + ": holds no grid to convert");
  ctx.progress("convert", 0.5);
  writeVdbFile(out, file.grids, file.metadata, options, ctx);
  ctx.progress("convert", 1);
}

} // namespace volcaustic
