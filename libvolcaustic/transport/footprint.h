// Where a cube of voxels stands in a light's raster.
#pragma once

#include "kernels/emission.h"

namespace volcaustic {

/// Cells [u0, u1) x [v0, v1) of a raster that a cube's rays go through, and bounds of the distance along them at which
/// they do (relative to the frame's depth0).
struct Footprint {
  int u0, u1, v0, v1;
  double nearest, farthest;
  [[nodiscard]] bool empty() const { return u0 >= u1 || v0 >= v1; }
};

/// The cube [low, low + size] in grid space.
Footprint footprint(const kernels::EmissionFrame& frame, const kernels::Double3& low, double size);

} // namespace volcaustic
