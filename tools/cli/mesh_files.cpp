#include "mesh_files.h"

#include <volcaustic/error.h>

#include <filesystem>
#include <fmt/format.h>
#include <set>

namespace volcaustic::cli {

std::vector<std::string> outputsFor(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
                                    const std::string& extension, FileKind kind) {
  std::vector<std::string> files = outputs;
  if (outputs.size() == 1) {
    const std::string& target = outputs.front();
    const bool isFolder = target.ends_with('/') || std::filesystem::is_directory(target);
    const bool isPattern = target.find("{}") != std::string::npos;
    if (isFolder || isPattern) files.clear();
    for (const std::string& input : inputs) {
      const std::string stem = std::filesystem::path(input).stem().string();
      if (isPattern)
        files.push_back(std::string(target).replace(target.find("{}"), 2, stem));
      else if (isFolder)
        files.push_back((std::filesystem::path(target) / (stem + extension)).string());
    }
  }
  if (files.size() != inputs.size())
    throw Error(ErrorKind::Usage,
                fmt::format("--output: {} outputs for {} inputs; give one for each, a folder, or a name "
                            "with {{}} for the input's name",
                            files.size(), inputs.size()));
  std::set<std::string> different;
  for (const std::string& file : files)
    if (!different.insert(file).second)
      throw Error(ErrorKind::Usage, "--output: two inputs would write " + file + "; give them different names");
  for (const std::string& file : files) checkOutput(file, kind);
  return files;
}

void addFiles(CLI::App& command, std::vector<std::string>& inputs, std::vector<std::string>& outputs,
              const char* inputText, const char* outputText) {
  command.add_option("IN", inputs, inputText)->required();
  command.add_option("-o,--output", outputs, outputText)->required()->allow_extra_args(false);
}

} // namespace volcaustic::cli
