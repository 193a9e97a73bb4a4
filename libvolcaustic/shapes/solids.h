// Solids that are no quadrics, each by its distance, and functions placed in world space.
#pragma once

#include "shapes/function.h"
#include "volcaustic/shape.h"

#include <memory>

namespace volcaustic {

std::unique_ptr<ShapeFunction> makeCuboid(const shapes::Cuboid& cuboid);
std::unique_ptr<ShapeFunction> makeTorus(const shapes::Torus& torus);
std::unique_ptr<ShapeFunction> makeCapsule(const shapes::Capsule& capsule);

/// A function whose values are lengths of its own space, in world space: times the least factor by which the placement
/// stretches lengths, so that of a distance comes out a distance, or less where the placement stretches unevenly.
std::unique_ptr<ShapeFunction> placedFunction(std::unique_ptr<ShapeFunction> local, const Affine& toWorld);

} // namespace volcaustic
