// Shapes out of JSON: nodes, definitions that nodes refer to by name, and shape files that they refer to.
#pragma once

#include "scene/scene_source.h"
#include "volcaustic/shape.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace volcaustic {

class FieldReader;

/// What all documents that are read together share. Each file is read once, whatever refers to it.
struct ShapeFiles {
  explicit ShapeFiles(double frameAt) : frame(frameAt) {}

  double frame; ///< at which animations are evaluated
  std::map<std::filesystem::path, Shape> made;
  std::vector<std::filesystem::path> open; ///< being read, each referred to by the one before
  int depth = 0;                           ///< of nodes being read, through all files
};

/// Reads the shapes of one document. What is referred to is read once and shared, so that reading takes no longer than
/// the text is long. All throw Error(Input) with file and pointer: for a reference into itself, too, and for more than
/// a million nodes once copies are written out; Error(File) for a file that is not there.
class ShapeReader {
public:
  /// \param document, source, files outlive the reader
  ShapeReader(const Json& document, const SceneSource& source, ShapeFiles& files);

  /// All definitions of the document, so that mistakes in those that nothing refers to are found as well.
  void readDefinitions();
  /// A node, or a string: the path of a shape file, no shape where it is empty.
  Shape read(const Json& json, const std::string& pointer);

private:
  Shape node(const Json& json, const std::string& pointer);
  Shape solidOrOperation(const Json& json, const std::string& pointer);
  Shape named(const Json& json, const std::string& pointer);
  Shape ofFile(const Json& json, const std::string& pointer);
  const Shape& definition(const std::string& name, const std::string& pointer);
  const Shape& file(const std::string& name, const std::string& pointer);
  void addDeviations(const Json& json, ShapeNode& node, const std::string& pointer);
  void addParts(const Json* part, const Json* parts, ShapeNode& node, const std::string& pointer);
  void readNode(FieldReader& fields, std::string& name, Placement& placement, const std::string& pointer) const;
  Shape reference(FieldReader& fields, const Shape& shape, const std::string& pointer) const;
  template <class Make>
  Shape made(const std::string& pointer, const Make& make) const;

  const SceneSource& mSource;
  ShapeFiles& mFiles;
  std::map<std::string, const Json*> mDefinitions;
  std::map<std::string, Shape> mMade; ///< of the definitions
  std::vector<std::string> mOpen;     ///< definitions being read, each referred to by the one before
};

} // namespace volcaustic
