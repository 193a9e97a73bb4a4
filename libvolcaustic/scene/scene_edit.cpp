#include "scene/scene_edit.h"

#include "core/nearest_word.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace volcaustic {

namespace {

/// Why a path leads nowhere, with the nearest path that leads somewhere.
struct NoSuchPlace {
  std::size_t depth;   ///< the key at fault
  std::string nearest; ///< known key in its place; empty when there is none
  std::string reason;
};

struct Place {
  Json* value;
  const Json* schema;
};

/// For conditions that name keys, and values of keys.
bool meets(const Json& value, const Json& condition) {
  if (!value.is_object()) return false;
  for (const Json& key : condition.at("required"))
    if (!value.contains(key.get<std::string>())) return false;
  if (const auto properties = condition.find("properties"); properties != condition.end())
    for (const auto& [key, wanted] : properties->items())
      if (value.at(key) != wanted.at("const")) return false;
  return true;
}

/// What `schema` comes to for `value`: references are followed, and of alternatives the one is taken that has keys of
/// its own, or whose condition the value meets.
const Json& structured(const Json& schema, const Json& value, const Json& root) {
  if (const auto reference = schema.find("$ref"); reference != schema.end()) {
    const std::string name = reference->get<std::string>().substr(std::string_view("#/$defs/").size());
    return structured(root.at("$defs").at(name), value, root);
  }
  if (const auto alternatives = schema.find("oneOf"); alternatives != schema.end())
    for (const Json& alternative : *alternatives)
      if (alternative.contains("properties") || alternative.contains("$ref"))
        return structured(alternative, value, root);
  if (const auto conditions = schema.find("allOf"); conditions != schema.end())
    for (const Json& condition : *conditions)
      if (meets(value, condition.at("if"))) return structured(condition.at("then"), value, root);
  return schema;
}

std::vector<std::string> keysOf(const Json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

std::optional<std::size_t> indexOf(const std::string& key) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
  if (error != std::errc() || end != key.data() + key.size()) return std::nullopt;
  return index;
}

/// Walks a document along its schema, and makes what is not there from defaults.
class Walk {
public:
  Walk(Json& document, const DocumentKind& kind, const std::vector<std::string>& path)
      : mRoot(kind.schema), mValue(&document), mSchema(&kind.schema), mDefaults(&kind.defaults), mPath(path) {}

  Place end() {
    for (mDepth = 0; mDepth < mPath.size(); ++mDepth) {
      mSchema = &structured(*mSchema, *mValue, mRoot);
      if (mSchema->contains("properties"))
        enterProperty();
      else if (const auto any = mSchema->find("additionalProperties"); any != mSchema->end())
        enterNamed(*any);
      else if (const auto items = mSchema->find("items"); items != mSchema->end())
        enterElement(*items);
      else
        throw NoSuchPlace{mDepth, "", "has no parts"};
    }
    return {mValue, mSchema};
  }

private:
  const std::string& key() const { return mPath[mDepth]; }
  bool last() const { return mDepth + 1 == mPath.size(); }

  void stepTo(Json& value, const Json& schema) {
    mValue = &value;
    mSchema = &schema;
  }

  void makeContainer(const Json& empty) {
    if (mValue->type() != empty.type()) *mValue = empty;
  }

  const Json* childDefault() const {
    if (!mDefaults || !mDefaults->is_object()) return nullptr;
    const auto found = mDefaults->find(key());
    return found == mDefaults->end() ? nullptr : &*found;
  }

  void enterProperty() {
    const Json& properties = mSchema->at("properties");
    const auto property = properties.find(key());
    if (property == properties.end()) throw NoSuchPlace{mDepth, nearestWord(key(), keysOf(properties)), "is not known"};
    makeContainer(Json::object());
    mDefaults = childDefault();
    if (const auto stated = property->find("default"); !mDefaults && stated != property->end()) mDefaults = &*stated;
    if (!mValue->contains(key())) (*mValue)[key()] = mDefaults ? *mDefaults : Json();
    stepTo((*mValue)[key()], *property);
  }

  void enterNamed(const Json& schema) {
    makeContainer(Json::object());
    // A misspelled name must not make a new element by the way; a whole new one is meant.
    if (!mValue->contains(key()) && !last())
      throw NoSuchPlace{mDepth, nearestWord(key(), keysOf(*mValue)), "is not there"};
    mDefaults = childDefault();
    stepTo((*mValue)[key()], schema);
  }

  void enterElement(const Json& schema) {
    makeContainer(Json::array());
    mDefaults = nullptr;
    const std::size_t size = mValue->size();
    const std::optional<std::size_t> index = indexOf(key());
    if (index == size && last()) mValue->push_back(nullptr);
    if (!index || *index >= mValue->size())
      throw NoSuchPlace{mDepth, size ? std::to_string(size - 1) : "",
                        "is not among its " + std::to_string(size) + " elements"};
    stepTo((*mValue)[*index], schema);
  }

  const Json& mRoot;
  Json* mValue;
  const Json* mSchema;
  const Json* mDefaults;
  const std::vector<std::string>& mPath;
  std::size_t mDepth = 0;
};

std::string joined(const std::vector<std::string>& path, std::size_t count, const char* separator) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += (i ? separator : "") + path[i];
  return text;
}

std::string explanation(const NoSuchPlace& problem, std::vector<std::string> path, const char* separator) {
  std::string text = "\"" + joined(path, problem.depth + 1, separator) + "\" " + problem.reason;
  if (problem.nearest.empty()) return text + "; stop at \"" + joined(path, problem.depth, separator) + "\"";
  path[problem.depth] = problem.nearest;
  return text + "; the nearest known one is \"" + joined(path, problem.depth + 1, separator) + "\"";
}

