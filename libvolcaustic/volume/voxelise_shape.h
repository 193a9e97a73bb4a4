// Solid coverage of a functional object, without triangles (docs/algorithms/voxelise.md).
#pragma once

#include "volume/voxelise.h"

namespace volcaustic {

/// Coverage of `body.shape`, with a sample in the middle of each of supersample^3 sub-voxels. A shape's value is like a
/// distance, so a sub-voxel near the surface counts by the part of it that is inside: coverage has no steps, and is
/// exact where the surface is flat and faces an axis. Bricks and cubes of voxels that the shape's bounds decide are not
/// sampled. Warns of a body that is nowhere in the domain. \throws Error(Input) naming the body, for a shape without
/// end or beyond the memory limit.
CoveragePatch voxeliseShape(const Body& body, const Domain& domain, int supersample, const RunContext& ctx = {});

} // namespace volcaustic
