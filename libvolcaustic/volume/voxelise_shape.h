// Solid coverage of a functional object, without triangles (docs/algorithms/voxelise.md).
#pragma once

#include "volume/voxelise.h"

namespace volcaustic {

/// Coverage of `body.shape` at the samples that voxeliseBody() takes of meshes: those at which the shape's value is 0
/// or more. Bricks and cubes of voxels that the shape's bounds decide are not sampled. Warns of a body without a
/// sample. \throws Error(Input) naming the body, for a shape without end or beyond the memory limit.
CoveragePatch voxeliseShape(const Body& body, const Domain& domain, int supersample, const RunContext& ctx = {});

} // namespace volcaustic
