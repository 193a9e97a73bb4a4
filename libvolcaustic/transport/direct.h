// Direct light: not traced. Which lamps light a brick is found here; how much light that is, is evaluated where it is
// asked for. Only bricks through which an edge of a shadow runs are given voxels.
#pragma once

#include "kernels/emission.h"
#include "transport/soft_lights.h"
#include "volcaustic/photons.h"
#include "volume/flatten.h"
#include "volume/radiance_bricks.h"

#include <memory>
#include <span>

namespace volcaustic {

/// Collects the rasters of a pass.
class DirectLightBuilder {
public:
  DirectLightBuilder(const FlatMediumStorage& flat, const Domain& domain, std::span<const LightPart> lights,
                     const RunContext& ctx);
  ~DirectLightBuilder();

  /// A raster of part number `light`. `entry` is its map of first bends: the same rays that decide which photons are
  /// traced decide here how much of a voxel their straight parts cover, so that direct and caustic light add up without
  /// gap or overlap.
  void add(int light, const kernels::EmissionFrame& frame, std::span<const float> entry);
  /// Once, after all rasters. Edges are smoothed by the Gaussian that the caustic gets where `smooth` says so.
  void finish(bool smooth, DirectLight& direct);

private:
  class Impl;
  std::unique_ptr<Impl> mImpl;
};

} // namespace volcaustic
