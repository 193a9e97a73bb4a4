// Grids of any lattice onto the voxels of a domain.
#pragma once

#include "volcaustic/openvdb.h"
#include "volcaustic/run_context.h"

#include <string>

namespace volcaustic {

/// Edge of a voxel in world units below which OpenVDB takes a transform for singular.
inline constexpr double kSmallestVoxel = 1.45e-5;

/// Whether the voxels are cubes along the world's axes, mirrored by none of them.
bool isUpright(const openvdb::math::Transform& transform);
/// Whether a grid's index space is a mirror image of the world where its voxels are.
bool isMirrored(const openvdb::GridBase& grid);

/// Whether the grid's voxels are voxels of the domain's lattice, inside its box or not.
bool liesOnLattice(const openvdb::GridBase& grid, const Domain& domain);

/// A grid that lies on the domain's lattice, with the domain's transform: shifted by whole voxels where its own starts
/// elsewhere. For Float and Vec3S grids.
template <class GridType>
typename GridType::Ptr shiftedOnto(const typename GridType::Ptr& grid, const Domain& domain);

/// Trilinear samples of a grid with any linear transform at the domain's voxel centres, means over several voxels where
/// the grid's are much smaller. For Float and Vec3S grids. \throws Error(Input) naming `place` when the result would
/// not fit in memory.
template <class GridType>
typename GridType::Ptr resampledOnto(const GridType& grid, const Domain& domain, const std::string& place,
                                     const RunContext& ctx);

} // namespace volcaustic
