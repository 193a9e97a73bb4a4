// Which format a mesh file is in, by its content first and its extension second.
#include "mesh/source.h"

#include <algorithm>

namespace volcaustic {

namespace {

using Reader = Mesh (*)(const MeshSource&, const RunContext&);

bool startsWithIgnoringCase(std::string_view text, std::string_view lowerCase) {
  return text.size() >= lowerCase.size() &&
         std::equal(lowerCase.begin(), lowerCase.end(), text.begin(),
                    [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b - 'A' + 'a' : b); });
}

std::string_view afterBlanks(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first == text.npos ? std::string_view{} : text.substr(first);
}

/// Behind blank lines and lines of comment, where the keyword of an OFF file may hide.
std::string_view afterComments(std::string_view text) {
  for (text = afterBlanks(text); text.starts_with('#'); text = afterBlanks(text))
    text.remove_prefix(std::min(text.find_first_of("\r\n"), text.size()));
  return text;
}

/// Things that people feed to mesh readers by mistake.
void rejectOtherContent(const MeshSource& source, std::string_view text) {
  if (source.content.empty()) source.fail("is empty");
  if (text.starts_with("version https://git-lfs"))
    source.fail("is a Git LFS pointer, not the mesh itself; fetch it with 'git lfs pull'");
  if (text.starts_with("\xFE\xFF") || text.starts_with("\xFF\xFE"))
    source.fail("is UTF-16 text; save it as UTF-8 or ASCII");
  const std::string_view visible = afterBlanks(text);
  if (startsWithIgnoringCase(visible, "<!doctype") || startsWithIgnoringCase(visible, "<html"))
    source.fail("is an HTML page, not a mesh; download the file itself");
}

bool isPly(std::string_view text) {
  return text.starts_with("ply") && text.size() > 3 && (text[3] == '\n' || text[3] == '\r' || text[3] == ' ');
}

/// The exact size is the surest sign of a binary STL: its header may well start with "solid".
bool isStlBinary(std::string_view content) {
  return content.size() >= kBinaryStlHeaderSize &&
         content.size() == kBinaryStlHeaderSize + kBinaryStlTriangleSize * std::size_t{binaryStlTriangleCount(content)};
}

bool isStlText(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::string_view visible = afterBlanks(text);
  return startsWithIgnoringCase(visible, "solid") && (visible.size() == 5 || kBlanks.find(visible[5]) != kBlanks.npos);
}

bool looksBinary(std::string_view text) { return text.substr(0, 4096).find('\0') != text.npos; }

Reader chooseReader(const MeshSource& source) {
  const std::string_view text = std::string_view(source.content).substr(source.begin);
  rejectOtherContent(source, text);
  if (isPly(text)) return readPly;
  if (offKeywordLength(afterComments(text))) return readOff;
  if (isStlBinary(source.content)) return readStlBinary;
  if (isStlText(text) && !looksBinary(text)) return readStlText;
  if (source.extension == ".stl") return readStlBinary;
  if (source.extension == ".ply") source.fail("does not start with 'ply', so it is no PLY file");
  if (looksBinary(text)) source.fail("is no mesh that can be read; OBJ, PLY, STL and OFF files can");
  return source.extension == ".off" ? readOff : readObj;
}

} // namespace

Mesh readMesh(const std::filesystem::path& path, const RunContext& ctx) {
  const MeshSource source = loadMeshSource(path, ctx);
  Mesh mesh = chooseReader(source)(source, ctx);
  if (mesh.empty()) source.fail("holds no triangle; a surface made of faces is needed");
  return mesh;
}

} // namespace volcaustic
