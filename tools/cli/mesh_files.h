// Inputs and outputs of the commands that take several files between surfaces and volumes.
#pragma once

#include "file_kind.h"

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace volcaustic::cli {

/// One output for each input. `outputs` is as many files, one pattern with {} for the input's stem, or one folder,
/// where the files get `extension`. \throws Error(Usage) when it is none of these, or two inputs would write the same
/// file.
std::vector<std::string> outputsFor(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
                                    const std::string& extension, FileKind kind);

/// The positional IN... and -o/--output.
void addFiles(CLI::App& command, std::vector<std::string>& inputs, std::vector<std::string>& outputs,
              const char* inputText, const char* outputText);

} // namespace volcaustic::cli
