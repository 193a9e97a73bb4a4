// Separable filters over planes of pixels; beyond its border a plane goes on as its last pixel.
#pragma once

#include "volcaustic/run_context.h"

#include <cstddef>
#include <vector>

namespace volcaustic {

/// Rows from the top, width*height floats.
using Plane = std::vector<float>;

struct PlaneSize {
  std::size_t width = 0, height = 0;
};

/// Weights of an odd number of neighbours side by side, the middle one at the pixel itself.
using FilterWeights = std::vector<float>;

/// One pass along x, one along y. A filter has the same sums whatever the number of threads.
Plane filtered(const Plane& plane, PlaneSize size, const FilterWeights& alongX, const FilterWeights& alongY,
               const RunContext& ctx);

} // namespace volcaustic
