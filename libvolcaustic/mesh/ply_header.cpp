#include "mesh/ply_header.h"

#include <algorithm>
#include <charconv>

namespace volcaustic {

namespace {

std::optional<PlyType> plyType(std::string_view name) {
  static constexpr std::pair<std::string_view, PlyType> kNames[] = {
      {"char", PlyType::Int8},      {"int8", PlyType::Int8},       {"uchar", PlyType::Uint8},
      {"uint8", PlyType::Uint8},    {"short", PlyType::Int16},     {"int16", PlyType::Int16},
      {"ushort", PlyType::Uint16},  {"uint16", PlyType::Uint16},   {"int", PlyType::Int32},
      {"int32", PlyType::Int32},    {"uint", PlyType::Uint32},     {"uint32", PlyType::Uint32},
      {"float", PlyType::Float32},  {"float32", PlyType::Float32}, {"double", PlyType::Float64},
      {"float64", PlyType::Float64}};
  for (const auto& [known, type] : kNames)
    if (known == name) return type;
  return {};
}

std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> result;
  constexpr std::string_view kBlanks = " \t\r";
  for (std::size_t at = line.find_first_not_of(kBlanks); at != line.npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    result.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
  return result;
}

class HeaderReader {
public:
  explicit HeaderReader(const MeshSource& source) : mSource(source), mAt(source.begin) {}

  PlyHeader read();

private:
  std::string_view nextLine();
  void readFormat(const std::vector<std::string_view>& line);
  void readElement(const std::vector<std::string_view>& line);
  void readProperty(const std::vector<std::string_view>& line);
  PlyType readType(std::string_view name);
  [[noreturn]] void fail(const std::string& what) { mSource.failAtLine(mLine, what); }

  const MeshSource& mSource;
  std::size_t mAt;
  std::uint64_t mLine = 0; // of the line read last
  char mNewline = '\n';    // "\r" only in a file whose first line ends with a lone one
  bool mHasFormat = false;
  PlyHeader mHeader;
};

PlyHeader HeaderReader::read() {
  const std::string& content = mSource.content;
  const std::size_t magicEnd = std::min(content.find_first_of("\r\n", mAt), content.size());
  if (magicEnd + 1 < content.size() && content[magicEnd] == '\r' && content[magicEnd + 1] != '\n') mNewline = '\r';
  nextLine(); // "ply"
  for (;;) {
    const std::vector<std::string_view> line = words(nextLine());
    if (line.empty() || line[0] == "comment" || line[0] == "obj_info") continue;
    if (line[0] == "end_header") break;
    if (line[0] == "format")
      readFormat(line);
    else if (line[0] == "element")
      readElement(line);
    else if (line[0] == "property")
      readProperty(line);
    else
      fail("header line starts with " + quoted(line[0]) + "; expected format, element, property or end_header");
  }
  if (!mHasFormat) fail("the header has no format line");
  mHeader.bodyOffset = mAt; // right behind one newline: binary data may well start with a byte that looks like another
  mHeader.bodyLine = mLine + 1;
  return std::move(mHeader);
}

std::string_view HeaderReader::nextLine() {
  const std::string_view rest = std::string_view(mSource.content).substr(mAt);
  ++mLine;
  const std::size_t length = rest.find(mNewline);
  if (length == rest.npos) {
    // The last line may be end_header without a newline where no data follow.
    if (rest != "end_header") fail("the file ends within its header, before end_header; it looks truncated");
    mAt = mSource.content.size();
    return rest;
  }
  mAt += length + 1;
  return rest.substr(0, length);
}

void HeaderReader::readFormat(const std::vector<std::string_view>& line) {
  const std::string_view name = line.size() > 1 ? line[1] : std::string_view{};
  if (name == "ascii")
    mHeader.encoding = PlyEncoding::Text;
  else if (name == "binary_little_endian")
    mHeader.encoding = PlyEncoding::LittleEndian;
  else if (name == "binary_big_endian")
    mHeader.encoding = PlyEncoding::BigEndian;
  else
    fail("format " + quoted(name) + " is none of ascii, binary_little_endian and binary_big_endian");
  mHasFormat = true;
}

void HeaderReader::readElement(const std::vector<std::string_view>& line) {
  if (line.size() != 3) fail("an element line must be 'element NAME COUNT'");
  PlyElement element;
  element.name = line[1];
  const char* end = line[2].data() + line[2].size();
  const auto [p, error] = std::from_chars(line[2].data(), end, element.count);
  if (error != std::errc{} || p != end) fail("element count " + quoted(line[2]) + " is not a whole number");
  mHeader.elements.push_back(std::move(element));
}

PlyType HeaderReader::readType(std::string_view name) {
  const auto type = plyType(name);
  if (!type) fail("unknown property type " + quoted(name));
  return *type;
}

void HeaderReader::readProperty(const std::vector<std::string_view>& line) {
  if (mHeader.elements.empty()) fail("a property before any element");
  PlyProperty property;
  if (line.size() == 5 && line[1] == "list") {
    property.countType = readType(line[2]);
    if (!isWhole(*property.countType)) fail("a list cannot be counted in " + quoted(line[2]));
    property.type = readType(line[3]);
    property.name = line[4];
  } else if (line.size() == 3) {
    property.type = readType(line[1]);
    property.name = line[2];
  } else {
    fail("a property line must be 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
  }
  mHeader.elements.back().properties.push_back(std::move(property));
}

} // namespace

std::uint64_t PlyElement::minimumRowBytes() const {
  std::uint64_t bytes = 0;
  for (const PlyProperty& p : properties) bytes += plySize(p.countType.value_or(p.type));
  return bytes;
}

PlyHeader readPlyHeader(const MeshSource& source) { return HeaderReader(source).read(); }

} // namespace volcaustic
