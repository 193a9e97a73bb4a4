#include "script.h"

#include <volcaustic/error.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>

namespace volcaustic::viewer {

namespace {

/// Arguments of a command: n a number, i a whole number to a million, p a part from 0 to 1, w a word, * the rest of the
/// line as one word, o a part or off, r the word rough; those after a / are optional.
struct Syntax {
  std::string_view name, arguments, usage;
};
constexpr Syntax kCommands[] = {
    {"wait", "/r", "wait [rough]"},
    {"frames", "i", "frames COUNT"},
    {"move", "nn", "move X Y"},
    {"press", "/w", "press [left|right|middle]"},
    {"release", "", "release"},
    {"drag", "nnnn/w", "drag X0 Y0 X1 Y1 [left|right|middle]"},
    {"click", "nn", "click X Y"},
    {"scroll", "n", "scroll NOTCHES"},
    {"key", "w", "key [ctrl+]LETTER"},
    {"set", "*", "set PATH=VALUE"},
    {"select", "*", "select NAME"},
    {"layer", "w", "layer NAME"},
    {"slice", "w/wp", "slice LAYER AXIS POSITION (0 to 1), or slice off"},
    {"iso", "o", "iso VALUE (0 to 1), or iso off"},
    {"frame", "i", "frame NUMBER"},
    {"device", "w", "device NAME"},
    {"screenshot", "*", "screenshot FILE.png"},
    {"save", "*", "save FILE.json"},
    {"export", "*", "export FILE.vdb or FILE.exr"},
    {"undo", "", "undo"},
    {"redo", "", "redo"},
    {"quit", "", "quit"},
};

std::optional<double> parseNumber(const std::string& word) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

bool fits(char kind, const std::string& word) {
  const auto isNumber = [&](double least, double most, bool whole = false) {
    const std::optional<double> n = parseNumber(word);
    return n && *n >= least && *n <= most && (!whole || *n == std::floor(*n));
  };
  switch (kind) {
  case 'n':
    return isNumber(-1e9, 1e9);
  case 'i':
    return isNumber(-1e6, 1e6, true);
  case 'p':
    return isNumber(0, 1);
  case 'o':
    return word == "off" || isNumber(0, 1);
  case 'r':
    return word == "rough";
  default:
    return true;
  }
}

[[noreturn]] void fail(const std::string& name, int line, const std::string& what) {
  throw Error(ErrorKind::Usage, name + ":" + std::to_string(line) + ": " + what);
}

ScriptCommand parseLine(const std::string& text, const std::string& name, int line) {
  std::istringstream words(text);
  ScriptCommand command{line, "", {}};
  words >> command.name;
  const auto* const known =
      std::find_if(std::begin(kCommands), std::end(kCommands), [&](const Syntax& s) { return s.name == command.name; });
  if (known == std::end(kCommands)) {
    std::string all;
    for (const Syntax& s : kCommands) all += (all.empty() ? "" : ", ") + std::string(s.name);
    fail(name, line, "'" + command.name + "' is no command; there are " + all);
  }
  const std::string usage = "; write it as: " + std::string(known->usage);
  bool optional = false;
  for (const char kind : known->arguments) {
    if (kind == '/') {
      optional = true;
      continue;
    }
    std::string word;
    if (kind == '*')
      std::getline(words >> std::ws, word);
    else
      words >> word;
    if (word.empty()) {
      if (!optional) fail(name, line, command.name + " needs more words" + usage);
      break;
    }
    if (!fits(kind, word)) fail(name, line, "'" + word + "' does not fit" + usage);
    command.arguments.push_back(word);
  }
  std::string rest;
  if (words >> rest) fail(name, line, "'" + rest + "' is too much" + usage);
  return command;
}

} // namespace

double numberOf(const std::string& word) { return parseNumber(word).value_or(0); }

std::vector<ScriptCommand> parseScript(const std::string& text, const std::string& name) {
  std::vector<ScriptCommand> commands;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    for (std::size_t i = 0; i < line.size(); ++i) // in the midst of a word, # stands for itself
      if (line[i] == '#' && (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t')) line.resize(i);
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    commands.push_back(parseLine(line, name, number));
  }
  return commands;
}

std::vector<ScriptCommand> readScript(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ErrorKind::File, path.string() + ": cannot be opened");
  return parseScript({std::istreambuf_iterator<char>(file), {}}, path.string());
}

} // namespace volcaustic::viewer
