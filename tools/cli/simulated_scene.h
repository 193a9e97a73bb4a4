// A scene file whose objects move as simulated bodies did: read as text, given keys, written elsewhere.
#pragma once

#include "report.h"

#include <volcaustic/scene.h>

#include <filesystem>
#include <span>
#include <vector>

namespace volcaustic::cli {

/// The placements of one object, one for each of the frames.
struct ObjectKeys {
  std::size_t object;
  std::vector<Placement> placements;
};

/// What is in the scene file `from` (of a glTF file what `scene` holds of it), with tracks for the objects that move,
/// with `frames`, and with relative paths that lead from the folder of `to`. Tracks that were there for the same places
/// give way. \throws Error(Input).
Json withKeys(const std::filesystem::path& from, const Scene& scene, const std::filesystem::path& to,
              std::span<const int> frames, double rate, std::span<const ObjectKeys> keys);

} // namespace volcaustic::cli
