// Where a document came from, for messages; and what all documents of ours begin with.
#pragma once

#include "scene/json_document.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace volcaustic {

class ShapeReader;

struct SceneSource {
  std::string name;                                      ///< of the file, as messages start with it
  std::filesystem::path folder;                          ///< relative paths are taken from here
  std::vector<std::pair<std::string, std::string>> sets; ///< JSON pointer and text of what was set from outside
  double frame = 1;                                      ///< whose number takes the place for it in paths
  ShapeReader* shapes = nullptr; ///< reads the shapes in it, which may refer to each other and to other files

  /// A path of the document: from its folder, with the frame's number in the place for it, unless a file is called so.
  [[nodiscard]] std::filesystem::path pathOf(const std::string& text) const;

  /// \throws Error(Input) "name:pointer: what", or Error(Usage) "set ...: what" when the place was set from outside:
  /// then the file is not at fault.
  [[noreturn]] void fail(std::string_view pointer, const std::string& what) const;
};

/// The version of scenes and of shape files that this library reads and writes, under the key "volcaustic".
inline constexpr int kSceneVersion = 1;

/// \throws Error(File), or Error(Input) for more than 64 MiB.
std::string readDocumentText(const std::filesystem::path& path);

/// An object of a version that is known. \throws Error(Input) for any other document.
Json parseDocument(const std::string& text, const SceneSource& source);

} // namespace volcaustic
