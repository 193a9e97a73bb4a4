#include "volcaustic/frames.h"

#include <cstdlib>
#include <filesystem>

namespace volcaustic {

namespace {

/// Where the number stands in a name, and to how many digits; of length 0 where there is no such place.
struct FramePlace {
  std::size_t begin, length;
  int width;
};

bool isDigit(char c) { return c >= '0' && c <= '9'; }

FramePlace framePlace(const std::string& name) {
  const auto at = [&](std::size_t i) { return i < name.size() ? name[i] : '\0'; };
  for (std::size_t i = 0; i < name.size(); ++i) {
    std::size_t end = i;
    while (at(end) == '#') ++end;
    if (end > i) return {i, end - i, static_cast<int>(end - i)};
    if (at(end++) != '%') continue;
    if (at(end) == '0') ++end;
    const int width = isDigit(at(end)) ? at(end++) - '0' : 1;
    if (at(end) == 'd') return {i, end + 1 - i, width};
  }
  return {0, 0, 0};
}

std::string zeroPadded(int number, int width) {
  std::string digits = std::to_string(std::abs(number));
  const int missing = width - static_cast<int>(digits.size()) - (number < 0);
  if (missing > 0) digits.insert(0, static_cast<std::size_t>(missing), '0');
  return number < 0 ? "-" + digits : digits;
}

} // namespace

bool hasFramePlace(const std::string& path) {
  return framePlace(std::filesystem::path(path).filename().string()).length > 0;
}

std::string withFrame(const std::string& path, int frame) {
  std::string name = std::filesystem::path(path).filename().string();
  const FramePlace place = framePlace(name);
  if (place.length == 0) return path;
  name.replace(place.begin, place.length, zeroPadded(frame, place.width));
  return std::filesystem::path(path).replace_filename(name).string();
}

std::string framePattern(const std::string& path) {
  if (hasFramePlace(path)) return path;
  std::filesystem::path pattern(path);
  pattern.replace_extension(".####" + pattern.extension().string());
  return pattern.string();
}

} // namespace volcaustic
