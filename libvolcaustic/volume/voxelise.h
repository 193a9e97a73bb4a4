// Solid coverage of one body by super-sampling (docs/algorithms/voxelise.md).
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/medium.h"

namespace volcaustic {

/// Coverage of one body over the bricks that it can reach: fractions of supersample^3 samples, 0 outside the patch.
struct CoveragePatch {
  Vec3i firstBrick{0, 0, 0}; ///< of the patch, in bricks of the domain
  BrickGrid<float> coverage; ///< over whole bricks, also beyond the domain's far faces
};

/// Decides inside and outside by `fill` at one sample in each of supersample^3 sub-voxels. Time and memory grow with
/// the surface and the number of bricks. With FillRule::Auto a mesh that is not closed is warned of. \throws
/// Error(Input) naming the body: no triangle, an index out of range, a coordinate that is not finite or absurd; with
/// FillRule::Exact a mesh that is not closed.
CoveragePatch voxeliseBody(const Body& body, const Domain& domain, int supersample, FillRule fill,
                           const RunContext& ctx = {});

} // namespace volcaustic
