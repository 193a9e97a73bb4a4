// Fluence bricks as radiance grids and back.
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/openvdb.h"
#include "volume/radiance_bricks.h"

namespace volcaustic {

/// Spherical mean radiance of a fluence, L = fluence / 4 pi, times a factor of exposure.
float radianceOf(float fluence, double factor);
/// A fluence whose radianceOf is exactly `radiance` where there is one (of float's several or none, when rounding
/// differs).
float fluenceOf(float radiance, double factor);

/// Every value of `a` and `b` (same dims) combined: constant where both bricks are.
BrickGrid<Vec3f> combined(const BrickGrid<Vec3f>& a, const BrickGrid<Vec3f>& b, const RunContext& ctx,
                          const std::function<Vec3f(const Vec3f&, const Vec3f&)>& combine);

/// Radiance of every voxel of a fluence, times a factor of exposure.
BrickGrid<Vec3f> radianceBricks(BrickGrid<Vec3f> fluence, double factor, const RunContext& ctx);
/// A fog volume of values that do not turn with the volume.
openvdb::Vec3SGrid::Ptr lightGrid(const BrickGrid<Vec3f>& values, const Domain& domain, const char* name);
/// The mean direction: vectors that keep their length and turn with the volume.
openvdb::Vec3SGrid::Ptr directionGrid(const BrickGrid<Vec3f>& direction, const Domain& domain);
/// Bricks of fluence from a radiance grid.
BrickGrid<Vec3f> fluenceBricks(const openvdb::Vec3SGrid& radiance, const Vec3i& dims, double factor,
                               const RunContext& ctx);

} // namespace volcaustic
