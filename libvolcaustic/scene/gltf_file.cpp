#include "scene/gltf_file.h"

#include "scene/base64.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <charconv>
#include <fstream>

namespace volcaustic {

namespace {

/// Extensions that a file may require: read here, or of no matter to light inside bodies.
constexpr std::string_view kReadOrHarmless[] = {"KHR_lights_punctual", "KHR_mesh_quantization", "KHR_materials_",
                                                "KHR_texture_",        "EXT_texture_",          "KHR_xmp"};

constexpr std::uint64_t kHeaderSize = 12, kChunkHeaderSize = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

std::ifstream openFile(const std::filesystem::path& path) {
  std::error_code ignored;
  std::ifstream file;
  if (std::filesystem::is_regular_file(path, ignored)) file.open(path, std::ios::binary);
  if (!file.is_open())
    throw Error(ErrorKind::File, path.string() + ": cannot be opened; check the path and its permissions");
  return file;
}

/// Less than `size` bytes where the file ends before.
std::string readBytes(std::ifstream& file, std::uint64_t offset, std::uint64_t size) {
  std::string bytes(size, '\0');
  file.clear();
  file.seekg(static_cast<std::streamoff>(offset));
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return bytes;
}

/// A little-endian 32-bit number.
std::uint32_t word(std::string_view bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[offset + i]);
  return value;
}

/// The text of a URI without %20 and the like.
std::string unescaped(const GltfValue& uri) {
  const std::string& text = uri.text();
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      plain += text[i];
      continue;
    }
    unsigned code = 0;
    const char* digits = text.data() + i + 1;
    if (i + 2 >= text.size() || std::from_chars(digits, digits + 2, code, 16).ptr != digits + 2 || code == 0)
      uri.fail("a % must be followed by two hexadecimal digits");
    plain += static_cast<char>(code);
    i += 2;
  }
  return plain;
}

} // namespace

bool isGltfName(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension == ".gltf" || extension == ".glb";
}

GltfFile::GltfFile(const std::filesystem::path& path, const RunContext& ctx)
    : mPath(path), mName(path.string()), mContext(ctx) {
  readContainer();
  if (!mJson.is_object()) root().fail("must be an object, not " + excerpt(mJson) + "; export it again");
  checkVersion();
  checkExtensions();
  for (std::size_t i = 0; i < count("buffers"); ++i) mBuffers.push_back(placeBuffer(item("buffers", i), i == 0));
}

void GltfFile::readContainer() {
  std::ifstream file = openFile(mPath);
  const std::uint64_t fileSize = std::filesystem::file_size(mPath);
  mContext.requireMemory(fileSize, mName);
  if (readBytes(file, 0, 4) == "glTF")
    readBinary(fileSize);
  else
    mJson = parseJson(readBytes(file, 0, fileSize), mName);
}

void GltfFile::readBinary(std::uint64_t fileSize) {
  const auto damaged = [&](const std::string& what) {
    throw Error(ErrorKind::Input, mName + ": " + what + "; copy or export the file again");
  };
  std::ifstream file = openFile(mPath);
  const std::string header = readBytes(file, 0, kHeaderSize);
  if (header.size() < kHeaderSize) damaged("ends in its header");
  if (word(header, 4) != 2) damaged("is of version " + std::to_string(word(header, 4)) + " of .glb, and 2 is read");
  const std::uint64_t end = word(header, 8);
  if (end > fileSize)
    damaged("says that it is " + std::to_string(end) + " bytes long and is " + std::to_string(fileSize));
  std::string json;
  for (std::uint64_t at = kHeaderSize, next; at + kChunkHeaderSize <= end; at = next) {
    const std::string chunk = readBytes(file, at, kChunkHeaderSize);
    const std::uint64_t size = word(chunk, 0), begin = at + kChunkHeaderSize;
    const std::uint32_t type = word(chunk, 4);
    if (size > end - begin)
      damaged("has a chunk of " + std::to_string(size) + " bytes at byte " + std::to_string(at) + ", where " +
              std::to_string(end - begin) + " are left");
    if (at == kHeaderSize) {
      if (type != kJsonChunk) damaged("does not start with a JSON chunk");
      json = readBytes(file, begin, size);
    } else if (type == kBinaryChunk && mBinaryOffset == 0) {
      mBinaryOffset = begin;
      mBinarySize = size;
    }
    next = begin + size;
  }
  if (json.empty()) damaged("holds no JSON chunk");
  mJson = parseJson(json, mName);
}

void GltfFile::checkVersion() const {
  const GltfValue asset = root().at("asset");
  const GltfValue version = asset.at("version");
  if (!version.text().starts_with("2."))
    version.fail("glTF " + excerpt(version.text()) + " is not read; export glTF 2.0");
  if (const auto least = asset.find("minVersion"); least && least->text() != "2.0")
    least->fail("needs a reader of glTF " + excerpt(least->text()) + "; export glTF 2.0");
}

