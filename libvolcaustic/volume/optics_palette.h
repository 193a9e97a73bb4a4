// The optics of a medium as the kernels read them: distinct ones once each, bricks and voxels refer to them by number.
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/run_context.h"
#include "volume/flatten.h"

namespace volcaustic {

/// The three grids over one domain; the background of each is the ambient value.
struct OpticsGrids {
  const BrickGrid<Vec3f>&attenuation, &scattering; ///< 1/world
  const BrickGrid<float>& asymmetry;
};

/// Fills opticsSlots, voxelOptics, optics and attenuates. Entries are numbered in the order in which the domain's
/// bricks and their voxels name them first. Returns the bricks whose optics are not the ambient ones all over, in
/// order.
std::vector<std::int64_t> packOptics(const OpticsGrids& grids, double voxelSize, FlatMediumStorage& flat,
                                     const RunContext& ctx);

} // namespace volcaustic
