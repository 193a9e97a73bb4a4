#include "scene/field_schema.h"
#include "scene/scene_json.h"
#include "scene/scene_layout.h"
#include "scene/shape_layout.h"
#include "scene/shape_schema.h"

namespace volcaustic {

namespace {

/// A visitor of describeScene().
class SceneSchema {
public:
  template <class T>
  void section(const char* key, T&, const char* text) {
    Json schema{{"description", text}};
    schema.update(schemaOf<T>());
    properties[key] = std::move(schema);
  }
  template <class T>
  void list(const char* key, std::vector<T>&, const char* text) {
    properties[key] = {{"description", text}, {"type", "array"}, {"items", schemaOf<T>()}};
  }
  template <class T>
  void named(const char* key, std::vector<T>&, const char* text) {
    properties[key] = {{"description", text}, {"type", "object"}, {"additionalProperties", schemaOf<T>()}};
  }

  Json properties = Json::object();
};

Json buildSchema() {
  Scene scene;
  SceneSchema sections;
  sections.properties["$schema"] = {{"description", "address of this schema, for editors"}, {"type", "string"}};
  sections.properties["volcaustic"] = {{"description", "version of the scene format"}, {"const", kSceneVersion}};
  describeScene(sections, scene);
  sections.properties[kShapesKey] = shapesSectionSchema();
  sections.properties["animation"] = animationSchema();
  return {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
          {"title", "volcaustic scene"},
          {"description", "one world unit is one scene unit; spectra are Rec. 709 linear RGB"},
          {"type", "object"},
          {"properties", std::move(sections.properties)},
          {"required", {"volcaustic"}},
          {"additionalProperties", false},
          {"$defs", shapeDefinitions()}};
}

} // namespace

const Json& sceneSchemaDocument() {
  static const Json schema = buildSchema();
  return schema;
}

std::string sceneSchema() { return prettyText(sceneSchemaDocument()); }

} // namespace volcaustic
