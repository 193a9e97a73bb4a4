// Pixel filters, made ready for the kernels.
#pragma once

#include "kernels/pixel_filter.h"
#include "volcaustic/view.h"

namespace volcaustic {

/// Where the samples of pixels lie: side^2 of them, as dense as the filter is high.
kernels::PixelSampler pixelSampler(PixelFilter filter, int side, std::uint64_t seed);

} // namespace volcaustic
