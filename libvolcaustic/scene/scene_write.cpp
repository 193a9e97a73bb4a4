#include "core/hash.h"
#include "scene/scene_json.h"
#include "scene/scene_layout.h"

namespace volcaustic {

namespace {

/// Adds each described field to an object.
class FieldWriter {
public:
  explicit FieldWriter(Json& object) : mObject(object) {}

  template <class T>
  void operator()(const char* name, const T& value, const FieldDoc&) {
    mObject[name] = write(value);
  }

private:
  template <class T>
  static Json write(const T& value) {
    if constexpr (std::is_enum_v<T>)
      return enumNames(T{})[static_cast<std::size_t>(value)];
    else
      return value;
  }
  static Json write(const std::filesystem::path& value) { return value.generic_string(); }
  static Json write(const AutomaticBox& value) {
    if (value.automatic) return "auto";
    return {{"min", value.box.min}, {"max", value.box.max}};
  }

  template <class T>
  static Json write(const std::vector<T>& value) {
    Json array = Json::array();
    for (T element : value) {
      Json object = Json::object();
      describe(FieldWriter(object), element);
      array.push_back(std::move(object));
    }
    return array;
  }

  Json& mObject;
};

class SceneWriter {
public:
  template <class T>
  void section(const char* key, T& object, const char*) {
    document[key] = write(object);
  }
  template <class T>
  void list(const char* key, std::vector<T>& objects, const char*) {
    Json& array = document[key] = Json::array();
    for (T& object : objects) array.push_back(write(object));
  }
  template <class T>
  void named(const char* key, std::vector<T>& objects, const char*) {
    Json& map = document[key] = Json::object();
    for (T& object : objects) map[object.name] = write(object);
  }

  Json document{{"volcaustic", kSceneVersion}};

private:
  template <class T>
  static Json write(T& object) {
    Json json = Json::object();
    describe(FieldWriter(json), object);
    return json;
  }
};

} // namespace

Json sceneDocument(const Scene& scene) {
  Scene copy = scene; // describe() hands out references that a reader may write to
  SceneWriter writer;
  describeScene(writer, copy);
  return std::move(writer.document);
}

std::string sceneToJson(const Scene& scene) { return prettyText(sceneDocument(scene)); }

std::string sceneHash(const Scene& scene) { return Hash().text(sceneToJson(scene)).hex(); }

} // namespace volcaustic
