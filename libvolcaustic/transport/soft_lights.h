// Lights that are no points in the sky or in space, as sharp lights that stand for parts of them.
#pragma once

#include "volcaustic/photons.h"

#include <span>
#include <vector>

namespace volcaustic {

/// A sharp light: parallel, from a point, a spot, or a point of an area light, whose cone is the half-space it faces.
struct LightPart {
  Light light;  ///< softness 0, not of the environment
  int number;   ///< of the light that it is a part of
  int part;     ///< 0, 1, ... of that light
  double share; ///< of that light's photons
};

/// Sharp lights that are their own part, and `samples` parts of equal power of each soft one
/// (docs/algorithms/photons.md, "Soft lights"): directions spread evenly over a disc in the sky, or points in a ball
/// that looks like an even disc from everywhere, or points of an area light. An environment becomes parallel lights,
/// each for a part of all directions (environment.h); half of its photons are shared evenly, half by luminance. The
/// same parts every time. \throws Error(Usage) "lights[i]: ..." for softness and surroundings that make no sense.
std::vector<LightPart> partsOf(std::span<const Light> lights, const RunContext& ctx = {});

} // namespace volcaustic
