// Reads the reference volumes: little-endian float32 .npy, C order.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace volcaustic::test {

/// The values of an array of `count` floats.
inline std::vector<float> readNpy(const std::filesystem::path& path, std::size_t count) {
  std::ifstream file(path, std::ios::binary);
  char magic[8];
  file.read(magic, 8);
  std::uint16_t headerSize = 0;
  file.read(reinterpret_cast<char*>(&headerSize), 2);
  std::string header(headerSize, ' ');
  file.read(header.data(), headerSize);
  if (header.find("'<f4'") == std::string::npos || header.find("'fortran_order': False") == std::string::npos)
    throw std::runtime_error(path.string() + ": not a little-endian float32 array in C order");
  std::vector<float> values(count);
  file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(count * sizeof(float)));
  if (!file) throw std::runtime_error(path.string() + ": truncated");
  return values;
}

} // namespace volcaustic::test
