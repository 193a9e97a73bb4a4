// NanoVDB files: the one place that knows NanoVDB's changing headers.
#pragma once

#include "volcaustic/run_context.h"

#include <iosfwd>
#include <openvdb/openvdb.h>
#include <string>

namespace volcaustic {

/// Every grid of a .nvdb as an OpenVDB grid; quantised floats become floats. Checks the file's claims against its size,
/// then node offsets, but is still meant for the guarded child alone. Serial. \throws Error(Input).
openvdb::GridPtrVec readNanoVdb(const std::string& path);

/// Writes the grids, Blosc-compressed. `place` names the file in messages.
/// \throws Error(Input) naming a grid of a type that NanoVDB cannot hold.
void writeNanoVdb(std::ostream& out, const openvdb::GridPtrVec& grids, const std::string& place, const RunContext& ctx);

} // namespace volcaustic
