// Described structs (volcaustic/options.h) as JSON Schema 2020-12.
#pragma once

#include "scene/field_writer.h"
#include "scene/json_document.h"
#include "scene/shape_write.h"
#include "volcaustic/options.h"

#include <type_traits>
#include <vector>

namespace volcaustic {

/// What a field means, with its unit.
std::string fieldText(const FieldDoc& doc);

/// The schema of one value, without description and default.
Json typeOf(const bool&, const FieldDoc& doc);
Json typeOf(const std::string&, const FieldDoc& doc);
Json typeOf(const std::filesystem::path&, const FieldDoc& doc);
Json typeOf(const double&, const FieldDoc& doc);
Json typeOf(const int&, const FieldDoc& doc);
Json typeOf(const AutomaticBox&, const FieldDoc& doc);
Json typeOf(const Shape&, const FieldDoc& doc);
Json typeOf(const Placement&, const FieldDoc& doc);
template <class T, std::size_t N>
Json typeOf(const std::array<T, N>&, const FieldDoc& doc) {
  return {{"type", "array"}, {"items", typeOf(T{}, doc)}, {"minItems", N}, {"maxItems", N}};
}
template <class T>
requires std::is_enum_v<T> Json typeOf(const T&, const FieldDoc&) { return {{"enum", enumNames(T{})}}; }
inline Json typeOf(const std::vector<double>&, const FieldDoc& doc) {
  return {{"type", "array"}, {"items", typeOf(0., doc)}};
}
template <std::size_t N>
Json typeOf(const std::vector<std::array<double, N>>&, const FieldDoc& doc) {
  return {{"type", "array"}, {"items", typeOf(std::array<double, N>{}, doc)}};
}
template <class T>
Json typeOf(const std::vector<T>&, const FieldDoc& doc);

/// Collects the schemas of the fields of one object.
class FieldSchema {
public:
  /// \param defaults the object as it is where nothing is said
  explicit FieldSchema(const Json& defaults) : mDefaults(defaults) {}

  template <class T>
  void operator()(const char* name, const T& value, const FieldDoc& doc) {
    Json field{{"description", fieldText(doc)}};
    field.update(typeOf(value, doc));
    if (doc.required)
      mRequired.push_back(name);
    else
      field["default"] = mDefaults.at(name);
    if (doc.alternative) mAlternatives.push_back({{"required", {name}}, {"properties", {{name, {{"minLength", 1}}}}}});
    mProperties[name] = std::move(field);
  }

  /// A field that has no default.
  void add(const char* name, Json field, bool required) {
    if (required) mRequired.push_back(name);
    mProperties[name] = std::move(field);
  }

  Json take();

private:
  const Json& mDefaults;
  Json mProperties = Json::object();
  Json mRequired = Json::array();
  Json mAlternatives = Json::array();
};

/// The schema of a described struct, whose defaults are those of T{}.
template <class T>
Json schemaOf() {
  T object{};
  ShapeWriter shapes;
  const Json defaults = FieldWriter::object(object, shapes);
  FieldSchema fields(defaults);
  describe(fields, object);
  return fields.take();
}

template <class T>
Json typeOf(const std::vector<T>&, const FieldDoc&) {
  return {{"type", "array"}, {"items", schemaOf<T>()}};
}

/// Of the section "animation".
Json animationSchema();

} // namespace volcaustic
