// What drives the viewer without a hand: one command a line, words between blanks, # to the end is a comment.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace volcaustic::viewer {

struct ScriptCommand {
  int line = 0;
  std::string name;
  std::vector<std::string> arguments;
};

/// Checks names, numbers of arguments and numbers. \throws Error(Usage) "script:LINE: ..." with how to write it;
/// Error(File).
std::vector<ScriptCommand> parseScript(const std::string& text, const std::string& name);
std::vector<ScriptCommand> readScript(const std::filesystem::path& path);

/// A number. \pre parseScript has checked it
double numberOf(const std::string& word);

} // namespace volcaustic::viewer
