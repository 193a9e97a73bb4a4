// Walks through the text of a mesh file: tokens, numbers, lines, and the line number for messages.
#pragma once

#include "mesh/source.h"

#include <cstdint>
#include <string_view>

namespace volcaustic {

class TextCursor {
public:
  /// Starts at byte `begin` of the source, which is on line `line`, and ends before byte `end`, which starts a line.
  TextCursor(const MeshSource& source, std::size_t begin, std::size_t end, std::uint64_t line);
  /// All that follows `begin`.
  TextCursor(const MeshSource& source, std::size_t begin, std::uint64_t line = 1)
      : TextCursor(source, begin, source.content.size(), line) {}

  [[nodiscard]] std::uint64_t line() const { return mLine; }
  [[nodiscard]] std::size_t offset() const { return static_cast<std::size_t>(mAt - mSource->content.data()); }
  [[nodiscard]] std::size_t remaining() const { return static_cast<std::size_t>(mEnd - mAt); }
  [[nodiscard]] bool atEnd() const { return mAt == mEnd; }
  [[noreturn]] void fail(const std::string& what) const { mSource->failAtLine(mLine, what); }

  /// Skips blanks within the line; a backslash before the end of a line counts as a blank and continues it.
  void skipBlanks();
  /// Skips blanks, line ends and comments (from '#' to the end of the line).
  void skipBlanksAndLines();
  /// True at the end of the line, of the text, or at a comment. Call after skipBlanks().
  [[nodiscard]] bool atLineEnd() const { return mAt == mEnd || *mAt == '\n' || *mAt == '\r' || *mAt == '#'; }
  /// Goes to the start of the next line.
  void nextLine();
  /// The rest of the line without blanks around it; stays before the line's end.
  std::string_view restOfLine();

  /// Characters up to the next blank, line end or text end; empty when there are none here.
  std::string_view token();
  /// A finite number, which must end at a blank, a line end or the text's end. Takes a leading '+' and hexadecimal
  /// floats.
  double number();
  /// A whole number with the same ending.
  std::int64_t integer();
  /// Skips a keyword, in any case of letters, if the cursor stands on it.
  bool skipKeyword(std::string_view lowerCase);

private:
  [[nodiscard]] bool endsToken(const char* p) const;
  [[noreturn]] void failAtToken(const char* problem);

  const MeshSource* mSource;
  const char* mAt;
  const char* mEnd;
  const char* mLineFeed; ///< the first '\n' at or after a place that has been passed: each is searched for once
  std::uint64_t mLine;
};

} // namespace volcaustic
