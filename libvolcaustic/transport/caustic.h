// The caustic part of the light: what the tracers' sums are turned into.
#pragma once

#include "backends/photon_tracer.h"
#include "volume/flatten.h"
#include "volume/fluence_grid.h"

namespace volcaustic {

/// Fluence of a finished tracer's sums, smoothed where asked for. Returns what the medium takes of that light, W.
Rgb gatherCaustic(const PhotonTracer& tracer, const FlatMediumStorage& flat, double voxelSize, const FixedPoint& scale,
                  bool smooth, FluenceGrid& caustic, const RunContext& ctx);

} // namespace volcaustic
