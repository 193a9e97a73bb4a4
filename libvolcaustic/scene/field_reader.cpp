#include "scene/field_reader.h"

#include "scene/shape_read.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace volcaustic {

namespace {

std::string rangeText(const FieldDoc& doc) {
  std::ostringstream text;
  text.precision(12);
  text << "from " << doc.min << " to " << doc.max;
  if (*doc.unit && std::string_view(doc.unit) != "1") text << " " << doc.unit;
  return text.str();
}

} // namespace

void rejectUnknownKeys(const Json& object, const std::vector<std::string>& known, const std::string& pointer,
                       const SceneSource& source) {
  for (const auto& [key, value] : object.items())
    if (std::find(known.begin(), known.end(), key) == known.end())
      source.fail(pointer + "/" + pointerToken(key),
                  "unknown key; the nearest known one is \"" + nearestWord(key, known) + "\"");
}

void requireObject(const Json& value, const std::string& pointer, const SceneSource& source) {
  if (!value.is_object()) source.fail(pointer, "must be an object, not " + excerpt(value) + "; write { ... }");
}

void requireArray(const Json& value, const std::string& pointer, const SceneSource& source) {
  if (!value.is_array()) source.fail(pointer, "must be an array, not " + excerpt(value) + "; write [ ... ]");
}

void FieldReader::read(const Json& json, double& value, const FieldDoc& doc, const std::string& pointer) const {
  if (!json.is_number()) mSource.fail(pointer, "must be a number, not " + excerpt(json));
  const double number = json.get<double>();
  if (!std::isfinite(number) || number < doc.min || number > doc.max)
    mSource.fail(pointer, excerpt(json) + " is out of range; give a value " + rangeText(doc));
  value = number;
}

void FieldReader::read(const Json& json, int& value, const FieldDoc& doc, const std::string& pointer) const {
  double number = 0;
  read(json, number, doc, pointer);
  if (number != std::floor(number)) mSource.fail(pointer, "must be a whole number, not " + excerpt(json));
  value = static_cast<int>(number);
  if (!doc.choices.empty() && std::find(doc.choices.begin(), doc.choices.end(), value) == doc.choices.end()) {
    std::string all;
    for (const int choice : doc.choices) all += (all.empty() ? "" : ", ") + std::to_string(choice);
    mSource.fail(pointer, excerpt(json) + " is not possible; give one of " + all);
  }
}

void FieldReader::read(const Json& json, bool& value, const FieldDoc&, const std::string& pointer) const {
  if (!json.is_boolean()) mSource.fail(pointer, "must be true or false, not " + excerpt(json));
  value = json.get<bool>();
}

void FieldReader::read(const Json& json, std::string& value, const FieldDoc&, const std::string& pointer) const {
  if (!json.is_string()) mSource.fail(pointer, "must be a string, not " + excerpt(json));
  value = json.get<std::string>();
}

void FieldReader::read(const Json& json, std::filesystem::path& value, const FieldDoc& doc,
                       const std::string& pointer) const {
  std::string text;
  read(json, text, doc, pointer);
  if (doc.required && text.empty()) mSource.fail(pointer, std::string("is empty; give the ") + doc.text);
  value = text.empty() ? std::filesystem::path() : mSource.pathOf(text);
}

void FieldReader::read(const Json& json, AutomaticBox& value, const FieldDoc& doc, const std::string& pointer) const {
  value.automatic = json.is_string() && json.get<std::string>() == "auto";
  if (value.automatic) return;
  if (!json.is_object())
    mSource.fail(pointer, "must be \"auto\" or {\"min\": [x, y, z], \"max\": [x, y, z]}, not " + excerpt(json));
  FieldReader corners(json, pointer, mSource);
  FieldDoc corner = doc;
  corner.text = "corner of the box";
  corner.required = true;
  corners("min", value.box.min, corner);
  corners("max", value.box.max, corner);
  corners.finish();
}

void FieldReader::read(const Json& json, Shape& value, const FieldDoc&, const std::string& pointer) const {
  value = mSource.shapes->read(json, pointer);
}

std::size_t FieldReader::indexOf(const std::string& word, const std::vector<std::string>& known,
                                 const std::string& pointer) const {
  const auto found = std::find(known.begin(), known.end(), word);
  if (found == known.end())
    mSource.fail(pointer,
                 excerpt(word) + " is not known; the nearest known one is \"" + nearestWord(word, known) + "\"");
  return static_cast<std::size_t>(found - known.begin());
}

} // namespace volcaustic
