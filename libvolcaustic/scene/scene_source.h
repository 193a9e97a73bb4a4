// Where a scene came from, for messages.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace volcaustic {

struct SceneSource {
  std::string name;                                      ///< of the file, as messages start with it
  std::filesystem::path folder;                          ///< relative paths are taken from here
  std::vector<std::pair<std::string, std::string>> sets; ///< JSON pointer and text of what was set from outside

  /// \throws Error(Input) "name:pointer: what", or Error(Usage) "set ...: what" when the place was set from outside:
  /// then the file is not at fault.
  [[noreturn]] void fail(std::string_view pointer, const std::string& what) const;
};

} // namespace volcaustic
