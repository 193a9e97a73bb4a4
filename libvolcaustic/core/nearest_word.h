// The known word that a misspelled one most likely stands for.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace volcaustic {

/// The candidate of least edit distance (Levenshtein, letter case ignored); the first of several, empty when there is
/// none.
std::string nearestWord(std::string_view word, const std::vector<std::string>& candidates);

} // namespace volcaustic
