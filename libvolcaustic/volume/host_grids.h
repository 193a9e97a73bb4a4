// What hosts make of volumes of light: which of the grids they use, and in how many bits.
#pragma once

#include "volcaustic/vdb.h"

#include <openvdb/openvdb.h>

namespace volcaustic {

/// Shallow copies of the grids that the host uses (docs/hosts.md), marked to be stored in 16 bits where that does;
/// media and volumes of others come through as they are.
openvdb::GridPtrVec gridsForHost(const openvdb::GridPtrVec& grids, HostPreset host);

} // namespace volcaustic
