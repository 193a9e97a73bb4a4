// The curve that a profile stands for, as a closed chain of straight lines and circular arcs.
#pragma once

#include "volcaustic/shape.h"

#include <array>
#include <vector>

namespace volcaustic {

using Vec2d = std::array<double, 2>;

/// What becomes of a profile. Turned about the axis x = 0, its lines along that axis lie within the solid.
enum class ProfileUse { Extruded, Revolved };

/// From a point to the one that the next link begins with; the last link ends where the first begins.
struct ChainLink {
  Vec2d from;
  double bulge;        ///< as in shapes::Profile, -1 to 1: half a circle at most
  bool onAxis = false; ///< a line along the axis of a revolution: no surface
};

/// Arcs of more than half a circle come as two links. A smooth profile's curve has a tangent everywhere, but where a
/// revolution's meets the axis: there it stands upright on the axis, so that the solid is smooth.
std::vector<ChainLink> chainOf(const shapes::Profile& profile, ProfileUse use);

} // namespace volcaustic
