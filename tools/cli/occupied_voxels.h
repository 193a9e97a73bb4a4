// How many voxels a medium's bodies fill or touch.
#pragma once

#include <volcaustic/medium.h>

#include <cstdint>

namespace volcaustic::cli {

/// Voxels with a solid fraction above 0.
std::int64_t occupiedVoxels(const Medium& medium);

} // namespace volcaustic::cli
