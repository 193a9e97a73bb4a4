// Described structs (volcaustic/options.h) out of JSON, with the place of whatever is wrong.
#pragma once

#include "core/nearest_word.h"
#include "scene/scene_source.h"
#include "volcaustic/options.h"

#include <string>
#include <type_traits>
#include <vector>

namespace volcaustic {

/// \throws Error at the pointer of the first key that is not known, naming the nearest one.
void rejectUnknownKeys(const Json& object, const std::vector<std::string>& known, const std::string& pointer,
                       const SceneSource& source);
void requireObject(const Json& value, const std::string& pointer, const SceneSource& source);
void requireArray(const Json& value, const std::string& pointer, const SceneSource& source);

/// Reads the described fields of one object; keys that are not given keep the value that is there.
class FieldReader {
public:
  FieldReader(const Json& object, std::string pointer, const SceneSource& source)
      : mObject(object), mPointer(std::move(pointer)), mSource(source) {
    requireObject(object, mPointer, mSource);
  }

  template <class T>
  void operator()(const char* name, T& value, const FieldDoc& doc) {
    if (const Json* json = find(name))
      read(*json, value, doc, mPointer + "/" + name);
    else if (doc.required)
      mSource.fail(mPointer + "/" + name, std::string("is missing; give the ") + doc.text);
  }

  /// The value of a key that the caller reads, where it is given.
  const Json* find(const char* name) {
    mKnown.emplace_back(name);
    const auto found = mObject.find(name);
    return found == mObject.end() ? nullptr : &*found;
  }

  /// Which of the known words it is. \throws Error naming the nearest one.
  std::size_t indexOf(const std::string& word, const std::vector<std::string>& known, const std::string& pointer) const;

  void finish() const { rejectUnknownKeys(mObject, mKnown, mPointer, mSource); }

  template <class T>
  static void readObject(const Json& json, T& object, const std::string& pointer, const SceneSource& source) {
    FieldReader fields(json, pointer, source);
    describe(fields, object);
    fields.finish();
  }

  template <class T>
  static void readList(const Json& json, std::vector<T>& objects, const std::string& pointer,
                       const SceneSource& source) {
    requireArray(json, pointer, source);
    objects.assign(json.size(), T{});
    for (std::size_t i = 0; i < objects.size(); ++i)
      readObject(json[i], objects[i], pointer + "/" + std::to_string(i), source);
  }

private:
  void read(const Json& json, double& value, const FieldDoc& doc, const std::string& pointer) const;
  void read(const Json& json, int& value, const FieldDoc& doc, const std::string& pointer) const;
  void read(const Json& json, bool& value, const FieldDoc& doc, const std::string& pointer) const;
  void read(const Json& json, std::string& value, const FieldDoc& doc, const std::string& pointer) const;
  void read(const Json& json, std::filesystem::path& value, const FieldDoc& doc, const std::string& pointer) const;
  void read(const Json& json, AutomaticBox& value, const FieldDoc& doc, const std::string& pointer) const;
  void read(const Json& json, Shape& value, const FieldDoc& doc, const std::string& pointer) const;
  void read(const Json& json, Placement& value, const FieldDoc&, const std::string& pointer) const {
    readObject(json, value, pointer, mSource);
  }

  template <class T, std::size_t N>
  void read(const Json& json, std::array<T, N>& value, const FieldDoc& doc, const std::string& pointer) const {
    if (!json.is_array() || json.size() != N)
      mSource.fail(pointer, "must be an array of " + std::to_string(N) + " numbers, not " + excerpt(json));
    for (std::size_t i = 0; i < N; ++i) read(json[i], value[i], doc, pointer + "/" + std::to_string(i));
  }

  template <class T>
  requires std::is_enum_v<T>
  void read(const Json& json, T& value, const FieldDoc& doc, const std::string& pointer) const {
    std::string word;
    read(json, word, doc, pointer);
    const auto names = enumNames(T{});
    value = static_cast<T>(indexOf(word, {names.begin(), names.end()}, pointer));
  }

  void read(const Json& json, std::vector<double>& value, const FieldDoc& doc, const std::string& pointer) const {
    readElements(json, value, doc, pointer);
  }
  template <std::size_t N>
  void read(const Json& json, std::vector<std::array<double, N>>& value, const FieldDoc& doc,
            const std::string& pointer) const {
    readElements(json, value, doc, pointer);
  }
  template <class T>
  void read(const Json& json, std::vector<T>& value, const FieldDoc&, const std::string& pointer) const {
    readList(json, value, pointer, mSource);
  }

  template <class T>
  void readElements(const Json& json, std::vector<T>& values, const FieldDoc& doc, const std::string& pointer) const {
    requireArray(json, pointer, mSource);
    values.assign(json.size(), T{});
    for (std::size_t i = 0; i < values.size(); ++i) read(json[i], values[i], doc, pointer + "/" + std::to_string(i));
  }

  const Json& mObject;
  std::string mPointer;
  const SceneSource& mSource;
  std::vector<std::string> mKnown;
};

} // namespace volcaustic
