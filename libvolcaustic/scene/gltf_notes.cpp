#include "scene/gltf_notes.h"

#include <algorithm>

namespace volcaustic {

namespace {
constexpr std::size_t kMostMatters = 32; // nobody reads more
} // namespace

void GltfNotes::add(const GltfValue& place, const std::string& matter) {
  const auto known = std::find_if(mNotes.begin(), mNotes.end(), [&](const Note& n) { return n.matter == matter; });
  if (known == mNotes.end() && mNotes.size() == kMostMatters) return;
  if (known == mNotes.end())
    mNotes.push_back({matter, place.pointer().empty() ? "/" : place.pointer(), 1});
  else
    ++known->count;
}

void GltfNotes::report(const std::string& file, const RunContext& ctx) const {
  for (const Note& note : mNotes) {
    const std::string others = note.count > 1 ? " (and " + std::to_string(note.count - 1) + " more)" : "";
    ctx.warn(file + ":" + note.pointer + others + ": " + note.matter);
  }
}

} // namespace volcaustic
