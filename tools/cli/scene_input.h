// Scenes from files or standard input, and checks that need the file system.
#pragma once

#include <volcaustic/scene.h>

#include <string>

namespace volcaustic::cli {

/// readScene, where "-" is standard input.
Scene readSceneArgument(const std::string& path, const SceneReadOptions& options);

} // namespace volcaustic::cli
