#include "scene/field_schema.h"

#include <cmath>

namespace volcaustic {

namespace {

Json whole(double value) { return std::llround(value); }

} // namespace

std::string fieldText(const FieldDoc& doc) {
  std::string text = doc.text;
  if (*doc.unit && std::string_view(doc.unit) != "1") text += std::string(" [") + doc.unit + "]";
  return text;
}

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

Json typeOf(const AutomaticBox&, const FieldDoc& doc) {
  const Json corner = typeOf(Vec3d{}, doc);
  const Json box{{"type", "object"},
                 {"properties", {{"min", corner}, {"max", corner}}},
                 {"required", {"min", "max"}},
                 {"additionalProperties", false}};
  return {{"oneOf", Json::array({Json{{"const", "auto"}}, box})}};
}

Json typeOf(const Shape&, const FieldDoc&) {
  return {{"oneOf", Json::array({Json{{"type", "string"}}, Json{{"$ref", "#/$defs/shape"}}})}};
}

Json typeOf(const Placement&, const FieldDoc&) { return schemaOf<Placement>(); }

Json FieldSchema::take() {
  Json schema{{"type", "object"}, {"properties", std::move(mProperties)}};
  if (!mRequired.empty()) schema["required"] = std::move(mRequired);
  if (!mAlternatives.empty()) schema["anyOf"] = std::move(mAlternatives);
  schema["additionalProperties"] = false;
  return schema;
}

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

} // namespace volcaustic
