// Photons that landed on receivers, as power in texels: neighbours of the raster that land beside each other are the
// corners of a beam (docs/algorithms/receivers.md).
#pragma once

#include "kernels/emission.h"
#include "transport/receiver_set.h"

#include <cstdint>
#include <span>
#include <vector>

namespace volcaustic {

/// Power in texels in units of its own, so that it does not matter in which order it is added: three numbers a texel.
using TexelPower = LargeVector<std::int64_t>;

/// Adds the power (W, three floats a texel) of the photons of a raster, one landing for each cell. Nothing of it is
/// lost. `units` is zeros, three for each texel, and so afterwards.
void addLandedPower(const ReceiverSet& set, const kernels::EmissionFrame& frame,
                    std::span<const kernels::Landing> landings, TexelPower& units, std::span<float> power,
                    const RunContext& ctx);

} // namespace volcaustic
