// 64-bit FNV-1a: keys of stages and scenes. Not for security.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace volcaustic {

class Hash {
public:
  Hash& bytes(const void* data, std::size_t size) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) mState = (mState ^ p[i]) * 0x100000001b3ull;
    return *this;
  }
  /// Length first, so that ("ab", "c") and ("a", "bc") differ.
  Hash& text(std::string_view s) { return value(s.size()).bytes(s.data(), s.size()); }
  template <class T>
  Hash& value(const T& v) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    return bytes(&v, sizeof v);
  }
  template <class T>
  Hash& values(std::span<const T> v) {
    return value(v.size()).bytes(v.data(), v.size_bytes());
  }
  [[nodiscard]] std::uint64_t digest() const { return mState; }
  [[nodiscard]] std::string hex() const {
    std::string s(16, '0');
    for (int i = 0; i < 16; ++i) s[i] = "0123456789abcdef"[(mState >> (60 - 4 * i)) & 15];
    return s;
  }

private:
  std::uint64_t mState = 0xcbf29ce484222325ull;
};

} // namespace volcaustic
