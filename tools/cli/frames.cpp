#include "frames.h"

#include <volcaustic/error.h>

#include <filesystem>
#include <fmt/format.h>
#include <regex>

namespace volcaustic::cli {

namespace {
const std::regex kFramePlace("#+|%0?([0-9]?)d");
} // namespace

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

bool hasFramePlace(const std::string& path) {
  return std::regex_search(std::filesystem::path(path).filename().string(), kFramePlace);
}

std::string withFrame(const std::string& path, int frame) {
  const std::string name = std::filesystem::path(path).filename().string();
  std::smatch match;
  if (!std::regex_search(name, match, kFramePlace)) return path;
  const std::string place = match.str();
  const int width = place.front() == '#' ? static_cast<int>(place.size()) : match[1].length() ? std::stoi(match[1]) : 1;
  const std::string numbered = match.prefix().str() + fmt::format("{:0{}d}", frame, width) + match.suffix().str();
  return std::filesystem::path(path).replace_filename(numbered).string();
}

std::string framePattern(const std::string& path) {
  if (hasFramePlace(path)) return path;
  std::filesystem::path pattern(path);
  pattern.replace_extension(".####" + pattern.extension().string());
  return pattern.string();
}

} // namespace volcaustic::cli
