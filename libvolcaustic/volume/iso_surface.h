// From a grid to triangles: OpenVDB's dual contouring, in the form that meshes have here.
#pragma once

#include "volcaustic/mesh.h"

#include <cmath>
#include <openvdb/openvdb.h>

namespace volcaustic {

/// A value moved away from the isovalue, on its own side, to where the surface passes at least a hundredth of the way
/// to a neighbour that differs by `difference`. At the voxel itself the surfaces of all cells around it would meet:
/// their vertices would be one point, and the triangles between them have no area.
inline float clearOf(float isovalue, float value, float difference) {
  constexpr float kClear = 1 / 128.0f;
  const float least = kClear * difference;
  if (!(std::abs(value - isovalue) < least)) return value;
  return value < isovalue ? isovalue - least : isovalue + least;
}

/// The surface where the grid passes `isovalue`, in world space through whatever transform the grid has. The side of
/// the background is outside. Closed and consistently wound, no triangle without area. Not thinner than rounding allows
/// in index space, however far the grid lies from the origin. \throws Error(Input) naming `place` for values that are
/// not finite and for more surface than memory.
Mesh isoSurface(const openvdb::FloatGrid& grid, double isovalue, double adaptivity, const std::string& place,
                const RunContext& ctx);

} // namespace volcaustic
