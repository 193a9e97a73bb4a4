// Lights that are no points in the sky or in space, as sharp lights that stand for parts of them.
#pragma once

#include "volcaustic/photons.h"

#include <span>
#include <vector>

namespace volcaustic {

/// A sharp light.
struct LightPart {
  Light light; ///< softness 0
  int number;  ///< of the light that it is a part of
  int part;    ///< 0, 1, ... of that light
};

/// Sharp lights that are their own part, and `samples` parts of equal power of each soft one
/// (docs/algorithms/photons.md, "Soft lights"): directions spread evenly over a disc in the sky, or points in a ball
/// that looks like an even disc from everywhere. The same parts every time. \throws Error(Usage) "lights[i]: ..." for
/// softness that makes no sense.
std::vector<LightPart> partsOf(std::span<const Light> lights);

} // namespace volcaustic
