#include "scene/scene_source.h"

#include "volcaustic/error.h"
#include "volcaustic/frames.h"
#include "volcaustic/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <system_error>

namespace volcaustic {

std::filesystem::path SceneSource::pathOf(const std::string& text) const {
  const std::filesystem::path path = (folder / text).lexically_normal();
  const std::string file = sceneMeshFile(path).string(), fragment = path.string().substr(file.size());
  std::error_code ignored;
  if (!hasFramePlace(file) || std::filesystem::exists(file, ignored)) return path;
  constexpr double kMost = std::numeric_limits<int>::max();
  return withFrame(file, static_cast<int>(std::lround(std::clamp(frame, -kMost, kMost)))) + fragment;
}

void SceneSource::fail(std::string_view pointer, const std::string& what) const {
  for (auto set = sets.rbegin(); set != sets.rend(); ++set)
    if (pointer == set->first || pointer.starts_with(set->first + "/"))
      throw Error(ErrorKind::Usage, "set " + set->second + ": " + what);
  throw Error(ErrorKind::Input, name + ":" + std::string(pointer) + ": " + what);
}

std::string readDocumentText(const std::filesystem::path& path) {
  constexpr std::streamsize kLargestDocument = 64 << 20;
  std::error_code ignored;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, ignored))
    throw Error(ErrorKind::File, path.string() + ": cannot be opened; check the path and its permissions");
  std::string text;
  std::array<char, 1 << 16> piece;
  while (file.read(piece.data(), piece.size()), file.gcount() > 0) {
    text.append(piece.data(), static_cast<std::size_t>(file.gcount()));
    if (static_cast<std::streamsize>(text.size()) > kLargestDocument)
      throw Error(ErrorKind::Input,
                  path.string() + ": larger than 64 MiB, so neither a scene nor a shape; check the path");
  }
  return text;
}

Json parseDocument(const std::string& text, const SceneSource& source) {
  Json document = parseJson(text, source.name);
  if (!document.is_object()) source.fail("/", "must be an object, not " + excerpt(document) + "; write { ... }");
  const std::string wanted = std::to_string(kSceneVersion);
  const auto version = document.find("volcaustic");
  if (version == document.end())
    source.fail("/volcaustic", "is missing; write \"volcaustic\": " + wanted + ", the version of the format");
  if (!version->is_number_integer() || version->get<std::int64_t>() != kSceneVersion)
    source.fail("/volcaustic", "version " + excerpt(*version) + " is not known; this program reads version " + wanted);
  return document;
}

} // namespace volcaustic
