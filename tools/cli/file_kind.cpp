#include "file_kind.h"

#include <volcaustic/error.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>

namespace volcaustic::cli {

namespace {

using namespace std::string_view_literals;

/// First bytes of the formats that have some.
constexpr std::pair<std::string_view, FileKind> kMagic[] = {
    {" BDV\0\0\0\0"sv, FileKind::Volume},
    {"NanoVDB"sv, FileKind::Volume},
    {"\x76\x2f\x31\x01"sv, FileKind::Image},
    {"\x89PNG"sv, FileKind::Image},
    {"\xff\xd8\xff"sv, FileKind::Image},
    {"#?RADIANCE"sv, FileKind::Image},
    {"#?RGBE"sv, FileKind::Image},
    {"II*\0"sv, FileKind::Image},
    {"MM\0*"sv, FileKind::Image},
    {"ply"sv, FileKind::Mesh},
    {"OFF"sv, FileKind::Mesh},
    {"solid "sv, FileKind::Mesh},
    {"glTF"sv, FileKind::Scene},
};

constexpr std::pair<std::string_view, FileKind> kExtensions[] = {
    {".vdb", FileKind::Volume},       {".nvdb", FileKind::Volume}, {".obj", FileKind::Mesh},
    {".ply", FileKind::Mesh},         {".stl", FileKind::Mesh},    {".off", FileKind::Mesh},
    {".json", FileKind::Scene},       {".exr", FileKind::Image},   {".png", FileKind::Image},
    {".jpg", FileKind::Image},        {".jpeg", FileKind::Image},  {".hdr", FileKind::Image},
    {".tif", FileKind::Image},        {".tiff", FileKind::Image},  {".tga", FileKind::Image},
    {".bmp", FileKind::Image},        {".dpx", FileKind::Image},   {".gif", FileKind::Image},
    {".jp2", FileKind::Image},        {".pbm", FileKind::Image},   {".pgm", FileKind::Image},
    {".ppm", FileKind::Image},        {".pnm", FileKind::Image},   {".sgi", FileKind::Image},
    {".webp", FileKind::Image},       {".gltf", FileKind::Scene},  {".glb", FileKind::Scene},
    {".volcaustic", FileKind::Scene},
};

/// The kind in words, with the extensions that make it.
const char* describe(FileKind kind) {
  switch (kind) {
  case FileKind::Volume:
    return "a volume (.vdb, .nvdb)";
  case FileKind::Image:
    return "an image (.exr, .png, .tif, .hdr, ...)";
  case FileKind::Mesh:
    return "a mesh (.obj, .ply, .stl, .off)";
  case FileKind::Scene:
    break;
  }
  return "a scene (.json, .volcaustic, .gltf, .glb)";
}

std::optional<FileKind> byExtension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  for (const auto& [known, kind] : kExtensions)
    if (extension == known) return kind;
  return std::nullopt;
}

} // namespace

FileKind fileKind(const std::string& path) {
  std::error_code ignored;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, ignored))
    throw Error(ErrorKind::File, path + ": cannot be opened; check the path and its permissions");
  char start[16] = {};
  file.read(start, sizeof start);
  const std::string_view bytes(start, static_cast<std::size_t>(file.gcount()));
  for (const auto& [magic, kind] : kMagic)
    if (bytes.starts_with(magic)) return kind;
  if (const auto kind = byExtension(path)) return *kind;
  throw Error(ErrorKind::Input,
              path + ": is not a mesh, an image, a volume or a scene; check the file and its extension");
}

void checkFolderOf(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::error_code ignored;
  if (!folder.empty() && !std::filesystem::is_directory(folder, ignored))
    throw Error(ErrorKind::File, path + ": there is no folder " + folder.string() + "; make it first");
}

void checkOutput(const std::string& path, FileKind kind) {
  if (path == "-" && kind == FileKind::Volume) return;
  if (byExtension(path) != kind)
    throw Error(ErrorKind::Usage, path + ": is not the name of " + describe(kind) + "; give it such an extension");
  checkFolderOf(path);
}

} // namespace volcaustic::cli
