#include "session/stage_key.h"

#include <unordered_map>

namespace volcaustic {

namespace {

constexpr std::size_t kListed = 16;

} // namespace

std::vector<std::string> StageKey::differences(const StageKey& other) const {
  std::unordered_map<std::string_view, std::uint64_t> others;
  for (const auto& [place, part] : other.mParts) others.emplace(place, part);
  std::vector<std::string> places;
  for (const auto& [place, part] : mParts) {
    const auto found = others.find(place);
    if (found == others.end() || found->second != part) places.push_back(place);
    if (found != others.end()) others.erase(found);
  }
  for (const auto& [place, part] : other.mParts)
    if (others.contains(place)) places.push_back(place);
  if (places.size() > kListed) {
    const std::string more = "and " + std::to_string(places.size() - kListed) + " more";
    places.resize(kListed);
    places.push_back(more);
  }
  return places;
}

} // namespace volcaustic
