// A value of a glTF document together with its place, so that whatever is wrong with it can be said with its pointer.
#pragma once

#include "scene/json_document.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace volcaustic {

/// Points into a document that must outlive it. The functions throw Error(Input) "file:/pointer: what; what to try".
class GltfValue {
public:
  GltfValue(const Json& json, const std::string& file, std::string pointer = "")
      : mJson(&json), mFile(&file), mPointer(std::move(pointer)) {}

  [[nodiscard]] const std::string& pointer() const { return mPointer; }
  [[noreturn]] void fail(const std::string& what) const;

  /// The member of an object, where there is one.
  [[nodiscard]] std::optional<GltfValue> find(const char* key) const;
  /// The member of an object that has to be there.
  [[nodiscard]] GltfValue at(const char* key) const;
  /// The object "extensions"/name, where there is one.
  [[nodiscard]] std::optional<GltfValue> extension(const char* name) const;

  /// Elements of an array.
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] GltfValue operator[](std::size_t index) const;

  /// A finite number in [min, max].
  [[nodiscard]] double number(double min = -1e30, double max = 1e30) const;
  /// A whole number from 0 to 2^53.
  [[nodiscard]] std::uint64_t whole() const;
  [[nodiscard]] bool flag() const;
  [[nodiscard]] const std::string& text() const;
  template <std::size_t N>
  [[nodiscard]] std::array<double, N> numbers() const {
    if (size() != N) fail("must be an array of " + std::to_string(N) + " numbers, not " + excerpt(*mJson));
    std::array<double, N> values;
    for (std::size_t i = 0; i < N; ++i) values[i] = (*this)[i].number();
    return values;
  }

private:
  const Json* mJson;
  const std::string* mFile;
  std::string mPointer;
};

} // namespace volcaustic
