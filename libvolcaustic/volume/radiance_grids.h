// Fluence bricks as radiance grids and back.
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/openvdb.h"
#include "volume/radiance_bricks.h"

namespace volcaustic {

/// Spherical mean radiance of a fluence, L = fluence / 4 pi, times a factor of exposure.
float radianceOf(float fluence, double factor);

/// Every value of `a` and `b` (same dims) combined: constant where both bricks are.
BrickGrid<Vec3f> combined(const BrickGrid<Vec3f>& a, const BrickGrid<Vec3f>& b, const RunContext& ctx,
                          const std::function<Vec3f(const Vec3f&, const Vec3f&)>& combine);

/// Radiance of every voxel's light, times a factor of exposure: of all of it, or of a part.
BrickGrid<Vec3f> radianceBricks(const RadianceBricks& light, double factor, const RunContext& ctx);
BrickGrid<Vec3f> causticBricks(const RadianceBricks& light, double factor, const RunContext& ctx);
BrickGrid<Vec3f> directBricks(const RadianceBricks& light, double factor, const RunContext& ctx);
/// Mean direction of every voxel's light.
BrickGrid<Vec3f> directionBricks(const RadianceBricks& light, const RunContext& ctx);
/// A fog volume of values that do not turn with the volume.
openvdb::Vec3SGrid::Ptr lightGrid(const BrickGrid<Vec3f>& values, const Domain& domain, const char* name);
/// The mean direction: vectors that keep their length and turn with the volume.
openvdb::Vec3SGrid::Ptr directionGrid(const BrickGrid<Vec3f>& direction, const Domain& domain);
/// Gives a dark volume the light of a radiance grid (times `factor`) that goes, on average, in `direction`.
void fillFluence(FluenceGrid& light, const openvdb::Vec3SGrid& radiance, const BrickGrid<Vec3f>& direction,
                 double factor, const RunContext& ctx);

} // namespace volcaustic
