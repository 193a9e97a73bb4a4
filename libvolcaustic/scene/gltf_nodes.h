// The node tree of a glTF file in world space.
#pragma once

#include "scene/gltf_animation.h"
#include "volcaustic/scene.h"

#include <vector>

namespace volcaustic {

struct GltfNode {
  GltfValue place;
  Affine world;
};

/// The nodes of the file's scene, parents before children, children in their order. Without a time, at rest.
/// \throws Error(Input) where nodes do not make trees, or have no affine placement.
std::vector<GltfNode> gltfNodes(GltfFile& file, std::optional<double> seconds, GltfNotes& notes);

/// The placement whose affine() is `world`, but for rounding; nothing where that flattens.
std::optional<Placement> placementOf(const Affine& world);

} // namespace volcaustic
