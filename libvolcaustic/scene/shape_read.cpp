#include "scene/shape_read.h"

#include "scene/field_reader.h"
#include "scene/scene_edit.h"
#include "scene/scene_json.h"
#include "scene/shape_layout.h"
#include "scene/shape_schema.h"
#include "shapes/stored_shape.h"
#include "volcaustic/error.h"
#include "volcaustic/shape_file.h"

#include <algorithm>

namespace volcaustic {

namespace {

/// Nodes and references inside each other; shapes themselves go less deep, and a thread's stack much deeper.
constexpr int kDeepest = 1200;
constexpr std::size_t kMostOpenFiles = 64;
constexpr std::size_t kLongestName = 256;

/// "a -> b -> a" for names of which each refers to the next one, and the last to `name`, which is among them.
std::string circle(const std::vector<std::string>& open, const std::string& name) {
  std::string text;
  for (auto at = std::find(open.begin(), open.end(), name); at != open.end(); ++at) text += *at + " -> ";
  return text + name;
}

/// Counts a level for as long as it lives.
class Level {
public:
  explicit Level(int& depth) : mDepth(depth) { ++mDepth; }
  ~Level() { --mDepth; }
  Level(const Level&) = delete;
  Level& operator=(const Level&) = delete;

private:
  int& mDepth;
};

Shape shapeOf(Json document, SceneSource source, const std::vector<std::string>& sets, ShapeFiles& files) {
  static const Json kDefaults = Json::object();
  source.frame = files.frame;
  applyEdits(document, sets, files.frame, {shapeSchemaDocument(), kDefaults}, source);
  rejectUnknownKeys(document, {"volcaustic", "$schema", kShapesKey, "shape", "animation"}, "", source);
  ShapeReader reader(document, source, files);
  reader.readDefinitions();
  const auto shape = document.find("shape");
  if (shape == document.end()) source.fail("/shape", "is missing; give the shape, as {\"type\": \"sphere\"}");
  requireObject(*shape, "/shape", source);
  return reader.read(*shape, "/shape");
}

} // namespace

ShapeReader::ShapeReader(const Json& document, const SceneSource& source, ShapeFiles& files)
    : mSource(source), mFiles(files) {
  const auto found = document.find(kShapesKey);
  if (found == document.end()) return;
  requireObject(*found, std::string("/") + kShapesKey, source);
  for (const auto& [name, json] : found->items()) mDefinitions.emplace(name, &json);
}

void ShapeReader::readDefinitions() {
  for (const auto& [name, json] : mDefinitions) (void)definition(name, "");
}

Shape ShapeReader::read(const Json& json, const std::string& pointer) {
  if (!json.is_string()) return node(json, pointer);
  const std::string name = json.get<std::string>();
  return name.empty() ? Shape() : file(name, pointer);
}

Shape ShapeReader::node(const Json& json, const std::string& pointer) {
  const Level level(mFiles.depth);
  if (mFiles.depth > kDeepest)
    mSource.fail(pointer, "is nested more than 1000 deep; put more parts into one operation");
  requireObject(json, pointer, mSource);
  if (json.contains("use")) return named(json, pointer);
  if (json.contains("file")) return ofFile(json, pointer);
  return solidOrOperation(json, pointer);
}

Shape ShapeReader::solidOrOperation(const Json& json, const std::string& pointer) {
  static const std::vector<std::string> kTypes(kShapeTypes.begin(), kShapeTypes.end());
  FieldReader fields(json, pointer, mSource);
  std::string type;
  fields("type", type, kShapeTypeDoc);
  ShapeNode node;
  node.kind = kindOf(fields.indexOf(type, kTypes, pointer + "/type"));
  std::visit([&](auto& kind) { describe(fields, kind); }, node.kind);
  readNode(fields, node.name, node.placement, pointer);
  const Json* deviations = fields.find("deviations");
  const Json* part = fields.find("part");
  const Json* parts = fields.find("parts");
  fields.finish();
  if (deviations) addDeviations(*deviations, node, pointer);
  addParts(part, parts, node, pointer);
  return made(pointer, [&] { return Shape(std::move(node)); });
}

void ShapeReader::addDeviations(const Json& json, ShapeNode& node, const std::string& pointer) {
  const std::string here = pointer + "/deviations";
  if (!isQuadric(node.kind)) mSource.fail(here, "are for quadrics alone, from quadric to hyperboloid; leave them out");
  requireArray(json, here, mSource);
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string element = here + "/" + std::to_string(i);
    FieldReader fields(json[i], element, mSource);
    Deviation deviation;
    fields("weight", deviation.weight, kWeightDoc);
    const Json* region = fields.find("region");
    fields.finish();
    if (!region) mSource.fail(element + "/region", std::string("is missing; give the region: ") + kRegionText);
    deviation.region = this->node(*region, element + "/region");
    node.deviations.push_back(std::move(deviation));
  }
}

