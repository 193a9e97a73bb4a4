// The content of a mesh file, read once and whole, and the way to complain about a place in it.
#pragma once

#include "volcaustic/mesh.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace volcaustic {

struct MeshSource {
  std::string name;      ///< as the caller wrote it, control characters replaced: what messages start with
  std::string extension; ///< lower case with its dot
  std::string content;   ///< every byte of the file
  std::size_t begin = 0; ///< where the format starts: behind a UTF-8 byte order mark

  /// Throw Error(Input): "name: what", "name:LINE: what", "name: byte N: what".
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void failAtLine(std::uint64_t line, const std::string& what) const;
  [[noreturn]] void failAtByte(std::size_t offset, const std::string& what) const;
};

/// Reads a file (or a pipe, to its end; "-" is standard input) within the context's memory limit.
/// \throws Error(File) when it cannot be opened or read, Error(Input) when it is beyond the memory limit.
MeshSource loadMeshSource(const std::filesystem::path& path, const RunContext& ctx);

/// A piece of a file fit for a one-line message: quoted, printable, not long.
std::string quoted(std::string_view text);

// One reader for each format, in a file of its own. Each throws Error(Input) as readMesh promises, except for a content
// without triangles, which readMesh rejects for all.
Mesh readObj(const MeshSource& source, const RunContext& ctx);
Mesh readPly(const MeshSource& source, const RunContext& ctx);
Mesh readStlText(const MeshSource& source, const RunContext& ctx);
Mesh readStlBinary(const MeshSource& source, const RunContext& ctx);
Mesh readOff(const MeshSource& source, const RunContext& ctx);

/// Length of the OFF keyword ("OFF", "COFF", "STCNOFF", "4OFF"...) that `text` starts with, 0 if it does not.
std::size_t offKeywordLength(std::string_view text);
/// Triangles that the header of a binary STL announces; `content` holds at least 84 bytes.
std::uint32_t binaryStlTriangleCount(std::string_view content);
inline constexpr std::size_t kBinaryStlHeaderSize = 84, kBinaryStlTriangleSize = 50;

} // namespace volcaustic
