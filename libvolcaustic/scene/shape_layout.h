// What nodes of shapes hold in JSON beside the fields of their type (volcaustic/shape_fields.h). Reader, writer and
// schema are users of this one description.
#pragma once

#include "volcaustic/shape_fields.h"

#include <string>
#include <utility>

namespace volcaustic {

/// The section of a scene or a shape file whose shapes others refer to by name.
inline constexpr const char* kShapesKey = "shapes";

inline constexpr FieldDoc kShapeTypeDoc{.text = "type of the shape", .required = true};
inline constexpr FieldDoc kWeightDoc{"of the deviation function: above 0 a bulge, below 0 a dent", "1", -1e9, 1e9};
inline constexpr const char* kDeviationsText =
    "bulges and dents: weight times the cube of `region` inside of it, added";
inline constexpr const char* kRegionText = "another quadric, as its definition gives it, endless";
inline constexpr const char* kPartsText = "of the operation, in order";
inline constexpr const char* kPartText = "that the operation is applied to";

/// Of every node, references too.
template <class Visitor>
void describeNode(Visitor&& visit, std::string& name, Placement& placement) {
  visit("name", name, FieldDoc{"of a part: of the group of its triangles"});
  describe(visit, placement);
}

/// In place of a type.
struct NamedShape {
  std::string use;
};
struct ShapeOfFile {
  std::string file;
};
template <class Visitor>
void describe(Visitor&& visit, NamedShape& s) {
  visit("use", s.use, FieldDoc{.text = "name of a shape in `shapes` of the same file", .required = true});
}
template <class Visitor>
void describe(Visitor&& visit, ShapeOfFile& s) {
  visit("file", s.file, FieldDoc{.text = "shape file whose shape it is; relative to this file", .required = true});
}

namespace detail {
template <std::size_t... I>
shapes::Kind kindOf(std::size_t index, std::index_sequence<I...>) {
  shapes::Kind kind;
  (void)((I == index && (kind = std::variant_alternative_t<I, shapes::Kind>{}, true)) || ...);
  return kind;
}
} // namespace detail

/// The kind of kShapeTypes[index], as it is where nothing is said.
inline shapes::Kind kindOf(std::size_t index) {
  return detail::kindOf(index, std::make_index_sequence<std::variant_size_v<shapes::Kind>>());
}

} // namespace volcaustic
