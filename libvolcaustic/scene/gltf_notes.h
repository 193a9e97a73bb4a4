// What a glTF file holds and a scene cannot: told once for each matter, however often it occurs.
#pragma once

#include "scene/gltf_value.h"
#include "volcaustic/run_context.h"

#include <string>
#include <vector>

namespace volcaustic {

class GltfNotes {
public:
  /// `matter` is what is wrong and what is done about it, at `place` and perhaps elsewhere.
  void add(const GltfValue& place, const std::string& matter);
  /// One warning for each matter, 32 at most, "file:/pointer (and 3 more): matter".
  void report(const std::string& file, const RunContext& ctx) const;

private:
  struct Note {
    std::string matter, pointer;
    std::size_t count;
  };
  std::vector<Note> mNotes;
};

} // namespace volcaustic
