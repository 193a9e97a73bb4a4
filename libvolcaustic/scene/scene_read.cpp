#include "core/nearest_word.h"
#include "scene/gltf_file.h"
#include "scene/gltf_scene.h"
#include "scene/json_document.h"
#include "scene/scene_check.h"
#include "scene/scene_edit.h"
#include "scene/scene_layout.h"
#include "scene/scene_source.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace volcaustic {

void SceneSource::fail(std::string_view pointer, const std::string& what) const {
  for (auto set = sets.rbegin(); set != sets.rend(); ++set)
    if (pointer == set->first || pointer.starts_with(set->first + "/"))
      throw Error(ErrorKind::Usage, "set " + set->second + ": " + what);
  throw Error(ErrorKind::Input, name + ":" + std::string(pointer) + ": " + what);
}

namespace {

std::string rangeText(const FieldDoc& doc) {
  std::ostringstream text;
  text.precision(12);
  text << "from " << doc.min << " to " << doc.max;
  if (*doc.unit && std::string_view(doc.unit) != "1") text << " " << doc.unit;
  return text.str();
}

void rejectUnknownKeys(const Json& object, const std::vector<std::string>& known, const std::string& pointer,
                       const SceneSource& source) {
  for (const auto& [key, value] : object.items())
    if (std::find(known.begin(), known.end(), key) == known.end())
      source.fail(pointer + "/" + pointerToken(key),
                  "unknown key; the nearest known one is \"" + nearestWord(key, known) + "\"");
}

void requireObject(const Json& value, const std::string& pointer, const SceneSource& source) {
  if (!value.is_object()) source.fail(pointer, "must be an object, not " + excerpt(value) + "; write { ... }");
}

/// Reads the described fields of one object; keys that are not given keep the value that is there.
class FieldReader {
public:
  FieldReader(const Json& object, std::string pointer, const SceneSource& source)
      : mObject(object), mPointer(std::move(pointer)), mSource(source) {
    requireObject(object, mPointer, mSource);
  }

  template <class T>
  void operator()(const char* name, T& value, const FieldDoc& doc) {
    mKnown.emplace_back(name);
    const auto found = mObject.find(name);
    if (found != mObject.end())
      read(*found, value, doc, mPointer + "/" + name);
    else if (doc.required)
      mSource.fail(mPointer + "/" + name, std::string("is missing; give the ") + doc.text);
  }

  void finish() const { rejectUnknownKeys(mObject, mKnown, mPointer, mSource); }

  template <class T>
  static void readObject(const Json& json, T& object, const std::string& pointer, const SceneSource& source) {
    FieldReader fields(json, pointer, source);
    describe(fields, object);
    fields.finish();
  }

  template <class T>
  static void readList(const Json& json, std::vector<T>& objects, const std::string& pointer,
                       const SceneSource& source) {
    if (!json.is_array()) source.fail(pointer, "must be an array, not " + excerpt(json) + "; write [ ... ]");
    objects.assign(json.size(), T{});
    for (std::size_t i = 0; i < objects.size(); ++i)
      readObject(json[i], objects[i], pointer + "/" + std::to_string(i), source);
  }

private:
  void read(const Json& json, double& value, const FieldDoc& doc, const std::string& pointer) const {
    if (!json.is_number()) mSource.fail(pointer, "must be a number, not " + excerpt(json));
    const double number = json.get<double>();
    if (!std::isfinite(number) || number < doc.min || number > doc.max)
      mSource.fail(pointer, excerpt(json) + " is out of range; give a value " + rangeText(doc));
    value = number;
  }

  void read(const Json& json, int& value, const FieldDoc& doc, const std::string& pointer) const {
    double number = 0;
    read(json, number, doc, pointer);
    if (number != std::floor(number)) mSource.fail(pointer, "must be a whole number, not " + excerpt(json));
    value = static_cast<int>(number);
    if (!doc.choices.empty() && std::find(doc.choices.begin(), doc.choices.end(), value) == doc.choices.end()) {
      std::string all;
      for (const int choice : doc.choices) all += (all.empty() ? "" : ", ") + std::to_string(choice);
      mSource.fail(pointer, excerpt(json) + " is not possible; give one of " + all);
    }
  }

