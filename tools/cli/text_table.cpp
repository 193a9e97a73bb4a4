#include "text_table.h"

#include <algorithm>

namespace volcaustic::cli {

namespace {

/// Characters of UTF-8 text: bytes that do not continue one.
std::size_t lengthOf(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

void appendLine(std::string& out, std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  out += line + "\n";
}

} // namespace

std::string TextTable::text(std::string_view indent) const {
  std::vector<std::size_t> width;
  for (std::size_t c = 0; c < mColumns.size(); ++c) {
    width.push_back(lengthOf(mColumns[c].title));
    for (const auto& row : mRows) width[c] = std::max(width[c], lengthOf(row[c]));
  }
  std::string out;
  const auto append = [&](auto cellOf) {
    std::string line(indent);
    for (std::size_t c = 0; c < mColumns.size(); ++c) {
      const std::string& cell = cellOf(c);
      const std::string blanks(width[c] - lengthOf(cell), ' ');
      line += (c > 0 ? "  " : "") + (mColumns[c].align == Align::Left ? cell + blanks : blanks + cell);
    }
    appendLine(out, std::move(line));
  };
  append([&](std::size_t c) -> const std::string& { return mColumns[c].title; });
  for (const auto& row : mRows) append([&](std::size_t c) -> const std::string& { return row[c]; });
  return out;
}

std::string plain(std::string_view text, std::size_t most) {
  std::string result;
  std::size_t length = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xc0) != 0x80 && ++length > most) return result + "...";
    result += byte < 0x20 || byte == 0x7f ? ' ' : c;
  }
  return result;
}

std::string wrapped(std::string_view first, std::string_view text) {
  constexpr std::size_t kWidth = 100;
  std::string out, line(first);
  const std::string blanks(lengthOf(first), ' ');
  bool fresh = true; // nothing behind the indent yet
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!fresh && lengthOf(line) + 1 + lengthOf(word) > kWidth) {
      appendLine(out, std::move(line));
      line = blanks;
      fresh = true;
    }
    if (!fresh) line += ' ';
    line += word;
    fresh = false;
  }
  appendLine(out, std::move(line));
  return out;
}

} // namespace volcaustic::cli
