// Small meshes, files and error checks that the tests of the mesh folder share.
#pragma once

#include "support/shared_data.h"
#include "volcaustic/error.h"
#include "volcaustic/mesh.h"

#include <cstring>
#include <fstream>
#include <string>

namespace volcaustic::test {

inline void writeFile(const std::filesystem::path& path, const std::string& content) {
  std::filesystem::remove(path); // rewriting in place makes some file systems wait for the disk
  std::ofstream(path, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
}

inline std::string readFile(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Writes `content` to a file of that name and reads it as a mesh.
inline Mesh readText(const std::string& name, const std::string& content, const RunContext& ctx = {}) {
  const TemporaryFolder folder;
  writeFile(folder / name, content);
  return readMesh(folder / name, ctx);
}

/// What reading complains about, without the folder in front; empty when it succeeds. Fails the test when the message
/// does not start with the file's name, is not one line, or has another kind than expected.
inline std::string complaint(const std::filesystem::path& path, ErrorKind kind = ErrorKind::Input,
                             const RunContext& ctx = {}) {
  try {
    (void)readMesh(path, ctx);
  } catch (const Error& error) {
    const std::string what = error.what(), name = path.string();
    EXPECT_EQ(error.kind(), kind) << what;
    EXPECT_EQ(what.find('\n'), what.npos) << what;
    EXPECT_TRUE(what.starts_with(name + ":")) << what;
    return what.substr(path.parent_path().string().size() + 1);
  }
  return {};
}

inline std::string complaintAbout(const std::string& name, const std::string& content, const RunContext& ctx = {}) {
  const TemporaryFolder folder;
  writeFile(folder / name, content);
  return complaint(folder / name, ErrorKind::Input, ctx);
}

/// The bytes of a value, most significant first when asked for.
template <class T>
std::string bytes(T value, bool bigEndian = false) {
  std::string result(sizeof value, '\0');
  std::memcpy(result.data(), &value, sizeof value);
  return bigEndian ? std::string(result.rbegin(), result.rend()) : result;
}

/// A closed tetrahedron of volume 1/6 with its right-angled corner at `origin`, faces outwards.
inline Mesh tetrahedron(const Vec3d& origin = {0, 0, 0}) {
  const auto& [x, y, z] = origin;
  Mesh mesh;
  mesh.positions = {{x, y, z}, {x + 1, y, z}, {x, y + 1, z}, {x, y, z + 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

/// A unit cube from quads, in OBJ.
inline const std::string kCubeObj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                                    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

inline void expectClosed(const Mesh& mesh, std::size_t triangles, double volume) {
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(mesh.triangles.size(), triangles);
  EXPECT_TRUE(report.closedAndConsistent());
  EXPECT_NEAR(report.signedVolume, volume, 1e-12 * std::abs(volume));
}

} // namespace volcaustic::test
