// Frame ranges on the command line.
#pragma once

#include <volcaustic/frames.h>

#include <string>
#include <vector>

namespace volcaustic::cli {

/// "7", "1-24" or "1-24x2" as the frames in it.
/// \throws Error(Usage).
std::vector<int> parseFrames(const std::string& text);

/// A file and what is made of it.
struct FilePair {
  std::string in, out;
  int frame = 1;
};
/// The pair itself without `frames`; else one for each of them, its number in the places of both names.
/// \throws Error(Usage) for a place without frames, and for frames without a place in `in`.
std::vector<FilePair> framePairs(const std::string& in, const std::string& out, const std::string& frames);

} // namespace volcaustic::cli
