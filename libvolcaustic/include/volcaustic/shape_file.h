/// \file shape_file.h
/// Shapes as JSON: in scenes, and as files of their own (docs/shape_file.md).
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/shape.h"

#include <filesystem>
#include <string>
#include <vector>

namespace volcaustic {

struct ShapeReadOptions {
  /// "shape.parts.1.radius=0.2": a dotted path and a JSON value, applied in order before anything is checked.
  std::vector<std::string> sets;
  /// The frame at which animations are evaluated, of the file and of those that it refers to.
  double frame = 1;
};

/// Reads a shape file. Relative paths are taken from the file's folder. \throws Error(File), or Error(Input)
/// "drop.json:/shape/semiAxes: ..." with the nearest known key.
VOLCAUSTIC_API Shape readShape(const std::filesystem::path& path, const ShapeReadOptions& options = {});
/// The same from JSON text; `name` stands for the file in messages and its folder resolves relative paths.
VOLCAUSTIC_API Shape parseShape(const std::string& text, const std::filesystem::path& name,
                                const ShapeReadOptions& options = {});
/// Whether a file is JSON that holds a shape, and not a scene. False for what cannot be read.
VOLCAUSTIC_API bool isShapeFile(const std::filesystem::path& path);
/// A shape file of a shape that is not empty. Read again it is the same: of equal shapeHash().
VOLCAUSTIC_API std::string shapeToJson(const Shape& shape);
/// JSON Schema (2020-12) of the shape file.
VOLCAUSTIC_API std::string shapeSchema();

} // namespace volcaustic
