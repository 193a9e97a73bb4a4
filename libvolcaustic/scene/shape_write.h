// Shapes as JSON.
#pragma once

#include "scene/json_document.h"
#include "volcaustic/shape.h"

#include <cstdint>
#include <map>

namespace volcaustic {

/// Writes each shape as one node with all its parts in it. What would lie deeper than the parser follows becomes a
/// definition, which the node refers to.
class ShapeWriter {
public:
  /// "" for an empty shape. \throws Error(Input) for more than a million nodes once copies are written out.
  Json write(const Shape& shape);
  /// The definitions that the shapes written so far refer to.
  [[nodiscard]] const Json& definitions() const { return mDefinitions; }

private:
  Json node(const Shape& shape, int depth);
  Json reference(const Shape& shape);

  Json mDefinitions = Json::object();
  std::map<std::uint64_t, std::string> mNames; ///< of definitions, by shapeHash
};

} // namespace volcaustic
