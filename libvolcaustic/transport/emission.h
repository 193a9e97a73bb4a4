// Lights as the kernels see them: rasters in grid space over the domain's box.
#pragma once

#include "kernels/emission.h"
#include "volcaustic/photons.h"

#include <optional>
#include <string>
#include <vector>

namespace volcaustic {

/// \throws Error(Usage) "lights[number] (name): what"
[[noreturn]] void refuseLight(const Light& light, int number, const std::string& what);

/// The cone of a light; a sphere for those that are no spots.
kernels::Cone coneOf(const Light& light);

/// The rasters of a light: one for parallel light and for a point outside the box that sees it under a moderate angle,
/// the six faces of a cube for a point inside or close by. Those of a spot end where its cone does; it has none where
/// that misses the box. `light` numbers the light, so that jitter differs between
/// lights. \throws Error(Usage) "lights[i]: ..." for directions, positions and powers that make no sense.
std::vector<kernels::EmissionFrame> emissionFrames(const Light& light, int number, const Domain& domain,
                                                   const PhotonOptions& options, std::uint64_t seed);

/// World to grid space.
inline kernels::Double3 toGrid(const Domain& domain, const Vec3d& pWorld) {
  return {(pWorld[0] - domain.minCorner[0]) / domain.voxelSize, (pWorld[1] - domain.minCorner[1]) / domain.voxelSize,
          (pWorld[2] - domain.minCorner[2]) / domain.voxelSize};
}

/// Where the ray of a raster through a point crosses the raster's plane, in its units, and how far along the ray the
/// point is from the frame's origin.
struct RasterPlace {
  double u, v, depth;
};
/// Nothing for a point behind a point light's tangent plane.
std::optional<RasterPlace> placeOnRaster(const kernels::EmissionFrame& frame, const kernels::Double3& p);

} // namespace volcaustic
