#include "frames.h"

#include <volcaustic/error.h>

#include <regex>

namespace volcaustic::cli {

std::vector<int> parseFrames(const std::string& text) {
  static const std::regex kRange("([0-9]{1,8})(?:-([0-9]{1,8})(?:x([0-9]{1,8}))?)?");
  std::smatch match;
  if (!std::regex_match(text, match, kRange))
    throw Error(ErrorKind::Usage, "--frames " + text + ": is not a range; write it as 7, 1-24 or 1-24x2");
  const int first = std::stoi(match[1]);
  const int last = match[2].matched ? std::stoi(match[2]) : first;
  const int step = match[3].matched ? std::stoi(match[3]) : 1;
  if (last < first || step < 1)
    throw Error(ErrorKind::Usage,
                "--frames " + text + ": is empty; give the first frame first and a step of 1 or more");
  std::vector<int> frames;
  for (int frame = first; frame <= last; frame += step) frames.push_back(frame);
  return frames;
}

std::vector<FilePair> framePairs(const std::string& in, const std::string& out, const std::string& frames) {
  if (frames.empty()) {
    if (hasFramePlace(out)) throw Error(ErrorKind::Usage, out + ": has a place for a frame number; give --frames");
    return {{in, out}};
  }
  if (!hasFramePlace(in))
    throw Error(ErrorKind::Usage,
                "--frames: " + in + " has no place for the frame's number; write it as name.####.vdb");
  if (out == "-") throw Error(ErrorKind::Usage, "--frames: each frame needs a file; - is standard output");
  std::vector<FilePair> pairs;
  for (const int frame : parseFrames(frames))
    pairs.push_back({withFrame(in, frame), withFrame(framePattern(out), frame), frame});
  return pairs;
}

} // namespace volcaustic::cli
