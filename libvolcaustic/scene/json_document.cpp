#include "scene/json_document.h"

#include "volcaustic/error.h"

#include <algorithm>
#include <unordered_set>

namespace volcaustic {

namespace {

constexpr std::size_t kDeepestNesting = 64;
/// A value takes some 64 bytes of memory and may be two bytes of text.
constexpr std::size_t kMostValues = std::size_t{1} << 22;

/// Builds a document from parser events. Open containers stay on a stack; only the innermost one grows, so the pointers
/// to the outer ones stay valid.
class DocumentBuilder : public nlohmann::json_sax<Json> {
public:
  DocumentBuilder(std::string_view text, std::string name) : mText(text), mName(std::move(name)) {}

  Json take() { return std::move(mRoot); }

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t&) override { return put(value); }
  bool string(string_t& value) override { return put(std::move(value)); }
  bool binary(binary_t& value) override { return put(std::move(value)); }
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& key) override {
    mKey = key;
    if (!mSeen.back().insert(key).second)
      throw Error(ErrorKind::Input,
                  mName + ":" + pointer() + "/" + pointerToken(key) + ": is given twice; remove one of the two");
    mKeys.back() = pointerToken(key);
    return true;
  }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override {
    const std::string_view before = mText.substr(0, std::min(position > 0 ? position - 1 : 0, mText.size()));
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t lastBreak = before.rfind('\n');
    const std::size_t column = before.size() - (lastBreak == std::string_view::npos ? 0 : lastBreak + 1) + 1;
    throw Error(ErrorKind::Input, mName + ":" + std::to_string(line) + ":" + std::to_string(column) +
                                      ": not JSON: " + reason(error.what()) + "; check commas, quotes and brackets");
  }

private:
  /// What nlohmann says after "[json.exception...] parse error at line 3, column 5: ".
  static std::string reason(std::string what) {
    for (const std::string_view mark : {"column ", "] "})
      if (const auto at = what.find(mark); at != std::string::npos) {
        const auto colon = what.find(": ", at);
        what = what.substr(mark == "] " || colon == std::string::npos ? at + mark.size() : colon + 2);
        break;
      }
    return what;
  }

  std::string pointer() const {
    std::string p;
    for (std::size_t i = 0; i + 1 < mOpen.size(); ++i)
      p += "/" + (mOpen[i]->is_array() ? std::to_string(mOpen[i]->size() - 1) : mKeys[i]);
    return p;
  }

  Json* add(Json&& value) {
    if (++mValues > kMostValues)
      throw Error(ErrorKind::Input, mName + ":" + pointer() + ": holds more than " + std::to_string(kMostValues) +
                                        " values; keep large data outside of the JSON");
    if (mOpen.empty()) {
      mRoot = std::move(value);
      return &mRoot;
    }
    Json& parent = *mOpen.back();
    if (parent.is_array()) {
      parent.push_back(std::move(value));
      return &parent.back();
    }
    // key() has seen that it is new; looking for it again, as operator[] does, takes time by the square of the keys.
    std::vector<Json::object_t::value_type>& members = parent.get_ref<Json::object_t&>();
    return &members.emplace_back(mKey, std::move(value)).second;
  }

  bool put(Json value) {
    add(std::move(value));
    return true;
  }

  bool open(Json container) {
    if (mOpen.size() == kDeepestNesting)
      throw Error(ErrorKind::Input, mName + ":" + pointer() + ": nested deeper than " +
                                        std::to_string(kDeepestNesting) + " levels; check the brackets");
    mOpen.push_back(add(std::move(container)));
    mKeys.emplace_back();
    mSeen.emplace_back();
    return true;
  }

  bool close() {
    mOpen.pop_back();
    mKeys.pop_back();
    mSeen.pop_back();
    return true;
  }

  std::string_view mText;
  std::string mName;
  Json mRoot;
  std::vector<Json*> mOpen;
  std::size_t mValues = 0;
  std::vector<std::unordered_set<std::string>> mSeen; // keys of each open object
  std::vector<std::string> mKeys;                     // latest key of each open object, as a pointer token
  std::string mKey;
};

std::string scalarText(const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); }

bool onOneLine(const Json& value) {
  return value.empty() || (value.is_array() &&
                           std::none_of(value.begin(), value.end(), [](const Json& v) { return v.is_structured(); }));
}

const Json* childSchema(const Json* schema, const std::string& key) {
  if (!schema) return nullptr;
  for (const char* keyword : {"properties", "additionalProperties"})
    if (const auto found = schema->find(keyword); found != schema->end() && found->is_object()) {
      if (std::string_view(keyword) == "additionalProperties") return &*found;
      if (const auto child = found->find(key); child != found->end()) return &*child;
    }
  if (const auto items = schema->find("items"); items != schema->end()) return &*items;
  return nullptr;
}

void print(const Json& value, const Json* schema, const std::string& indent, std::string& out) {
  if (!value.is_structured()) {
    out += scalarText(value);
    return;
  }
  const bool isArray = value.is_array();
  const bool flat = onOneLine(value);
  const std::string inner = indent + "  ";
  out += isArray ? "[" : "{";
  bool first = true;
  for (const auto& [key, child] : value.items()) {
    if (!first) out += flat ? ", " : ",";
    first = false;
    const Json* description = childSchema(schema, key);
    if (!flat) out += "\n";
    if (description && !isArray && description->contains("description"))
      out += inner + "// " + description->at("description").get<std::string>() + "\n";
    if (!flat) out += inner;
    if (!isArray) out += scalarText(key) + ": ";
    print(child, description, inner, out);
  }
  if (!flat) out += "\n" + indent;
  out += isArray ? "]" : "}";
}

} // namespace

Json parseJson(std::string_view text, const std::string& name) {
  DocumentBuilder builder(text, name);
  Json::sax_parse(text.begin(), text.end(), &builder, Json::input_format_t::json, true, true);
  return builder.take();
}

std::string pointerToken(std::string_view key) {
  std::string token;
  for (const char c : key) token += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return token;
}

std::vector<std::string> pointerKeys(std::string_view pointer) {
  std::vector<std::string> keys;
  for (std::size_t i = 0; i < pointer.size(); ++i) {
    if (pointer[i] == '/')
      keys.emplace_back();
    else if (pointer[i] == '~' && i + 1 < pointer.size())
      keys.back() += pointer[++i] == '1' ? '/' : '~';
    else
      keys.back() += pointer[i];
  }
  return keys;
}

std::string excerpt(const Json& value) {
  constexpr std::size_t kReadable = 48;
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > kReadable) text = text.substr(0, kReadable) + "...";
  return text;
}

std::string prettyText(const Json& value, const Json* schema) {
  std::string out;
  print(value, schema, "", out);
  return out + "\n";
}

} // namespace volcaustic
