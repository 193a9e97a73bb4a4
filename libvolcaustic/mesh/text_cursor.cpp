#include "mesh/text_cursor.h"

#include <charconv>
#include <cmath>
#include <cstring>

namespace volcaustic {

namespace {

bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool isLineEnd(char c) { return c == '\n' || c == '\r'; }
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// The newline sequence at `p`: "\n", "\r\n" or a lone "\r".
std::ptrdiff_t newlineLength(const char* p, const char* end) {
  return *p == '\r' && p + 1 != end && p[1] == '\n' ? 2 : 1;
}

/// std::from_chars plus what it leaves out: a leading '+' and the "0x" of hexadecimal floats.
std::from_chars_result parseDouble(const char* p, const char* end, double& value) {
  const bool plus = p != end && *p == '+';
  if (plus) ++p;
  const bool minus = !plus && p != end && *p == '-';
  const char* digits = p + (minus ? 1 : 0);
  if (plus && digits != end && (*digits == '-' || *digits == '+')) return {p, std::errc::invalid_argument};
  if (end - digits > 2 && digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X') && digits[2] != '-') {
    const auto result = std::from_chars(digits + 2, end, value, std::chars_format::hex);
    if (minus) value = -value;
    return result;
  }
  return std::from_chars(p, end, value);
}

} // namespace

TextCursor::TextCursor(const MeshSource& source, std::size_t begin, std::size_t end, std::uint64_t line)
    : mSource(&source)
    , mAt(source.content.data() + begin)
    , mEnd(source.content.data() + end)
    , mLineFeed(nullptr)
    , mLine(line) {}

bool TextCursor::endsToken(const char* p) const { return p == mEnd || isBlank(*p) || isLineEnd(*p); }

void TextCursor::skipBlanks() {
  for (; mAt != mEnd; ++mAt) {
    if (isBlank(*mAt)) continue;
    if (*mAt != '\\') return;
    const char* p = mAt + 1;
    while (p != mEnd && isBlank(*p)) ++p;
    if (p == mEnd || !isLineEnd(*p)) return;
    mAt = p + newlineLength(p, mEnd) - 1;
    ++mLine;
  }
}

void TextCursor::skipBlanksAndLines() {
  while (mAt != mEnd) {
    if (isBlank(*mAt))
      ++mAt;
    else if (isLineEnd(*mAt) || *mAt == '#')
      nextLine();
    else
      return;
  }
}

void TextCursor::nextLine() {
  const auto find = [this](char c, const char* end) {
    const void* found = std::memchr(mAt, c, static_cast<std::size_t>(end - mAt));
    return found ? static_cast<const char*>(found) : end;
  };
  if (mAt == mEnd) return;
  if (!mLineFeed || mLineFeed < mAt) mLineFeed = find('\n', mEnd);
  mAt = find('\r', mLineFeed);
  if (mAt == mEnd) return;
  mAt += newlineLength(mAt, mEnd);
  ++mLine;
}

std::string_view TextCursor::restOfLine() {
  while (mAt != mEnd && isBlank(*mAt)) ++mAt;
  const char* first = mAt;
  while (mAt != mEnd && !isLineEnd(*mAt)) ++mAt;
  const char* last = mAt;
  while (last != first && isBlank(last[-1])) --last;
  return {first, static_cast<std::size_t>(last - first)};
}

std::string_view TextCursor::token() {
  const char* first = mAt;
  while (!endsToken(mAt)) ++mAt;
  return {first, static_cast<std::size_t>(mAt - first)};
}

void TextCursor::failAtToken(const char* problem) {
  const std::string_view text = token();
  if (text.empty())
    fail(atEnd() ? "the file ends where a number is expected; it looks truncated"
                 : "the line ends where a number is expected");
  fail(quoted(text) + " " + problem);
}

double TextCursor::number() {
  double value = 0;
  const auto [end, error] = parseDouble(mAt, mEnd, value);
  if (error == std::errc::result_out_of_range && endsToken(end)) failAtToken("is beyond the range of a double");
  if (error != std::errc{} || !endsToken(end)) failAtToken("is not a number");
  if (!std::isfinite(value)) failAtToken("is not a finite number");
  mAt = end;
  return value;
}

std::int64_t TextCursor::integer() {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(mAt, mEnd, value);
  if (error != std::errc{} || !endsToken(end)) failAtToken("is not a whole number");
  mAt = end;
  return value;
}

bool TextCursor::skipKeyword(std::string_view lowerCase) {
  if (remaining() < lowerCase.size()) return false;
  for (std::size_t i = 0; i < lowerCase.size(); ++i)
    if (lower(mAt[i]) != lowerCase[i]) return false;
  if (!endsToken(mAt + lowerCase.size())) return false;
  mAt += lowerCase.size();
  return true;
}

} // namespace volcaustic
