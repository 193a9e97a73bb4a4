// Words and figures for a terminal: aligned columns, broken lines, and nothing that a terminal would obey.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace volcaustic::cli {

/// Columns as wide as their widest cell, two blanks apart.
class TextTable {
public:
  enum class Align { Left, Right };
  struct Column {
    std::string title;
    Align align = Align::Right;
  };
  explicit TextTable(std::vector<Column> columns) : mColumns(std::move(columns)) {}

  /// A cell for each column, in plain text.
  void add(std::vector<std::string> cells) { mRows.push_back(std::move(cells)); }
  /// Titles and rows, each line behind `indent`.
  [[nodiscard]] std::string text(std::string_view indent) const;

private:
  std::vector<Column> mColumns;
  std::vector<std::vector<std::string>> mRows;
};

/// Text out of a file: control characters become blanks, and beyond `most` characters it is cut.
std::string plain(std::string_view text, std::size_t most = 60);

/// `text` in lines of at most 100 characters, the first behind `first`, the others behind as many blanks.
std::string wrapped(std::string_view first, std::string_view text);

} // namespace volcaustic::cli
