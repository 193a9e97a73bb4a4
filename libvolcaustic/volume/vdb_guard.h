// The part of reading a .vdb that runs in the guarded child.
#pragma once

#include "volume/vdb_file.h"

#include <iosfwd>

namespace volcaustic {

enum class VdbFormat { OpenVdb, NanoVdb };

/// Tells the format by the first bytes. \throws Error(Input) for anything else.
VdbFormat vdbFormat(const std::string& path);

/// Parses the selected grids and writes them as a plain uncompressed OpenVDB stream. Only for the guarded child.
void normaliseVdb(const std::string& path, VdbFormat format, const GridSelection& selection, std::ostream& out);

} // namespace volcaustic