  void read(const Json& json, bool& value, const FieldDoc&, const std::string& pointer) const {
    if (!json.is_boolean()) mSource.fail(pointer, "must be true or false, not " + excerpt(json));
    value = json.get<bool>();
  }

  void read(const Json& json, std::string& value, const FieldDoc&, const std::string& pointer) const {
    if (!json.is_string()) mSource.fail(pointer, "must be a string, not " + excerpt(json));
    value = json.get<std::string>();
  }

  void read(const Json& json, std::filesystem::path& value, const FieldDoc& doc, const std::string& pointer) const {
    std::string text;
    read(json, text, doc, pointer);
    if (doc.required && text.empty()) mSource.fail(pointer, std::string("is empty; give the ") + doc.text);
    value = text.empty() ? std::filesystem::path() : (mSource.folder / text).lexically_normal();
  }

  template <class T, std::size_t N>
  void read(const Json& json, std::array<T, N>& value, const FieldDoc& doc, const std::string& pointer) const {
    if (!json.is_array() || json.size() != N)
      mSource.fail(pointer, "must be an array of " + std::to_string(N) + " numbers, not " + excerpt(json));
    for (std::size_t i = 0; i < N; ++i) read(json[i], value[i], doc, pointer + "/" + std::to_string(i));
  }

  template <class T>
  requires std::is_enum_v<T>
  void read(const Json& json, T& value, const FieldDoc& doc, const std::string& pointer) const {
    std::string word;
    read(json, word, doc, pointer);
    const auto names = enumNames(T{});
    const std::vector<std::string> known(names.begin(), names.end());
    const auto found = std::find(known.begin(), known.end(), word);
    if (found == known.end())
      mSource.fail(pointer,
                   excerpt(json) + " is not known; the nearest known one is \"" + nearestWord(word, known) + "\"");
    value = static_cast<T>(found - known.begin());
  }

  void read(const Json& json, AutomaticBox& value, const FieldDoc& doc, const std::string& pointer) const {
    value.automatic = json.is_string() && json.get<std::string>() == "auto";
    if (value.automatic) return;
    if (!json.is_object())
      mSource.fail(pointer, "must be \"auto\" or {\"min\": [x, y, z], \"max\": [x, y, z]}, not " + excerpt(json));
    FieldReader corners(json, pointer, mSource);
    FieldDoc corner = doc;
    corner.text = "corner of the box";
    corner.required = true;
    corners("min", value.box.min, corner);
    corners("max", value.box.max, corner);
    corners.finish();
  }

  template <class T>
  void read(const Json& json, std::vector<T>& value, const FieldDoc&, const std::string& pointer) const {
    readList(json, value, pointer, mSource);
  }

  const Json& mObject;
  std::string mPointer;
  const SceneSource& mSource;
  std::vector<std::string> mKnown;
};

/// Reads the sections of a scene; sections that are not given keep what is there.
class SceneReader {
public:
  SceneReader(const Json& document, const SceneSource& source) : mDocument(document), mSource(source) {}

  template <class T>
  void section(const char* key, T& object, const char*) {
    if (const Json* json = find(key)) FieldReader::readObject(*json, object, std::string("/") + key, mSource);
  }

  template <class T>
  void list(const char* key, std::vector<T>& objects, const char*) {
    if (const Json* json = find(key)) FieldReader::readList(*json, objects, std::string("/") + key, mSource);
  }

