// What is around the domain, as the kernels see it, and as lights that stand for it.
#pragma once

#include "kernels/background.h"
#include "volcaustic/background.h"

#include <string>
#include <vector>

namespace volcaustic {

/// The background in grid space, visible or not; points at its image. \throws Error(Usage) "place.up: ..." for one that
/// makes no sense, or whose map is not read yet.
kernels::Environment environmentOf(const Background& background, const std::string& place);

/// A part of all directions, as parallel light.
struct EnvironmentPart {
  Vec3d from;     ///< mean direction of its light, unit
  Rgb irradiance; ///< all of it, on a plane that faces it
};

/// At most `most` parts that have all light of all directions. Each is a rectangle of the map, and the one is divided
/// next, in two where that helps most, whose light gets closer to its mean directions by it: the light-weighted
/// variance of direction (Viriyothai, Debevec: Variance Minimization Light Probe Sampling, 2009). The same parts every
/// time; none of the dark.
std::vector<EnvironmentPart> environmentParts(const kernels::Environment& environment, int most, const RunContext& ctx);

} // namespace volcaustic