void GltfFile::checkExtensions() const {
  const auto required = root().find("extensionsRequired");
  for (std::size_t i = 0; required && i < required->size(); ++i) {
    const std::string& name = (*required)[i].text();
    const bool fine = std::any_of(std::begin(kReadOrHarmless), std::end(kReadOrHarmless),
                                  [&](std::string_view known) { return name.starts_with(known); });
    if (!fine)
      (*required)[i].fail("the extension " + excerpt(name) + " is not read; export without it (no compression)");
  }
}

GltfFile::Buffer GltfFile::placeBuffer(const GltfValue& buffer, bool first) const {
  const std::uint64_t size = buffer.at("byteLength").whole();
  std::uint64_t available = 0;
  Buffer place;
  if (const auto uri = buffer.find("uri")) {
    place = placeUri(*uri, available);
  } else {
    if (!first || mBinaryOffset == 0)
      buffer.fail("has no \"uri\", and the file no chunk of its bytes; export it again");
    place.path = mPath;
    place.offset = mBinaryOffset;
    available = mBinarySize;
  }
  if (size > available)
    buffer.fail("says that it has " + std::to_string(size) + " bytes, and " + std::to_string(available) +
                " are there; copy or export the file again");
  place.size = size;
  return place;
}

GltfFile::Buffer GltfFile::placeUri(const GltfValue& uri, std::uint64_t& available) const {
  Buffer place;
  const std::string_view text = uri.text();
  if (text.starts_with("data:")) {
    constexpr std::string_view kMark = ";base64,";
    const std::size_t mark = text.substr(0, 256).find(kMark);
    if (mark == text.npos) uri.fail("is embedded without base64; export it again");
    place.base64 = text.substr(mark + kMark.size());
    available = base64Size(place.base64);
    return place;
  }
  const std::filesystem::path relative = unescaped(uri);
  if (text.substr(0, text.find('/')).find(':') != text.npos || relative.is_absolute() || relative.empty())
    uri.fail(excerpt(uri.text()) + " is not read; put the file beside this one and name it without a folder");
  place.path = mPath.parent_path() / relative;
  std::error_code problem;
  if (std::filesystem::is_regular_file(place.path, problem))
    available = std::filesystem::file_size(place.path, problem);
  if (problem || !std::filesystem::is_regular_file(place.path, problem))
    throw Error(ErrorKind::File, mName + ":" + uri.pointer() + ": no such file: " + place.path.string() +
                                     "; copy it along with this one");
  return place;
}

std::vector<std::filesystem::path> GltfFile::files() const {
  std::vector<std::filesystem::path> all{mPath};
  for (const Buffer& b : mBuffers)
    if (!b.path.empty() && std::find(all.begin(), all.end(), b.path) == all.end()) all.push_back(b.path);
  return all;
}

std::string_view GltfFile::bufferBytes(std::size_t index) {
  Buffer& buffer = mBuffers[index];
  if (buffer.isRead) return buffer.bytes;
  mContext.requireMemory(buffer.size, mName);
  if (buffer.path.empty()) {
    buffer.bytes = decodeBase64(buffer.base64);
    buffer.bytes.resize(std::min<std::uint64_t>(buffer.bytes.size(), buffer.size));
  } else {
    std::ifstream file = openFile(buffer.path);
    buffer.bytes = readBytes(file, buffer.offset, buffer.size);
  }
  if (buffer.bytes.size() < buffer.size)
    item("buffers", index)
        .fail(buffer.path.empty() ? "is not base64; export it again"
                                  : "its file got shorter while it was read; try again");
  buffer.isRead = true;
  return buffer.bytes;
}

void GltfFile::countNumbers(std::uint64_t numbers, const GltfValue& place) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 31;
  mNumbersRead += numbers;
  if (mNumbersRead > kMost) place.fail("more than " + std::to_string(kMost) + " numbers are read; split the file");
}

std::size_t GltfFile::count(const char* list) const {
  const auto found = root().find(list);
  return found ? found->size() : 0;
}

GltfValue GltfFile::item(const char* list, std::size_t index) const { return root().at(list)[index]; }

std::size_t GltfFile::indexOf(const GltfValue& reference, const char* list) const {
  const std::uint64_t index = reference.whole();
  if (index >= count(list))
    reference.fail("there is no number " + std::to_string(index) + " among the " + std::to_string(count(list)) + " " +
                   list + "; export it again");
  return static_cast<std::size_t>(index);
}

GltfValue GltfFile::resolve(const GltfValue& reference, const char* list) const {
  return item(list, indexOf(reference, list));
}

} // namespace volcaustic
