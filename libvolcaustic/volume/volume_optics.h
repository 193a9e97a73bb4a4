// Volumes made by others, blended into the ambient medium (docs/algorithms/voxelise.md).
#pragma once

#include "backends/optics_bricks.h"
#include "volcaustic/medium_volume.h"

#include <span>

namespace volcaustic {

/// Changes the ambient medium, which is all there is in `optics`, to what the volumes make of it; grids are added for
/// properties that they change. Bricks out of reach of every grid's own values stay one value.
/// \throws as buildMedium() of medium_volume.h
void addVolumes(OpticsBricks& optics, std::span<const MediumVolume> volumes, const Ambient& ambient,
                const Domain& domain, const RunContext& ctx = {});

} // namespace volcaustic
