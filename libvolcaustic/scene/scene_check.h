// What the range of a single field cannot say about a scene.
#pragma once

#include "scene/scene_source.h"
#include "volcaustic/scene.h"

namespace volcaustic {

/// \throws Error at the JSON pointer of the first field that contradicts another one.
void checkScene(const Scene& scene, const SceneSource& source);

} // namespace volcaustic
