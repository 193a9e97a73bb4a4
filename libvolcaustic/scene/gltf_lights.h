// Lights and cameras of a glTF file's nodes.
#pragma once

#include "scene/gltf_nodes.h"

namespace volcaustic {

/// The lights of KHR_lights_punctual that the nodes hold, in watts. \throws Error(Input) at their pointers.
std::vector<Light> gltfLights(const GltfFile& file, const std::vector<GltfNode>& nodes);

/// The first perspective camera that the nodes hold, or the one that is called `name` (its node's name or its own).
/// \throws Error(Usage) when no camera is called so.
std::optional<Camera> gltfCamera(const GltfFile& file, const std::vector<GltfNode>& nodes, const std::string& name,
                                 GltfNotes& notes);

/// Looks at a box from the front (+z, as glTF's assets face) and a little from above, so that all of it is seen.
Camera cameraAround(const Box& box);

} // namespace volcaustic
