// Light that reaches receivers straight.
#pragma once

#include "kernels/emission.h"
#include "transport/receiver_set.h"
#include "transport/soft_lights.h"
#include "volcaustic/medium.h"

#include <span>

namespace volcaustic {

/// Adds the irradiance (W/m2, three floats a texel) of a light's part through one of its rasters. See
/// ReceiverLight::addDirect.
void addDirectLight(const ReceiverSet& set, const Domain& domain, const Ambient& ambient, const LightPart& part,
                    const kernels::EmissionFrame& frame, std::span<const float> entry, std::span<float> irradiance,
                    const RunContext& ctx);

} // namespace volcaustic