std::vector<std::string> dottedKeys(const std::string& path) {
  std::vector<std::string> keys(1);
  for (const char c : path)
    if (c == '.')
      keys.emplace_back();
    else
      keys.back() += c;
  return keys;
}

/// One animated value: keys in order of frame, each a frame and numbers.
class Track {
public:
  Track(const Json& keys, const std::string& pointer, const SceneSource& source) {
    if (!keys.is_array() || keys.empty()) source.fail(pointer, "must be an array of [frame, value] pairs");
    for (std::size_t i = 0; i < keys.size(); ++i) addKey(keys[i], pointer + "/" + std::to_string(i), source);
  }

  Json at(double frame) const {
    const auto after = std::upper_bound(mFrames.begin(), mFrames.end(), frame);
    if (after == mFrames.begin()) return value(mValues.front());
    const auto last = static_cast<std::size_t>(after - mFrames.begin()) - 1;
    if (after == mFrames.end() || frame == mFrames[last]) return value(mValues[last]);
    const double t = (frame - mFrames[last]) / (mFrames[last + 1] - mFrames[last]);
    std::vector<double> between(mValues[last].size());
    for (std::size_t i = 0; i < between.size(); ++i) between[i] = std::lerp(mValues[last][i], mValues[last + 1][i], t);
    return value(between);
  }

private:
  void addKey(const Json& key, const std::string& pointer, const SceneSource& source) {
    if (!key.is_array() || key.size() != 2 || !key[0].is_number())
      source.fail(pointer, "must be a [frame, value] pair, not " + excerpt(key));
    const Json& value = key[1];
    const bool numbers =
        value.is_array() && std::all_of(value.begin(), value.end(), [](const Json& v) { return v.is_number(); });
    if (!value.is_number() && !numbers)
      source.fail(pointer + "/1", "must be a number or an array of numbers, not " + excerpt(value));
    if (!mFrames.empty() && !(key[0].get<double>() > mFrames.back()))
      source.fail(pointer + "/0",
                  "frame " + excerpt(key[0]) + " does not come after the one before it; put keys in order");
    if (!mValues.empty() && (value.is_array() != mArray || (mArray && value.size() != mValues.back().size())))
      source.fail(pointer + "/1", "has another shape than the value before it");
    mArray = value.is_array();
    mFrames.push_back(key[0].get<double>());
    mValues.push_back(mArray ? value.get<std::vector<double>>() : std::vector<double>{value.get<double>()});
  }

  Json value(const std::vector<double>& numbers) const { return mArray ? Json(numbers) : Json(numbers.front()); }

  bool mArray = false;
  std::vector<double> mFrames;
  std::vector<std::vector<double>> mValues;
};

/// True for a number or an array of numbers that may take any value in a range.
bool isContinuous(const Json& schema) {
  if (const auto items = schema.find("items"); items != schema.end()) return isContinuous(*items);
  return schema.value("type", "") == "number";
}

void applyAnimation(Json& document, double frame, const DocumentKind& kind, const SceneSource& source) {
  const auto found = document.find("animation");
  if (found == document.end()) return;
  const Json animation = *found;
  document.erase("animation");
  if (!animation.is_object()) source.fail("/animation", "must be an object of tracks, not " + excerpt(animation));
  for (const auto& [target, keys] : animation.items()) {
    const std::string pointer = "/animation/" + pointerToken(target);
    if (!target.starts_with('/')) source.fail(pointer, "must be a JSON pointer, as /lights/0/direction");
    const Track track(keys, pointer, source);
    const std::vector<std::string> path = pointerKeys(target);
    try {
      const Place place = Walk(document, kind, path).end();
      if (!isContinuous(*place.schema)) source.fail(pointer, "only numbers that need not be whole can be animated");
      *place.value = track.at(frame);
    } catch (const NoSuchPlace& problem) {
      source.fail(pointer, explanation(problem, path, "/"));
    }
  }
}

void applySet(Json& document, const std::string& set, const DocumentKind& kind, SceneSource& source) {
  const auto equals = set.find('=');
  if (equals == std::string::npos || equals == 0)
    throw Error(ErrorKind::Usage, "set " + set + ": has no value; write it as photons.grid=[512,512]");
  const std::vector<std::string> path = dottedKeys(set.substr(0, equals));
  const std::string text = set.substr(equals + 1);
  // What is not JSON is a bare word, so that strings need no quotes inside a shell's quotes.
  Json value = Json::parse(text, nullptr, false);
  if (value.is_discarded()) value = text;
  try {
    *Walk(document, kind, path).end().value = std::move(value);
  } catch (const NoSuchPlace& problem) {
    throw Error(ErrorKind::Usage, "set " + set + ": " + explanation(problem, path, "."));
  }
  std::string pointer;
  for (const std::string& key : path) pointer += "/" + pointerToken(key);
  source.sets.emplace_back(pointer, set);
}

} // namespace

void applyEdits(Json& document, const std::vector<std::string>& sets, double frame, const DocumentKind& kind,
                SceneSource& source) {
  const auto setsTrack = [](const std::string& set) { return set.starts_with("animation"); };
  for (const std::string& set : sets)
    if (setsTrack(set)) applySet(document, set, kind, source);
  applyAnimation(document, frame, kind, source);
  for (const std::string& set : sets)
    if (!setsTrack(set)) applySet(document, set, kind, source);
}

} // namespace volcaustic
