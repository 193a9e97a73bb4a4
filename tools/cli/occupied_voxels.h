// How much of a medium its bodies fill.
#pragma once

#include <volcaustic/medium.h>

#include <cstdint>

namespace volcaustic::cli {

/// Voxels with a solid fraction above 0.
std::int64_t occupiedVoxels(const Medium& medium);
/// Sum of the solid fractions times the volume of a voxel, in world units cubed.
double coveredVolume(const Medium& medium);

} // namespace volcaustic::cli
