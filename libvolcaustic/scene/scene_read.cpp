#include "scene/field_reader.h"
#include "scene/gltf_file.h"
#include "scene/gltf_scene.h"
#include "scene/scene_check.h"
#include "scene/scene_edit.h"
#include "scene/scene_json.h"
#include "scene/scene_layout.h"
#include "scene/shape_layout.h"
#include "scene/shape_read.h"
#include "volcaustic/error.h"

namespace volcaustic {

namespace {

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
  std::vector<std::string> mKnown{"volcaustic", "$schema", "animation", kShapesKey};
};

/// A frame's scene of a document, which is checked with what was set from outside.
Scene sceneOf(Json document, SceneSource source, const SceneReadOptions& options) {
  static const Json kDefaults = sceneDocument({});
  source.frame = options.frame;
  applyEdits(document, options.sets, options.frame, {sceneSchemaDocument(), kDefaults}, source);

  ShapeFiles files(options.frame);
  ShapeReader shapes(document, source, files);
  source.shapes = &shapes;
  shapes.readDefinitions();
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
  Json document = parseDocument(text, source);
  return sceneOf(std::move(document), std::move(source), options);
}

Scene readScene(const std::filesystem::path& path, const SceneReadOptions& options, const RunContext& ctx) {
  if (!isGltfName(path)) return parseScene(readDocumentText(path), path, options);
  return sceneOf(gltfSceneDocument(path, options, ctx), {path.string(), path.parent_path(), {}}, options);
}

} // namespace volcaustic
