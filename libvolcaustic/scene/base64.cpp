#include "scene/base64.h"

#include <array>

namespace volcaustic {

namespace {

constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr unsigned kNone = 64;

constexpr std::array<std::uint8_t, 256> digits() {
  std::array<std::uint8_t, 256> table{};
  table.fill(kNone);
  for (std::size_t i = 0; i < kAlphabet.size(); ++i)
    table[static_cast<unsigned char>(kAlphabet[i])] = static_cast<std::uint8_t>(i);
  return table;
}

std::string_view withoutPadding(std::string_view text) {
  for (int i = 0; i < 2 && text.ends_with('='); ++i) text.remove_suffix(1);
  return text;
}

} // namespace

std::uint64_t base64Size(std::string_view text) { return std::uint64_t{withoutPadding(text).size()} * 3 / 4; }

std::string decodeBase64(std::string_view text) {
  static constexpr auto kDigits = digits();
  std::string bytes;
  bytes.reserve(base64Size(text));
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : withoutPadding(text)) {
    const unsigned digit = kDigits[static_cast<unsigned char>(c)];
    if (digit == kNone) break;
    bits = bits << 6 | digit;
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes += static_cast<char>(bits >> held);
  }
  return bytes;
}

} // namespace volcaustic
