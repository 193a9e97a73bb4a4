// Direct light: evaluated for each voxel, not traced.
#pragma once

#include "core/brick_grid.h"
#include "kernels/emission.h"
#include "volcaustic/photons.h"
#include "volume/flatten.h"

#include <span>
#include <vector>

namespace volcaustic {

/// Fluence in W/m2, and its luminance-weighted direction sum, of light on its straight way to the first bend.
struct DirectLight {
  BrickGrid<Vec3f> fluence;
  BrickGrid<Vec3f> direction;
  /// Of each brick: kEdge where some raster lights a part of it, else a number for which rasters light it. Empty
  /// without lights.
  std::vector<std::uint64_t> covers;
  static constexpr std::uint64_t kEdge = ~std::uint64_t{0};
};

/// Adds one raster of a light. `entry` is EmissionBody's distance map: the same rays that decide which photons are
/// traced decide here how much of a voxel their straight parts cover, so that direct and caustic light add up without
/// gap or overlap.
void addDirectLight(DirectLight& direct, const FlatMediumStorage& flat, const Domain& domain, const Light& light,
                    const kernels::EmissionFrame& frame, std::span<const float> entry, const RunContext& ctx);

} // namespace volcaustic
