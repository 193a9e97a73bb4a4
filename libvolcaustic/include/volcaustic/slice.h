/// \file slice.h
/// Planes through the volumes of a session, as numbers: what a viewer or a notebook shows of them.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/photons.h"
#include "volcaustic/types.h"

#include <vector>

namespace volcaustic {

struct FlatMediumStorage; // the medium as the kernels read it

enum class VolumeLayer {
  Radiance,    ///< fluence/4 pi, W/(m2 sr)
  Caustic,     ///< its part that was bent
  Direct,      ///< its part that was not
  Direction,   ///< mean direction, length at most 1
  Index,       ///< refractive index
  Attenuation, ///< extinction coefficient, 1/world
  Step,  ///< edge of the cube of the step field, which is crossed in one step; where steps are capped, the cap; voxels
  Energy ///< power taken from light here, absorbed and scattered, W/m3
};

struct SliceOptions {
  VolumeLayer layer = VolumeLayer::Radiance;
  int axis = 1;         ///< 0, 1, 2: across x, y or z
  double position = .5; ///< part of the domain along the axis, 0 to 1
};

/// One layer of voxels.
struct VolumeSlice {
  int columns = 0, rows = 0;
  /// Rows from the top, which is the greatest coordinate. Columns run along axis + 1, rows along axis + 2 (of x, y, z
  /// in a circle). A layer of numbers has them in all three channels.
  std::vector<Vec3f> values;
  float least = 0, greatest = 0;  ///< over all channels
  std::array<Vec3d, 4> corners{}; ///< world: top left, top right, bottom right, bottom left
};

/// \throws Error(Usage) for an axis or a position out of range.
VOLCAUSTIC_API VolumeSlice sliceVolume(const FlatMediumStorage& medium, const PhotonResult& photons,
                                       const SliceOptions& options = {});

} // namespace volcaustic
