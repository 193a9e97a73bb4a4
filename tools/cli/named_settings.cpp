#include "named_settings.h"

#include <volcaustic/error.h>

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <vector>

namespace volcaustic::cli {

namespace {

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find(separator, begin)) != text.npos; begin = end + 1)
    parts.push_back(text.substr(begin, end - begin));
  parts.push_back(text.substr(begin));
  return parts;
}

template <class Number>
std::optional<Number> numberIn(std::string_view word, const FieldDoc& doc) {
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const auto x = static_cast<double>(value);
  const bool good =
      error == std::errc{} && end == word.data() + word.size() && std::isfinite(x) && x >= doc.min && x <= doc.max;
  return good ? std::optional(value) : std::nullopt;
}

} // namespace

bool FieldSetter::isCalled(std::string_view name) {
  mKeys += (mKeys.empty() ? "" : ", ") + std::string(name);
  return name == mKey && (mKnown = true);
}

void FieldSetter::operator()(const char* name, int& field, const FieldDoc& doc) {
  if (!isCalled(name)) return;
  const auto number = numberIn<int>(mValue, doc);
  if ((mGood = number.has_value())) field = *number;
}

void FieldSetter::operator()(const char* name, double& field, const FieldDoc& doc) {
  if (!isCalled(name)) return;
  const auto number = numberIn<double>(mValue, doc);
  if ((mGood = number.has_value())) field = *number;
}

void FieldSetter::operator()(const char* name, Rgb& field, const FieldDoc& doc) {
  if (!isCalled(name)) return;
  const std::vector<std::string_view> words = split(mValue, '/');
  mGood = words.size() == 1 || words.size() == field.size();
  for (std::size_t c = 0; mGood && c < field.size(); ++c) {
    const auto number = numberIn<double>(words[words.size() == 1 ? 0 : c], doc);
    if ((mGood = number.has_value())) field[c] = *number;
  }
}

std::string nameAndSettings(const char* flag, const std::string& text, const std::function<void(FieldSetter&)>& visit) {
  const std::string place = fmt::format("{} {}", flag, text);
  const std::size_t colon = text.rfind(':');
  const std::string name = text.substr(0, colon);
  if (name.empty()) throw Error(ErrorKind::Usage, place + ": begins with no name; write it as NAME:KEY=VALUE,...");
  if (colon == text.npos) return name;
  for (const std::string_view setting : split(std::string_view(text).substr(colon + 1), ',')) {
    const std::size_t equals = setting.find('=');
    const std::string_view key = setting.substr(0, equals);
    FieldSetter setter(key == "ior" ? "index" : key,
                       equals == setting.npos ? std::string_view{} : setting.substr(equals + 1));
    visit(setter);
    if (!setter.known())
      throw Error(ErrorKind::Usage, fmt::format("{}: '{}' is not a key; give {}", place, key, setter.keys()));
    if (!setter.good())
      throw Error(ErrorKind::Usage, fmt::format("{}: '{}' is not possible; give {} a number in its range, RGB as "
                                                "0.1/0.2/0.3",
                                                place, setting, key));
  }
  return name;
}

} // namespace volcaustic::cli
