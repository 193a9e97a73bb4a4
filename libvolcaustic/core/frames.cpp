#include "volcaustic/frames.h"

#include <cstdlib>
#include <filesystem>
#include <regex>

namespace volcaustic {

namespace {

const std::regex& framePlace() {
  static const std::regex kPlace("#+|%0?([0-9]?)d");
  return kPlace;
}

std::string zeroPadded(int number, int width) {
  std::string digits = std::to_string(std::abs(number));
  const int missing = width - static_cast<int>(digits.size()) - (number < 0);
  if (missing > 0) digits.insert(0, static_cast<std::size_t>(missing), '0');
  return number < 0 ? "-" + digits : digits;
}

} // namespace

bool hasFramePlace(const std::string& path) {
  return std::regex_search(std::filesystem::path(path).filename().string(), framePlace());
}

std::string withFrame(const std::string& path, int frame) {
  const std::string name = std::filesystem::path(path).filename().string();
  std::smatch match;
  if (!std::regex_search(name, match, framePlace())) return path;
  const std::string place = match.str();
  const int width = place.front() == '#' ? static_cast<int>(place.size()) : match[1].length() ? std::stoi(match[1]) : 1;
  const std::string numbered = match.prefix().str() + zeroPadded(frame, width) + match.suffix().str();
  return std::filesystem::path(path).replace_filename(numbered).string();
}

std::string framePattern(const std::string& path) {
  if (hasFramePlace(path)) return path;
  std::filesystem::path pattern(path);
  pattern.replace_extension(".####" + pattern.extension().string());
  return pattern.string();
}

} // namespace volcaustic
