#include "core/hash.h"
#include "scene/field_writer.h"
#include "scene/scene_json.h"
#include "scene/scene_layout.h"
#include "scene/shape_layout.h"
#include "scene/shape_write.h"

namespace volcaustic {

namespace {

class SceneWriter {
public:
  template <class T>
  void section(const char* key, T& object, const char*) {
    document[key] = FieldWriter::object(object, shapes);
  }
  template <class T>
  void list(const char* key, std::vector<T>& objects, const char*) {
    Json& array = document[key] = Json::array();
    for (T& object : objects) array.push_back(FieldWriter::object(object, shapes));
  }
  template <class T>
  void named(const char* key, std::vector<T>& objects, const char*) {
    Json& map = document[key] = Json::object();
    for (T& object : objects) map[object.name] = FieldWriter::object(object, shapes);
  }

  Json document{{"volcaustic", kSceneVersion}};
  ShapeWriter shapes;
};

} // namespace

Json sceneDocument(const Scene& scene) {
  Scene copy = scene; // describe() hands out references that a reader may write to
  SceneWriter writer;
  describeScene(writer, copy);
  if (!writer.shapes.definitions().empty()) writer.document[kShapesKey] = writer.shapes.definitions();
  return std::move(writer.document);
}

std::string sceneToJson(const Scene& scene) { return prettyText(sceneDocument(scene)); }

std::string sceneHash(const Scene& scene) { return Hash().text(sceneToJson(scene)).hex(); }

} // namespace volcaustic
