#include "scene/shape_write.h"

#include "scene/field_writer.h"
#include "scene/scene_source.h"
#include "scene/shape_layout.h"
#include "shapes/stored_shape.h"
#include "volcaustic/error.h"
#include "volcaustic/shape_file.h"

#include <cstring>

namespace volcaustic {

namespace {

/// A node and the array that it is in are two levels of JSON, of which the parser follows 64.
constexpr int kDeepestNode = 24;

/// Adds those fields that differ from what they are where nothing is said, bit for bit.
class DifferenceWriter {
public:
  explicit DifferenceWriter(Json& object) : mObject(object) {}

  void operator()(const char* name, const std::string& value, const FieldDoc&) const {
    if (!value.empty()) mObject[name] = value;
  }
  void operator()(const char* name, const Vec3d& value, const FieldDoc&) const {
    const Vec3d usual = std::strcmp(name, "scale") == 0 ? Placement{}.scale : Vec3d{};
    if (std::memcmp(&value, &usual, sizeof value) != 0) mObject[name] = value;
  }

private:
  Json& mObject;
};

/// Shapes that share parts would be written out as many times as it takes to fill the memory.
void requireSmall(const Shape& shape) {
  if (StoredShape::of(shape).size > StoredShape::kLargest)
    throw Error(ErrorKind::Input, "shape: has more than a million nodes once its copies are written out; use fewer");
}

} // namespace

Json FieldWriter::write(const Shape& value) { return mShapes.write(value); }

Json ShapeWriter::write(const Shape& shape) {
  if (shape.empty()) return "";
  requireSmall(shape);
  return node(shape, 0);
}

Json ShapeWriter::node(const Shape& shape, int depth) {
  if (depth == kDeepestNode) return reference(shape);
  ShapeNode node = shape.node();
  Json json{{"type", kShapeTypes[node.kind.index()]}};
  FieldWriter fields(json, *this);
  std::visit([&](auto& kind) { describe(fields, kind); }, node.kind);
  describeNode(DifferenceWriter(json), node.name, node.placement);
  for (const Deviation& d : node.deviations)
    json["deviations"].push_back({{"weight", d.weight}, {"region", this->node(d.region, depth + 1)}});
  if (partsOf(node.kind) == ShapeParts::One) json["part"] = this->node(node.parts.front(), depth + 1);
  if (partsOf(node.kind) == ShapeParts::Many)
    for (const Shape& part : node.parts) json["parts"].push_back(this->node(part, depth + 1));
  return json;
}

Json ShapeWriter::reference(const Shape& shape) {
  const auto [entry, isNew] = mNames.try_emplace(shapeHash(shape), "part" + std::to_string(mNames.size() + 1));
  const std::string name = entry->second;
  if (isNew) {
    mDefinitions[name]; // in order of appearance
    Json definition = node(shape, 0);
    mDefinitions[name] = std::move(definition);
  }
  return {{"use", name}};
}

std::string shapeToJson(const Shape& shape) {
  ShapeWriter writer;
  Json node = writer.write(shape);
  Json document{{"volcaustic", kSceneVersion}};
  if (!writer.definitions().empty()) document[kShapesKey] = writer.definitions();
  document["shape"] = std::move(node);
  return prettyText(document);
}

} // namespace volcaustic
