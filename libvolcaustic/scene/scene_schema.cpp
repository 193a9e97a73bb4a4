#include "scene/scene_json.h"
#include "scene/scene_layout.h"

#include <cmath>

namespace volcaustic {

namespace {

std::string description(const FieldDoc& doc) {
  std::string text = doc.text;
  if (*doc.unit && std::string_view(doc.unit) != "1") text += std::string(" [") + doc.unit + "]";
  return text;
}

Json whole(double value) { return std::llround(value); }

/// The schema of one value, without description and default.
Json typeOf(const bool&, const FieldDoc&) { return {{"type", "boolean"}}; }
Json typeOf(const std::string&, const FieldDoc&) { return {{"type", "string"}}; }
Json typeOf(const std::filesystem::path&, const FieldDoc& doc) {
  Json schema{{"type", "string"}};
  if (doc.required) schema["minLength"] = 1;
  return schema;
}
Json typeOf(const double&, const FieldDoc& doc) {
  Json schema{{"type", "number"}};
  if (std::isfinite(doc.min)) schema["minimum"] = doc.min;
  if (std::isfinite(doc.max)) schema["maximum"] = doc.max;
  return schema;
}
Json typeOf(const int&, const FieldDoc& doc) {
  if (!doc.choices.empty()) return {{"enum", std::vector<int>(doc.choices.begin(), doc.choices.end())}};
  Json schema{{"type", "integer"}};
  if (std::isfinite(doc.min)) schema["minimum"] = whole(doc.min);
  if (std::isfinite(doc.max)) schema["maximum"] = whole(doc.max);
  return schema;
}
template <class T, std::size_t N>
Json typeOf(const std::array<T, N>&, const FieldDoc& doc) {
  return {{"type", "array"}, {"items", typeOf(T{}, doc)}, {"minItems", N}, {"maxItems", N}};
}
template <class T>
requires std::is_enum_v<T> Json typeOf(const T&, const FieldDoc&) { return {{"enum", enumNames(T{})}}; }
Json typeOf(const AutomaticBox&, const FieldDoc& doc) {
  const Json corner = typeOf(Vec3d{}, doc);
  const Json box{{"type", "object"},
                 {"properties", {{"min", corner}, {"max", corner}}},
                 {"required", {"min", "max"}},
                 {"additionalProperties", false}};
  return {{"oneOf", Json::array({Json{{"const", "auto"}}, box})}};
}

class FieldSchema {
public:
  explicit FieldSchema(const Json& defaults) : mDefaults(defaults) {}

  template <class T>
  void operator()(const char* name, const T& value, const FieldDoc& doc) {
    Json field{{"description", description(doc)}};
    field.update(typeOf(value, doc));
    if (doc.required)
      mRequired.push_back(name);
    else
      field["default"] = mDefaults.at(name);
    if (doc.alternative) mAlternatives.push_back({{"required", {name}}, {"properties", {{name, {{"minLength", 1}}}}}});
    mProperties[name] = std::move(field);
  }

  /// A list that holds one default element.
  template <class T>
  void operator()(const char* name, std::vector<T>& value, const FieldDoc& doc) {
    FieldSchema element(mDefaults.at(name).front());
    describe(element, value.front());
    mProperties[name] = {
        {"description", description(doc)}, {"type", "array"}, {"items", element.take()}, {"default", Json::array()}};
  }

  Json take() {
    Json schema{{"type", "object"}, {"properties", std::move(mProperties)}};
    if (!mRequired.empty()) schema["required"] = std::move(mRequired);
    if (!mAlternatives.empty()) schema["anyOf"] = std::move(mAlternatives);
    schema["additionalProperties"] = false;
    return schema;
  }

private:
  const Json& mDefaults;
  Json mProperties = Json::object();
  Json mRequired = Json::array();
  Json mAlternatives = Json::array();
};

/// Visits a scene that holds one default element of each list.
class SceneSchema {
public:
  explicit SceneSchema(const Json& defaults) : mDefaults(defaults) {}

  template <class T>
  void section(const char* key, T& object, const char* text) {
    Json schema{{"description", text}};
    schema.update(objectSchema(object, mDefaults.at(key)));
    properties[key] = std::move(schema);
  }
  template <class T>
  void list(const char* key, std::vector<T>& objects, const char* text) {
    properties[key] = {
        {"description", text}, {"type", "array"}, {"items", objectSchema(objects.front(), mDefaults.at(key).front())}};
  }
  template <class T>
  void named(const char* key, std::vector<T>& objects, const char* text) {
    properties[key] = {{"description", text},
                       {"type", "object"},
                       {"additionalProperties", objectSchema(objects.front(), mDefaults.at(key).front())}};
  }

  Json properties = Json::object();

private:
  template <class T>
  static Json objectSchema(T& object, const Json& defaults) {
    FieldSchema fields(defaults);
    describe(fields, object);
    return fields.take();
  }

  const Json& mDefaults;
};

Json animationSchema() {
  const Json number{{"type", "number"}};
  const Json numbers{{"type", "array"}, {"items", number}};
  const Json key{
      {"type", "array"}, {"prefixItems", {number, {{"oneOf", {number, numbers}}}}}, {"minItems", 2}, {"maxItems", 2}};
  return {{"description",
           "tracks: JSON pointer to a number or an array of numbers of this file -> [frame, value] pairs in "
           "order of frame, linear in between, constant outside"},
          {"type", "object"},
          {"propertyNames", {{"pattern", "^/"}}},
          {"additionalProperties", {{"type", "array"}, {"items", key}, {"minItems", 1}}}};
}

Json buildSchema() {
  Scene scene;
  scene.objects.resize(1);
  scene.objects.front().groups.resize(1);
  scene.objects.front().grids.resize(1);
  scene.lights.resize(1);
  scene.receivers.resize(1);
  const Json defaults = sceneDocument(scene);
  SceneSchema sections(defaults);
  sections.properties["$schema"] = {{"description", "address of this schema, for editors"}, {"type", "string"}};
  sections.properties["volcaustic"] = {{"description", "version of the scene format"}, {"const", kSceneVersion}};
  describeScene(sections, scene);
  sections.properties["animation"] = animationSchema();
  return {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
          {"title", "volcaustic scene"},
          {"description", "one world unit is one scene unit; spectra are Rec. 709 linear RGB"},
          {"type", "object"},
          {"properties", std::move(sections.properties)},
          {"required", {"volcaustic"}},
          {"additionalProperties", false}};
}

} // namespace

const Json& sceneSchemaDocument() {
  static const Json schema = buildSchema();
  return schema;
}

std::string sceneSchema() { return prettyText(sceneSchemaDocument()); }

} // namespace volcaustic
