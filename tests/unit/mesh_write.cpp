// Writing: what is read back is what was written.
#include "unit/mesh_support.h"

#include <cmath>

namespace volcaustic::test {
namespace {

/// Doubles that no float holds, far from the origin, with an edge of three faces and a doubled face.
Mesh awkward() {
  Mesh mesh = tetrahedron({14678.000000123, -20171.3333333333333, 1.0 / 3});
  mesh.positions.push_back({14677.1, -20170.7, 1e-7});
  mesh.triangles.push_back({0, 3, 4});
  mesh.triangles.push_back({3, 2, 1});
  return mesh;
}

/// Triangles as corners in space, whatever the numbering: what a reader that welds must keep.
std::vector<std::array<Vec3d, 3>> corners(const Mesh& mesh) {
  std::vector<std::array<Vec3d, 3>> result;
  for (const auto& [a, b, c] : mesh.triangles)
    result.push_back({mesh.positions[a], mesh.positions[b], mesh.positions[c]});
  return result;
}

Mesh roundTrip(const std::string& name, const Mesh& mesh, bool binary, const RunContext& ctx = {}) {
  const TemporaryFolder folder;
  writeMesh(folder / name, mesh, {binary}, ctx);
  return readMesh(folder / name);
}

TEST(MeshWrite, EveryBitAndEveryFaceComesBack) {
  const Mesh mesh = awkward();
  for (const char* name : {"a.obj", "a.OFF", "a.ply", "a.stl"}) {
    const Mesh back = roundTrip(name, mesh, false);
    EXPECT_EQ(corners(back), corners(mesh)) << name;
    EXPECT_EQ(back.positions.size(), mesh.positions.size()) << name;
  }
  EXPECT_EQ(corners(roundTrip("a.ply", mesh, true)), corners(mesh));
}

TEST(MeshWrite, PlyOfFloatsStaysOneOfFloats) {
  const TemporaryFolder folder;
  writeMesh(folder / "float.ply", tetrahedron());
  writeMesh(folder / "double.ply", awkward());
  EXPECT_NE(readFile(folder / "float.ply").find("property float x"), std::string::npos);
  EXPECT_NE(readFile(folder / "double.ply").find("property double x"), std::string::npos);
  EXPECT_EQ(corners(readMesh(folder / "float.ply")), corners(tetrahedron()));
}

TEST(MeshWrite, BinaryStlHoldsFloatsQuietly) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const Mesh exact = roundTrip("a.stl", tetrahedron({0.5, 0.25, 8}), true);
  EXPECT_EQ(testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(corners(exact), corners(tetrahedron({0.5, 0.25, 8})));

  const Mesh mesh = awkward();
  int warnings = 0;
  RunContext ctx;
  ctx.onLog = [&](LogLevel level, std::string_view) { warnings += level == LogLevel::Warning; };
  const Mesh rounded = roundTrip("a.stl", mesh, true, ctx);
  EXPECT_EQ(warnings, 1);
  ASSERT_EQ(rounded.triangles.size(), mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_EQ(corners(rounded)[i][k][axis], static_cast<float>(corners(mesh)[i][k][axis]));

  Mesh huge = tetrahedron();
  huge.positions[0][0] = 1e39;
  EXPECT_THROW(roundTrip("a.stl", huge, true), Error);
  EXPECT_EQ(corners(roundTrip("a.stl", huge, false)), corners(huge));
}

TEST(MeshWrite, GroupsSurvive) {
  Mesh mesh = tetrahedron();
  mesh.groupNames = {"", "red glass", "blue"};
  mesh.triangleGroup = {0, 1, 2, 1};
  const Mesh obj = roundTrip("a.obj", mesh, true);
  EXPECT_EQ(obj.groupNames, mesh.groupNames);
  EXPECT_EQ(obj.triangleGroup, mesh.triangleGroup);
  mesh.groupNames = {"left part", "right"};
  mesh.triangleGroup = {0, 0, 1, 1};
  const Mesh stl = roundTrip("a.stl", mesh, false);
  EXPECT_EQ(stl.groupNames, mesh.groupNames);
  EXPECT_EQ(stl.triangleGroup, mesh.triangleGroup);
}

TEST(MeshWrite, FailuresLeaveTheOldFile) {
  const TemporaryFolder folder;
  writeFile(folder / "a.ply", "old");
  Mesh broken = tetrahedron();
  broken.triangles[0][0] = 77;
  EXPECT_THROW(writeMesh(folder / "a.ply", broken), Error);
  EXPECT_EQ(readFile(folder / "a.ply"), "old");
  for (const auto& [name, kind] :
       {std::pair{"a.fbx", ErrorKind::Usage}, {"a", ErrorKind::Usage}, {"none/a.obj", ErrorKind::File}})
    try {
      writeMesh(folder / name, tetrahedron());
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), kind) << error.what();
    }
}

} // namespace
} // namespace volcaustic::test
