// NanoVDB files: the one place that knows NanoVDB's changing headers.
#pragma once

#include "volcaustic/run_context.h"

#include <iosfwd>
#include <openvdb/openvdb.h>
#include <string>

namespace volcaustic {

/// Every grid of a .nvdb as an OpenVDB grid; quantised floats become floats. Checks the file's claims against its size,
/// then node offsets, but is still meant for the guarded child alone. The grids' metadata are those that writeNanoVdb
/// left there, if it did; those of the file are added to `metadata`. Serial. \throws Error(Input).
openvdb::GridPtrVec readNanoVdb(const std::string& path, openvdb::MetaMap& metadata);

/// Writes the grids, Blosc-compressed. NanoVDB itself keeps name, class and transform; all metadata of the grids, and
/// in the first of them those of the file, go along as blind data, which other readers pass over. With `half`, grids
/// of floats are quantised to 16 bits (Fp16); vectors cannot be, and the context is warned. `place` names the file in
/// messages. \throws Error(Input) naming a grid of a type that NanoVDB cannot hold.
void writeNanoVdb(std::ostream& out, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata, bool half,
                  const std::string& place, const RunContext& ctx);

} // namespace volcaustic
