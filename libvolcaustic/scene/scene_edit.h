// Changes to a document before it is read: values set from outside and animation tracks.
#pragma once

#include "scene/json_document.h"
#include "scene/scene_source.h"

#include <string>
#include <vector>

namespace volcaustic {

/// What a document may hold, and what it means where it says nothing.
struct DocumentKind {
  const Json& schema;   ///< JSON Schema, with what it refers to under $defs
  const Json& defaults; ///< a document, as whole as can be
};

/// Applies sets ("photons.grid=[512,512]") in order and notes them in `source`, and replaces each animated value by its
/// track's value at `frame`; the section "animation" goes. Tracks are [frame, value] pairs in order of frame, linear in
/// between, constant outside. They can be set too, and a value that is set wins over its track.
/// \throws Error(Input) at a track's pointer; Error(Usage) for a set without '=' or with no such place, naming the
/// nearest known one.
void applyEdits(Json& document, const std::vector<std::string>& sets, double frame, const DocumentKind& kind,
                SceneSource& source);

} // namespace volcaustic
