// Between brick grids (the working form) and OpenVDB grids (the form at the borders).
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/openvdb.h"
#include "volcaustic/run_context.h"

namespace volcaustic {

/// Bricks become leaves (all voxels active) where they vary and 8^3 tiles where they are one value other than the
/// background (coarser tiles where whole internal nodes agree); the background stays inactive. Voxels beyond the
/// domain's dims in edge bricks are set to the background, inactive.
openvdb::FloatGrid::Ptr toFloatGrid(const BrickGrid<float>& bricks, const Domain& domain, const char* name,
                                    const RunContext& ctx = {});
openvdb::Vec3SGrid::Ptr toVec3Grid(const BrickGrid<Vec3f>& bricks, const Domain& domain, const char* name,
                                   const RunContext& ctx = {});

/// The values of a grid over [0, dims) in index space; bricks of one value stay constant. Inactive values count as they
/// are.
BrickGrid<float> fromFloatGrid(const openvdb::FloatGrid& grid, const Vec3i& dims, const RunContext& ctx = {});
BrickGrid<Vec3f> fromVec3Grid(const openvdb::Vec3SGrid& grid, const Vec3i& dims, const RunContext& ctx = {});
/// The same values as bricks whose background is another one than the grid's.
BrickGrid<float> fromFloatGrid(const openvdb::FloatGrid& grid, const Vec3i& dims, float background,
                               const RunContext& ctx);
BrickGrid<Vec3f> fromVec3Grid(const openvdb::Vec3SGrid& grid, const Vec3i& dims, const Vec3f& background,
                              const RunContext& ctx);

} // namespace volcaustic
