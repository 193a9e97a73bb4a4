// Brushes: points in a ball are moved, fading towards its border.
#pragma once

#include "deform/surface.h"
#include "volcaustic/deform.h"

namespace volcaustic {

/// Square of the distance from the center to a point at rest, in radii: up to 1 in the ball.
double ballPart(const Deformer& deformer, const Vec3d& rest);

/// Moves `points` of the surface by one brush.
/// \param place starts the message of an error
/// \throws Error(Usage) where Push or Pull finds no direction to go.
void applyBrush(std::vector<Vec3d>& points, const DeformSurface& surface, const Deformer& brush,
                const std::string& place, const RunContext& ctx);

} // namespace volcaustic
