/// \file placement.h
/// Where and how large something is, in numbers that people write and keys animate.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/types.h"

namespace volcaustic {

/// Shear, then scale, then rotate about x, y and z in that order (degrees), then translate: every affine placement that
/// flattens nothing.
struct Placement {
  Vec3d translate{0, 0, 0};
  Vec3d rotate{0, 0, 0};
  Vec3d scale{1, 1, 1};
  Vec3d shear{0, 0, 0}; ///< added to x for each y, to x for each z, to y for each z
};
VOLCAUSTIC_API Affine affine(const Placement& placement);

} // namespace volcaustic
