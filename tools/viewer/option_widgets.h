// Every described option of a scene as a widget: one more reader of volcaustic/options.h.
#pragma once

#include <volcaustic/scene.h>

namespace volcaustic::viewer {

/// What a person has done with widgets in this frame.
struct Edited {
  bool changed = false;  ///< the scene is another one
  bool finished = false; ///< the hand has let go: this is one step to undo
};

/// Widgets for the whole scene, section by section.
Edited sceneWidgets(Scene& scene);

} // namespace volcaustic::viewer
