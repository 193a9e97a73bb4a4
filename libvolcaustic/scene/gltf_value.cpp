#include "scene/gltf_value.h"

#include "volcaustic/error.h"

#include <cmath>

namespace volcaustic {

void GltfValue::fail(const std::string& what) const {
  throw Error(ErrorKind::Input, *mFile + ":" + (mPointer.empty() ? "/" : mPointer) + ": " + what);
}

std::optional<GltfValue> GltfValue::find(const char* key) const {
  if (!mJson->is_object()) fail("must be an object, not " + excerpt(*mJson));
  const auto found = mJson->find(key);
  if (found == mJson->end()) return std::nullopt;
  return GltfValue(*found, *mFile, mPointer + "/" + key);
}

GltfValue GltfValue::at(const char* key) const {
  if (const auto value = find(key)) return *value;
  fail(std::string("has no \"") + key + "\"; export it again");
}

std::optional<GltfValue> GltfValue::extension(const char* name) const {
  const auto extensions = find("extensions");
  return extensions ? extensions->find(name) : std::nullopt;
}

std::size_t GltfValue::size() const {
  if (!mJson->is_array()) fail("must be an array, not " + excerpt(*mJson));
  return mJson->size();
}

GltfValue GltfValue::operator[](std::size_t index) const {
  return GltfValue((*mJson)[index], *mFile, mPointer + "/" + std::to_string(index));
}

double GltfValue::number(double min, double max) const {
  if (!mJson->is_number()) fail("must be a number, not " + excerpt(*mJson));
  const double value = mJson->get<double>();
  if (!(value >= min && value <= max))
    fail(excerpt(*mJson) + " is out of range; give a value from " + excerpt(min) + " to " + excerpt(max));
  return value;
}

std::uint64_t GltfValue::whole() const {
  constexpr double kMost = 9007199254740992.0; // 2^53: beyond it doubles skip whole numbers
  const double value = number(0, kMost);
  if (value != std::floor(value)) fail("must be a whole number, not " + excerpt(*mJson));
  return static_cast<std::uint64_t>(value);
}

bool GltfValue::flag() const {
  if (!mJson->is_boolean()) fail("must be true or false, not " + excerpt(*mJson));
  return mJson->get<bool>();
}

const std::string& GltfValue::text() const {
  if (!mJson->is_string()) fail("must be a string, not " + excerpt(*mJson));
  return mJson->get_ref<const std::string&>();
}

} // namespace volcaustic
