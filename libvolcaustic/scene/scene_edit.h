// Changes to a scene document before it is read: values set from outside and animation tracks.
#pragma once

#include "scene/json_document.h"
#include "scene/scene_source.h"

#include <string>
#include <vector>

namespace volcaustic {

/// Replaces each animated value of the document by its track's value at `frame`, and removes the section "animation".
/// Tracks are [frame, value] pairs in order of frame; linear in between, constant outside.
/// \throws Error(Input) at the track's pointer.
void applyAnimation(Json& document, double frame, const SceneSource& source);

/// Applies "photons.grid=[512,512]" to the document and notes it in `source`.
/// \throws Error(Usage) when there is no '=' or no such place; the message names the nearest known one.
void applySet(Json& document, const std::string& set, SceneSource& source);

} // namespace volcaustic
