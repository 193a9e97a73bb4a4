// Solids made of a profile: turned about the z axis, or pushed along it. Their values are distances.
#pragma once

#include "shapes/function.h"
#include "volcaustic/shape.h"

#include <memory>

namespace volcaustic {

std::unique_ptr<ShapeFunction> makeRevolution(const shapes::Revolution& revolution);
std::unique_ptr<ShapeFunction> makeExtrusion(const shapes::Extrusion& extrusion);

} // namespace volcaustic
