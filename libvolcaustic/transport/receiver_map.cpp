// Light maps as files.

#include "core/atomic_file.h"
#include "volcaustic/error.h"
#include "volcaustic/receivers.h"

#include <charconv>
#include <fstream>
#include <string>

namespace volcaustic {

namespace {

template <class Number>
void append(std::string& text, const Number& number) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}

/// A vertex of the texture for each corner of each triangle.
std::string objOf(const ReceiverMap& map, const std::string& picture) {
  std::string text = "# volcaustic: surface of the light map " + picture + "\n";
  for (const Vec3d& p : map.mesh.positions) {
    text += "v";
    for (const double x : p) append(text += " ", x);
    text += "\n";
  }
  for (const auto& triangle : map.textureCoordinates)
    for (const auto& [u, v] : triangle) {
      append(text += "vt ", u);
      append(text += " ", v);
      text += "\n";
    }
  for (std::size_t t = 0; t < map.mesh.triangles.size(); ++t) {
    text += "f";
    for (std::size_t i = 0; i < 3; ++i) {
      append(text += " ", std::size_t{map.mesh.triangles[t][i]} + 1);
      append(text += "/", 3 * t + i + 1);
    }
    text += "\n";
  }
  return text;
}

} // namespace

void writeReceiverMap(const std::filesystem::path& path, const ReceiverMap& map, const ImageWriteOptions& options,
                      const RunContext& ctx) {
  writeImage(path, map.image, options, ctx);
  if (!map.isMesh) return;
  std::filesystem::path surface = path;
  surface.replace_extension(".obj");
  AtomicFile file(surface);
  std::ofstream stream(file.path(), std::ios::binary);
  stream << objOf(map, path.filename().string());
  stream.close();
  if (!stream)
    throw Error(ErrorKind::File, surface.string() + ": cannot be written whole; check the space that is left");
  file.commit();
}

} // namespace volcaustic
