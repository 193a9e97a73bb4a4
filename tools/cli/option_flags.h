// Command-line flags from the description of options (volcaustic/options.h): name, help, unit, range and default.
#pragma once

#include <volcaustic/options.h>

#include <algorithm>
#include <CLI/CLI.hpp>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace volcaustic::cli {

struct FlagChoice {
  std::set<std::string> only;                 ///< fields to offer; empty offers all
  std::map<std::string, std::string> aliases; ///< field -> a second name of its flag
};

/// "indexTolerance2" -> "index-tolerance2".
inline std::string kebabCase(std::string_view name) {
  std::string kebab;
  for (const char c : name)
    if (c >= 'A' && c <= 'Z')
      kebab += {'-', static_cast<char>(c - 'A' + 'a')};
    else
      kebab += c;
  return kebab;
}

/// Adds a flag for each described field; its default is the value that the field has now.
class FlagAdder {
public:
  FlagAdder(CLI::App& command, FlagChoice choice) : mCommand(command), mChoice(std::move(choice)) {}

  template <class T>
  void operator()(const char* name, T& value, const FieldDoc& doc) {
    if (!mChoice.only.empty() && !mChoice.only.contains(name)) return;
    std::string flag = "--" + kebabCase(name);
    if (const auto alias = mChoice.aliases.find(name); alias != mChoice.aliases.end()) flag += ",--" + alias->second;
    add(flag, value, doc);
  }

private:
  static std::string range(const FieldDoc& doc) {
    if (!doc.choices.empty()) return fmt::format("{}", fmt::join(doc.choices, ", "));
    const bool bounded = std::isfinite(doc.min) && std::isfinite(doc.max);
    return bounded ? fmt::format("{:g} to {:g}", doc.min, doc.max) : "";
  }

  static std::string help(const FieldDoc& doc, const std::string& standard, const std::string& possible) {
    std::string text = doc.text;
    if (*doc.unit && std::string_view(doc.unit) != "1") text += fmt::format(" [{}]", doc.unit);
    return text + (possible.empty() ? "" : "; " + possible) + fmt::format("; default {}", standard);
  }

  /// Checks each word of a number or an array of numbers.
  static CLI::Validator inRange(const FieldDoc& doc) {
    return {[doc](const std::string& word) -> std::string {
              double number = 0;
              const bool known = CLI::detail::lexical_cast(word, number) && std::isfinite(number) &&
                                 number >= doc.min && number <= doc.max;
              const bool chosen =
                  doc.choices.empty() || std::find(doc.choices.begin(), doc.choices.end(), number) != doc.choices.end();
              return known && chosen ? "" : fmt::format("{} is not possible; give {}", word, range(doc));
            },
            ""};
  }

  static std::string repeated(const std::string& word, std::size_t count) {
    std::string text = word;
    while (--count) text += " " + word;
    return text;
  }

  /// What is off by default gets --name, what is on gets --no-name.
  void add(const std::string& flag, bool& value, const FieldDoc& doc) {
    if (value)
      mCommand.add_flag("!--no-" + flag.substr(2), value, std::string("not: ") + doc.text);
    else
      mCommand.add_flag(flag, value, doc.text);
  }
  template <class T>
  requires std::is_arithmetic_v<T>
  void add(const std::string& flag, T& value, const FieldDoc& doc) {
    mCommand.add_option(flag, value, help(doc, fmt::format("{}", value), range(doc)))->check(inRange(doc));
  }
  template <class T, std::size_t N>
  void add(const std::string& flag, std::array<T, N>& value, const FieldDoc& doc) {
    const std::string standard = fmt::format("{}", fmt::join(value, " "));
    mCommand.add_option(flag, value, help(doc, standard, range(doc)))
        ->check(inRange(doc))
        ->option_text(repeated("FLOAT", N));
  }
  void add(const std::string& flag, std::string& value, const FieldDoc& doc) {
    mCommand.add_option(flag, value, doc.text);
  }
  void add(const std::string& flag, std::vector<std::string>& value, const FieldDoc& doc) {
    mCommand.add_option(flag, value, doc.text)->delimiter(',')->allow_extra_args(false)->option_text("A,B,...");
  }
  template <class T>
  requires std::is_enum_v<T>
  void add(const std::string& flag, T& value, const FieldDoc& doc) {
    constexpr auto kNames = enumNames(T{});
    const auto position = [kNames](const std::string& word) {
      return std::find(kNames.begin(), kNames.end(), word) - kNames.begin();
    };
    const std::string all = fmt::format("{}", fmt::join(kNames, ", "));
    const auto known = [position, kNames, all](const std::string& word) {
      return position(word) < std::ssize(kNames) ? "" : fmt::format("{} is not possible; give {}", word, all);
    };
    mCommand
        .add_option_function<std::string>(
            flag, [&value, position](const std::string& word) { value = static_cast<T>(position(word)); },
            help(doc, kNames[static_cast<std::size_t>(value)], all))
        ->check(CLI::Validator(known, ""));
  }

  CLI::App& mCommand;
  FlagChoice mChoice;
};

template <class Options>
void addFlags(CLI::App& command, Options& options, FlagChoice choice = {}) {
  describe(FlagAdder(command, std::move(choice)), options);
}

} // namespace volcaustic::cli
