#include "core/nearest_word.h"

#include <algorithm>
#include <cctype>
#include <limits>
#include <numeric>

namespace volcaustic {

namespace {

std::size_t editDistance(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (lower(a[i]) != lower(b[j]) ? 1 : 0);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

} // namespace

std::string nearestWord(std::string_view word, const std::vector<std::string>& candidates) {
  constexpr std::size_t kLongest = 256; // no key is longer; bounds the work on hostile input
  word = word.substr(0, kLongest);
  std::string nearest;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : candidates)
    if (const std::size_t distance = editDistance(word, std::string_view(candidate).substr(0, kLongest));
        distance < least) {
      least = distance;
      nearest = candidate;
    }
  return nearest;
}

} // namespace volcaustic
