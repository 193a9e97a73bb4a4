// Smooth noise that moves surfaces.
#pragma once

#include "shapes/function.h"
#include "volcaustic/shape.h"

#include <memory>

namespace volcaustic {

/// Gradient noise in octaves: values are lengths between -amplitude and amplitude, and twice continuously
/// differentiable.
std::unique_ptr<ShapeFunction> makeNoise(const shapes::NoiseDisplacement& noise);

} // namespace volcaustic
