// The materials of a glTF file as those of a scene.
#pragma once

#include "scene/gltf_file.h"
#include "scene/gltf_notes.h"
#include "volcaustic/medium.h"

#include <vector>

namespace volcaustic {

struct GltfMaterial {
  Material material;
  bool transmits = false;    ///< otherwise opaque: its surfaces are receivers
  Rgb albedo{0.8, 0.8, 0.8}; ///< of opaque ones
};

/// One for each of the file, of different names, and a last one for primitives that name none.
/// \throws Error(Input) for a value out of range.
std::vector<GltfMaterial> gltfMaterials(const GltfFile& file, GltfNotes& notes);

} // namespace volcaustic
