// view: the interactive window, a program of its own, so that nothing else has to load OpenGL.
#include "common.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <unistd.h>
#include <vector>

namespace volcaustic::cli {

namespace {

constexpr const char* kViewer = "volcaustic-view";

/// Becomes the viewer, which says everything else itself.
int runViewer(std::vector<std::string> arguments) {
  std::error_code failed;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", failed);
  const std::string viewer = (own.parent_path() / kViewer).string();
  arguments.insert(arguments.begin(), kViewer);
  std::vector<char*> words;
  for (std::string& word : arguments) words.push_back(word.data());
  words.push_back(nullptr);
  execv(viewer.c_str(), words.data());
  throw Error(ErrorKind::Device, std::string("volcaustic view: ") + kViewer +
                                     " cannot be started: " + std::strerror(errno) +
                                     "; it is built where GLFW and Dear ImGui are found, and stands beside volcaustic");
}

} // namespace

void addViewCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("view", "a scene in a window, to look at and to change");
  command->prefix_command();
  command->set_help_flag();
  command->footer("volcaustic view SCENE [--script FILE] ...; see `volcaustic view --help` and docs/viewer.md");
  command->final_callback(
      [command, &action] { action = [arguments = command->remaining()] { return runViewer(arguments); }; });
}

} // namespace volcaustic::cli
