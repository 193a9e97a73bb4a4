// Small glTF files made in memory: numbers go into one buffer, with the views and accessors that describe them.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <sstream>
#include <string>
#include <vector>

namespace volcaustic::test {

class GltfBuilder {
public:
  /// Appends numbers as an accessor of component type T and returns its number.
  template <class T>
  int accessor(const std::vector<T>& numbers, const std::string& type, const std::string& more = "") {
    const std::size_t width = type == "SCALAR" ? 1 : static_cast<std::size_t>(type.back() - '0');
    std::ostringstream text;
    text << R"({"bufferView": )" << view(numbers) << R"(, "componentType": )" << componentType(T{}) << R"(, "count": )"
         << numbers.size() / width << R"(, "type": ")" << type << "\"" << more << "}";
    mAccessors.push_back(text.str());
    return static_cast<int>(mAccessors.size()) - 1;
  }

  /// Appends bytes as a view of the buffer and returns its number.
  template <class T>
  int view(const std::vector<T>& numbers) {
    while (mBytes.size() % 4 != 0) mBytes += '\0';
    std::ostringstream text;
    text << R"({"buffer": 0, "byteOffset": )" << mBytes.size() << R"(, "byteLength": )" << numbers.size() * sizeof(T)
         << "}";
    mViews.push_back(text.str());
    mBytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T));
    return static_cast<int>(mViews.size()) - 1;
  }

  int rawAccessor(const std::string& json) {
    mAccessors.push_back(json);
    return static_cast<int>(mAccessors.size()) - 1;
  }

  /// The document: `sections` are its other keys ("\"nodes\": [...], ...").
  [[nodiscard]] std::string json(const std::string& sections, const std::string& uri = "") const {
    std::ostringstream text;
    text << R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": )" << mBytes.size();
    if (!uri.empty()) text << R"(, "uri": ")" << uri << "\"";
    text << R"(}], "bufferViews": [)" << joined(mViews) << R"(], "accessors": [)" << joined(mAccessors) << "], "
         << sections << "}";
    return text.str();
  }

  [[nodiscard]] const std::string& bytes() const { return mBytes; }

  [[nodiscard]] std::string glb(const std::string& sections) const {
    std::string text = json(sections), binary = mBytes;
    while (text.size() % 4 != 0) text += ' ';
    while (binary.size() % 4 != 0) binary += '\0';
    return "glTF" + word(2) + word(28 + text.size() + binary.size()) + word(text.size()) + "JSON" + text +
           word(binary.size()) + std::string("BIN\0", 4) + binary;
  }

  static std::string word(std::size_t value) {
    std::string bytes;
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i) & 255);
    return bytes;
  }

private:
  static int componentType(std::int8_t) { return 5120; }
  static int componentType(std::uint8_t) { return 5121; }
  static int componentType(std::int16_t) { return 5122; }
  static int componentType(std::uint16_t) { return 5123; }
  static int componentType(std::uint32_t) { return 5125; }
  static int componentType(float) { return 5126; }

  static std::string joined(const std::vector<std::string>& parts) {
    std::string text;
    for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
    return text;
  }

  std::string mBytes;
  std::vector<std::string> mViews, mAccessors;
};

inline void writeFile(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

} // namespace volcaustic::test
