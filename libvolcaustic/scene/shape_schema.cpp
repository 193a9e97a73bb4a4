#include "scene/shape_schema.h"

#include "scene/field_schema.h"
#include "scene/scene_source.h"
#include "scene/shape_layout.h"
#include "volcaustic/shape_file.h"

namespace volcaustic {

namespace {

const Json kAnyShape{{"$ref", "#/$defs/shape"}};

Json described(const char* text, const Json& schema) {
  Json field{{"description", text}};
  field.update(schema);
  return field;
}

Json arrayOf(const Json& items) { return {{"type", "array"}, {"items", items}, {"minItems", 1}}; }

Json deviationsSchema() {
  const Deviation usual;
  const Json defaults{{"weight", usual.weight}};
  FieldSchema fields(defaults);
  fields("weight", usual.weight, kWeightDoc);
  fields.add("region", described(kRegionText, kAnyShape), true);
  return {{"type", "array"}, {"items", fields.take()}, {"default", Json::array()}};
}

/// A node of which `Target` holds what is its own.
template <class Target>
Json nodeSchema(Target target, const char* type) {
  std::string name;
  Placement placement;
  ShapeWriter shapes;
  Json defaults = FieldWriter::object(target, shapes);
  defaults.update(FieldWriter::object(placement, shapes));
  defaults["name"] = name;

  FieldSchema fields(defaults);
  if (type) fields.add("type", {{"const", type}}, true);
  describe(fields, target);
  describeNode(fields, name, placement);
  if constexpr (std::is_constructible_v<shapes::Kind, Target>) {
    const shapes::Kind kind(target);
    if (isQuadric(kind)) fields.add("deviations", described(kDeviationsText, deviationsSchema()), false);
    if (partsOf(kind) == ShapeParts::One) fields.add("part", described(kPartText, kAnyShape), true);
    if (partsOf(kind) == ShapeParts::Many) fields.add("parts", described(kPartsText, arrayOf(kAnyShape)), true);
  }
  return fields.take();
}

/// Alternatives by condition, not by trial: a validator looks at one of them alone, and says what is wrong with that.
Json whenType(const char* type) {
  return {{"if", {{"properties", {{"type", {{"const", type}}}}}, {"required", {"type"}}}},
          {"then", {{"$ref", std::string("#/$defs/") + type}}}};
}
Json whenGiven(const char* key) {
  return {{"if", {{"required", {key}}}}, {"then", {{"$ref", std::string("#/$defs/") + key}}}};
}

Json anyNode() {
  Json alternatives = Json::array({whenGiven("use"), whenGiven("file")});
  for (const char* type : kShapeTypes) alternatives.push_back(whenType(type));
  return {{"description", "a node of a shape: of a type, a shape defined by name, or that of another file"},
          {"type", "object"},
          {"properties", {{"type", {{"enum", kShapeTypes}}}}},
          {"anyOf", {{{"required", {"type"}}}, {{"required", {"use"}}}, {{"required", {"file"}}}}},
          {"allOf", std::move(alternatives)}};
}

Json buildSchema() {
  Json properties{{"$schema", {{"description", "address of this schema, for editors"}, {"type", "string"}}},
                  {"volcaustic", {{"description", "version of the format"}, {"const", kSceneVersion}}},
                  {kShapesKey, shapesSectionSchema()},
                  {"shape", kAnyShape},
                  {"animation", animationSchema()}};
  return {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
          {"title", "volcaustic shape"},
          {"description", "a functional object; lengths are in world units, inside is where its value is positive"},
          {"type", "object"},
          {"properties", std::move(properties)},
          {"required", {"volcaustic", "shape"}},
          {"additionalProperties", false},
          {"$defs", shapeDefinitions()}};
}

} // namespace

Json shapeDefinitions() {
  Json definitions{{"shape", anyNode()}};
  for (std::size_t i = 0; i < kShapeTypes.size(); ++i)
    definitions[kShapeTypes[i]] =
        std::visit([&](const auto& kind) { return nodeSchema(kind, kShapeTypes[i]); }, kindOf(i));
  definitions["use"] = nodeSchema(NamedShape{}, nullptr);
  definitions["file"] = nodeSchema(ShapeOfFile{}, nullptr);
  return definitions;
}

Json shapesSectionSchema() {
  return {{"description", "shapes that nodes refer to by name, as {\"use\": \"name\"}"},
          {"type", "object"},
          {"additionalProperties", kAnyShape}};
}

const Json& shapeSchemaDocument() {
  static const Json schema = buildSchema();
  return schema;
}

std::string shapeSchema() { return prettyText(shapeSchemaDocument()); }

} // namespace volcaustic