void ShapeReader::addParts(const Json* part, const Json* parts, ShapeNode& node, const std::string& pointer) {
  const ShapeParts wanted = partsOf(node.kind);
  const auto reject = [&](const Json* given, const char* key, const char* instead) {
    const bool isSolid = wanted == ShapeParts::None;
    if (given) mSource.fail(pointer + "/" + key, isSolid ? "a solid has no parts; give them to an operation" : instead);
  };
  if (wanted != ShapeParts::One) reject(part, "part", "the operation takes several; write \"parts\": [ ... ]");
  if (wanted != ShapeParts::Many) reject(parts, "parts", "the operation takes one; write \"part\": { ... }");
  if (wanted == ShapeParts::One) {
    if (!part) mSource.fail(pointer + "/part", std::string("is missing; give the shape ") + kPartText);
    node.parts.push_back(this->node(*part, pointer + "/part"));
  }
  if (wanted == ShapeParts::Many) {
    if (!parts) mSource.fail(pointer + "/parts", "are missing; give the shapes of the operation, as [ ... ]");
    requireArray(*parts, pointer + "/parts", mSource);
    for (std::size_t i = 0; i < parts->size(); ++i)
      node.parts.push_back(this->node((*parts)[i], pointer + "/parts/" + std::to_string(i)));
  }
}

template <class Make>
Shape ShapeReader::made(const std::string& pointer, const Make& make) const {
  try {
    Shape shape = make();
    if (StoredShape::of(shape).size <= StoredShape::kLargest) return shape;
  } catch (const Error& error) { // which knows no place
    mSource.fail(pointer, error.what());
  }
  mSource.fail(pointer, "has more than a million nodes once its copies are written out; use fewer");
}

void ShapeReader::readNode(FieldReader& fields, std::string& name, Placement& placement,
                           const std::string& pointer) const {
  describeNode(fields, name, placement);
  if (name.size() > kLongestName) mSource.fail(pointer + "/name", "is longer than 256 bytes; give a shorter name");
}

Shape ShapeReader::reference(FieldReader& fields, const Shape& shape, const std::string& pointer) const {
  std::string name;
  Placement placement;
  readNode(fields, name, placement, pointer);
  fields.finish();
  return made(pointer, [&] {
    const Shape called = name.empty() ? shape : shape.named(name);
    return affine(placement) == kIdentity ? called : called.placed(placement);
  });
}

Shape ShapeReader::named(const Json& json, const std::string& pointer) {
  FieldReader fields(json, pointer, mSource);
  NamedShape target;
  describe(fields, target);
  return reference(fields, definition(target.use, pointer + "/use"), pointer);
}

Shape ShapeReader::ofFile(const Json& json, const std::string& pointer) {
  FieldReader fields(json, pointer, mSource);
  ShapeOfFile target;
  describe(fields, target);
  return reference(fields, file(target.file, pointer + "/file"), pointer);
}

const Shape& ShapeReader::definition(const std::string& name, const std::string& pointer) {
  if (const auto known = mMade.find(name); known != mMade.end()) return known->second;
  const auto found = mDefinitions.find(name);
  if (found == mDefinitions.end()) {
    std::vector<std::string> names;
    for (const auto& [defined, json] : mDefinitions) names.push_back(defined);
    const std::string nearest = nearestWord(name.substr(0, kLongestName), names);
    mSource.fail(pointer, "no shape is called " + excerpt(name) + "; " +
                              (names.empty() ? "add it to /shapes" : "the nearest known one is " + excerpt(nearest)));
  }
  if (std::find(mOpen.begin(), mOpen.end(), name) != mOpen.end())
    mSource.fail(pointer, "goes in a circle: " + excerpt(circle(mOpen, name)) + "; take one of them out");
  mOpen.push_back(name);
  Shape shape = node(*found->second, std::string("/") + kShapesKey + "/" + pointerToken(name));
  mOpen.pop_back();
  return mMade.emplace(name, std::move(shape)).first->second;
}

const Shape& ShapeReader::file(const std::string& name, const std::string& pointer) {
  const std::filesystem::path path = mSource.pathOf(name);
  std::error_code ignored;
  const std::filesystem::path key = std::filesystem::weakly_canonical(path, ignored);
  if (const auto known = mFiles.made.find(key); known != mFiles.made.end()) return known->second;
  if (!std::filesystem::is_regular_file(path, ignored))
    throw Error(ErrorKind::File, mSource.name + ":" + pointer + ": no such file: " + path.string() +
                                     "; paths start at the file that names them");
  if (std::find(mFiles.open.begin(), mFiles.open.end(), key) != mFiles.open.end())
    mSource.fail(pointer, "goes in a circle: " + path.string() + " refers to itself; take the reference out");
  if (mFiles.open.size() == kMostOpenFiles)
    mSource.fail(pointer, "is the 65th file that refers to another one; put some of them into one");
  mFiles.open.push_back(key);
  const SceneSource source{path.string(), path.parent_path(), {}};
  Shape shape = shapeOf(parseDocument(readDocumentText(path), source), source, {}, mFiles);
  mFiles.open.pop_back();
  return mFiles.made.emplace(key, std::move(shape)).first->second;
}

Shape parseShape(const std::string& text, const std::filesystem::path& name, const ShapeReadOptions& options) {
  const SceneSource source{name.string(), name.parent_path(), {}};
  ShapeFiles files(options.frame);
  std::error_code ignored;
  files.open.push_back(std::filesystem::weakly_canonical(name, ignored));
  return shapeOf(parseDocument(text, source), source, options.sets, files);
}

Shape readShape(const std::filesystem::path& path, const ShapeReadOptions& options) {
  return parseShape(readDocumentText(path), path, options);
}

bool isShapeFile(const std::filesystem::path& path) {
  std::error_code ignored;
  if (path.extension() != ".json" || !std::filesystem::is_regular_file(path, ignored)) return false;
  try {
    const Json document = parseJson(readDocumentText(path), path.string());
    return document.is_object() && document.contains("shape");
  } catch (const Error&) {
    return false; // whoever reads it as what it is not says why
  }
}

} // namespace volcaustic
