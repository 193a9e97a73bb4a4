// From a grid to triangles: OpenVDB's dual contouring, in the form that meshes have here.
#pragma once

#include "volcaustic/mesh.h"

#include <openvdb/openvdb.h>

namespace volcaustic {

/// The surface where the grid passes `isovalue`, in world space through whatever transform the grid has. The side of
/// the background is outside. Closed and consistently wound. Not thinner than rounding allows in index space, however
/// far the grid lies from the origin. \throws Error(Input) naming `place` for values that are not finite and for more
/// surface than memory.
Mesh isoSurface(const openvdb::FloatGrid& grid, double isovalue, double adaptivity, const std::string& place,
                const RunContext& ctx);

} // namespace volcaustic
