// A medium in the making, between the machine that built it and whoever asks for its grids.
#pragma once

#include "core/brick_grid.h"

#include <optional>

namespace volcaustic {

/// A grid that would be the ambient value everywhere is absent.
struct OpticsBricks {
  BrickGrid<float> index, coverage;
  std::optional<BrickGrid<Vec3f>> attenuation, scattering;
  std::optional<BrickGrid<float>> asymmetry;
};

} // namespace volcaustic
