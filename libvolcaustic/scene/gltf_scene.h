// A glTF 2.0 file as a scene document: docs/formats.md says what becomes of what.
#pragma once

#include "scene/scene_json.h"

namespace volcaustic {

/// The document that a scene file of the same content would hold, with names of meshes relative to the file's folder.
/// \throws Error(File), Error(Input) "file:/pointer: ...", Error(Usage) for a camera that is not there.
Json gltfSceneDocument(const std::filesystem::path& path, const SceneReadOptions& options, const RunContext& ctx);

} // namespace volcaustic
