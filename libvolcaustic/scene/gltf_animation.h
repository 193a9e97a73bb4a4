// The animations of a glTF file, sampled at one time.
#pragma once

#include "scene/gltf_file.h"
#include "scene/gltf_notes.h"
#include "volcaustic/types.h"

#include <array>
#include <map>
#include <optional>

namespace volcaustic {

/// Of a node: what its own fields or an animation give it. Rotations are unit quaternions (x, y, z, w).
struct GltfPose {
  std::optional<Vec3d> translation, scale;
  std::optional<std::array<double, 4>> rotation;
};

/// The animated values of each node by its number, at `seconds`: all animations play together from their own zero;
/// where two move the same property, the first does. \throws Error(Input) at the pointer of a channel or sampler that
/// makes no sense.
std::map<std::size_t, GltfPose> gltfPoses(GltfFile& file, double seconds, GltfNotes& notes);

} // namespace volcaustic
