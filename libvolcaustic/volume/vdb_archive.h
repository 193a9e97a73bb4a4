// The bytes of a .vdb, leaves compressed by all threads.
#pragma once

#include "volcaustic/run_context.h"

#include <openvdb/openvdb.h>

namespace volcaustic {

class HashedFile;

/// Writes what openvdb::io::File would, byte for byte but for the UUID: Blosc (zip where OpenVDB lacks it), only active
/// values where the others follow from them, statistics and sizes for delayed loading, trees that grids share once.
/// OpenVDB compresses every leaf twice and, while it writes, on one thread; here each is compressed once, by whoever is
/// free. The UUID is a hash of all other bytes, offsets left out, so that the same grids give the same file, and
/// different ones (nearly) always different UUIDs, which is what readers use it for.
/// Takes the compressed size of the largest grid in memory. \throws std::ios::failure when a write fails
void writeArchive(HashedFile& file, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata,
                  const RunContext& ctx);

} // namespace volcaustic
