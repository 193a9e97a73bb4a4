#include "script.h"

#include <volcaustic/error.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>

namespace volcaustic::viewer {

namespace {

/// Arguments of a command: n a number, w a word, * the rest of the line as one word; small ones after a / are optional.
struct Syntax {
  std::string_view name, arguments, usage;
};
constexpr Syntax kCommands[] = {
    {"wait", "/w", "wait [rough]"},
    {"frames", "n", "frames COUNT"},
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
    {"slice", "w/wn", "slice LAYER AXIS POSITION, or slice off"},
    {"iso", "w", "iso VALUE, or iso off"},
    {"frame", "n", "frame NUMBER"},
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
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
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
    if (kind == 'n' && !parseNumber(word)) fail(name, line, "'" + word + "' is not a number" + usage);
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
    line = line.substr(0, line.find('#'));
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
