// The storage behind RadianceVolume: three sparse fields over the domain's bricks.
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/types.h"

namespace volcaustic {

struct RadianceBricks {
  BrickGrid<Vec3f> direct;    ///< fluence of light that never met a bend, W/m2, RGB
  BrickGrid<Vec3f> caustic;   ///< fluence of traced photons, W/m2, RGB
  BrickGrid<Vec3f> direction; ///< luminance-weighted mean propagation direction of both, |d| <= 1
};

} // namespace volcaustic
