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
/// bricks and their voxels name them first. Where they would be more than 2^17, as in smoke, attenuation, scattering
/// and asymmetry are rounded to 11 bits (off by 2^-12 of themselves at most), or to 9, 7, 5 or 3 where that is still
/// too many. Returns the bricks whose optics are not the ambient ones all over, in order. \throws Error(Input) for more
/// than 2^22 that differ in 3 bits.
std::vector<std::int64_t> packOptics(const OpticsGrids& grids, double voxelSize, FlatMediumStorage& flat,
                                     const RunContext& ctx);

} // namespace volcaustic
