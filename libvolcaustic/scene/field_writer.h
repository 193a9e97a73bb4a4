// Described structs (volcaustic/options.h) to JSON.
#pragma once

#include "scene/json_document.h"
#include "volcaustic/options.h"

#include <type_traits>
#include <vector>

namespace volcaustic {

class ShapeWriter;

/// Adds each described field to an object.
class FieldWriter {
public:
  FieldWriter(Json& object, ShapeWriter& shapes) : mObject(object), mShapes(shapes) {}

  template <class T>
  void operator()(const char* name, const T& value, const FieldDoc&) {
    mObject[name] = write(value);
  }

  template <class T>
  static Json object(T value, ShapeWriter& shapes) { // describe() hands out references that a reader may write to
    Json json = Json::object();
    FieldWriter fields(json, shapes);
    describe(fields, value);
    return json;
  }

private:
  template <class T>
  Json write(const T& value) {
    if constexpr (std::is_enum_v<T>)
      return enumNames(T{})[static_cast<std::size_t>(value)];
    else
      return value;
  }
  Json write(const std::filesystem::path& value) { return value.generic_string(); }
  Json write(const Placement& value) { return object(value, mShapes); }
  Json write(const Shape& value); ///< "" for an empty one
  Json write(const AutomaticBox& value) {
    if (value.automatic) return "auto";
    return {{"min", value.box.min}, {"max", value.box.max}};
  }

  Json write(const std::vector<double>& value) { return value; }
  template <std::size_t N>
  Json write(const std::vector<std::array<double, N>>& value) {
    return value;
  }
  template <class T>
  Json write(const std::vector<T>& value) {
    Json array = Json::array();
    for (const T& element : value) array.push_back(object(element, mShapes));
    return array;
  }

  Json& mObject;
  ShapeWriter& mShapes;
};

} // namespace volcaustic