  template <class T>
  void named(const char* key, std::vector<T>& objects, const char*) {
    const Json* json = find(key);
    if (!json) return;
    const std::string pointer = std::string("/") + key;
    requireObject(*json, pointer, mSource);
    objects.clear();
    for (const auto& [name, value] : json->items()) {
      objects.push_back(T{});
      objects.back().name = name;
      FieldReader::readObject(value, objects.back(), pointer + "/" + pointerToken(name), mSource);
    }
  }

  void finish() const { rejectUnknownKeys(mDocument, mKnown, "", mSource); }

private:
  const Json* find(const char* key) {
    mKnown.emplace_back(key);
    const auto found = mDocument.find(key);
    return found == mDocument.end() ? nullptr : &*found;
  }

  const Json& mDocument;
  const SceneSource& mSource;
  std::vector<std::string> mKnown{"volcaustic", "$schema", "animation"};
};

void checkVersion(const Json& document, const SceneSource& source) {
  const std::string wanted = std::to_string(kSceneVersion);
  const auto version = document.find("volcaustic");
  if (version == document.end())
    source.fail("/volcaustic", "is missing; write \"volcaustic\": " + wanted + ", the version of the scene format");
  if (!version->is_number_integer() || version->get<std::int64_t>() != kSceneVersion)
    source.fail("/volcaustic", "version " + excerpt(*version) + " is not known; this program reads version " + wanted);
}

std::string readText(const std::filesystem::path& path) {
  constexpr std::streamsize kLargestScene = 64 << 20;
  std::error_code ignored;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, ignored))
    throw Error(ErrorKind::File, path.string() + ": cannot be opened; check the path and its permissions");
  std::string text;
  std::array<char, 1 << 16> piece;
  while (file.read(piece.data(), piece.size()), file.gcount() > 0) {
    text.append(piece.data(), static_cast<std::size_t>(file.gcount()));
    if (static_cast<std::streamsize>(text.size()) > kLargestScene)
      throw Error(ErrorKind::Input, path.string() + ": larger than 64 MiB, so not a scene; check the path");
  }
  return text;
}

/// A frame's scene of a document, which is checked with what was set from outside.
Scene sceneOf(Json document, SceneSource source, const SceneReadOptions& options) {
  // Tracks can be set from outside too; a value set from outside wins over a track.
  const auto setsTrack = [](const std::string& set) { return set.starts_with("animation"); };
  for (const std::string& set : options.sets)
    if (setsTrack(set)) applySet(document, set, source);
  applyAnimation(document, options.frame, source);
  for (const std::string& set : options.sets)
    if (!setsTrack(set)) applySet(document, set, source);

  Scene scene;
  SceneReader reader(document, source);
  describeScene(reader, scene);
  reader.finish();
  checkScene(scene, source);
  return scene;
}

/// What only glTF files have a use for.
void rejectGltfOptions(const SceneReadOptions& options, const std::string& name) {
  if (!options.camera.empty())
    throw Error(ErrorKind::Usage, "camera " + excerpt(options.camera) + ": " + name +
                                      " has one camera and no name for it; cameras are chosen from glTF files");
  if (options.framesPerSecond)
    throw Error(ErrorKind::Usage,
                "frames per second: the animation of " + name + " is in frames; only that of glTF files is in seconds");
}

} // namespace

Scene parseScene(const std::string& text, const std::filesystem::path& name, const SceneReadOptions& options) {
  SceneSource source{name.string(), name.parent_path(), {}};
  rejectGltfOptions(options, source.name);
  Json document = parseJson(text, source.name);
  if (!document.is_object()) source.fail("/", "must be an object, not " + excerpt(document) + "; write { ... }");
  checkVersion(document, source);
  return sceneOf(std::move(document), std::move(source), options);
}

Scene readScene(const std::filesystem::path& path, const SceneReadOptions& options, const RunContext& ctx) {
  if (!isGltfName(path)) return parseScene(readText(path), path, options);
  return sceneOf(gltfSceneDocument(path, options, ctx), {path.string(), path.parent_path(), {}}, options);
}

} // namespace volcaustic
