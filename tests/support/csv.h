// Reads the reference tables: a line of names, then numbers.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace volcaustic::test {

/// Columns by name.
using Table = std::map<std::string, std::vector<double>>;

inline Table readCsv(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line, cell;
  std::vector<std::string> names;
  Table table;
  std::getline(file, line);
  for (std::stringstream row(line); std::getline(row, cell, ',');) names.push_back(cell);
  while (std::getline(file, line)) {
    std::stringstream row(line);
    for (const std::string& name : names) {
      std::getline(row, cell, ',');
      table[name].push_back(cell.empty() ? 0.0 : std::stod(cell));
    }
  }
  return table;
}

} // namespace volcaustic::test
