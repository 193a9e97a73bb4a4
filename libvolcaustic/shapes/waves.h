// Plane and ring waves that move surfaces.
#pragma once

#include "shapes/function.h"
#include "volcaustic/shape.h"

#include <memory>

namespace volcaustic {

std::unique_ptr<ShapeFunction> makeWaves(const shapes::WaveDisplacement& waves);

} // namespace volcaustic
