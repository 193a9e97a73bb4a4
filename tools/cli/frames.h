// Frame ranges, and the names of the files of each frame.
#pragma once

#include <string>
#include <vector>

namespace volcaustic::cli {

/// "7", "1-24" or "1-24x2" as the frames in it.
/// \throws Error(Usage).
std::vector<int> parseFrames(const std::string& text);

/// True when the file name of `path` has a place for the frame number: a run of '#', or %d, %4d, %04d.
bool hasFramePlace(const std::string& path);
/// `path` with the place for the frame number replaced by the zero-padded number ("a.####.vdb" -> "a.0012.vdb").
std::string withFrame(const std::string& path, int frame);
/// `path`, with ".####" before its extension when it has no place for the frame number.
std::string framePattern(const std::string& path);

} // namespace volcaustic::cli
