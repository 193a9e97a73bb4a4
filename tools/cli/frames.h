// Frame ranges on the command line.
#pragma once

#include <volcaustic/frames.h>

#include <string>
#include <vector>

namespace volcaustic::cli {

/// "7", "1-24" or "1-24x2" as the frames in it.
/// \throws Error(Usage).
std::vector<int> parseFrames(const std::string& text);

} // namespace volcaustic::cli
