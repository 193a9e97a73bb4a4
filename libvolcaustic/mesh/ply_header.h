// The header of a PLY file: G. Turk, "The PLY Polygon File Format", 1994.
#pragma once

#include "mesh/source.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace volcaustic {

enum class PlyEncoding { Text, LittleEndian, BigEndian };
enum class PlyType : std::uint8_t { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };

constexpr std::size_t plySize(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<int>(type)];
}
constexpr bool isWhole(PlyType type) { return type != PlyType::Float32 && type != PlyType::Float64; }

struct PlyProperty {
  std::string name;
  std::optional<PlyType> countType; ///< of a list
  PlyType type = PlyType::Float32;  ///< of the value, or of the list's items
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// Fewest bytes of a row in a binary file.
  [[nodiscard]] std::uint64_t minimumRowBytes() const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::Text;
  std::vector<PlyElement> elements;
  std::size_t bodyOffset = 0;
  std::uint64_t bodyLine = 1;
};

PlyHeader readPlyHeader(const MeshSource& source);

} // namespace volcaustic
