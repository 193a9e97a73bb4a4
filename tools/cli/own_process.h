// Runs this program once more, as a child, so that what it measures and what it may break are its own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace volcaustic::cli {

struct ChildResult {
  int status = 0;     ///< its exit status; 128 + the signal that ended it
  std::string output; ///< its stdout
  std::string words;  ///< its stderr
};

/// Waits for the child, which may not allocate more than `memoryLimit` bytes beside what the program holds anyway; 0 is
/// no limit. An interrupted parent interrupts it.
/// \throws Error(Internal) when no process can be started, Error(Cancelled) when interrupted.
ChildResult runOwnProgram(const std::vector<std::string>& arguments, std::uint64_t memoryLimit);

} // namespace volcaustic::cli
