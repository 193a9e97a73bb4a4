// checkMesh, transformed and bounds.
#include "unit/mesh_support.h"

#include <cmath>
#include <limits>

namespace volcaustic::test {
namespace {

Mesh merged(Mesh a, const Mesh& b) {
  const auto shift = static_cast<std::uint32_t>(a.positions.size());
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  return a;
}

TEST(MeshCheck, ClosedTetrahedron) {
  const MeshReport r = checkMesh(tetrahedron());
  EXPECT_EQ(r.vertices, 4u);
  EXPECT_EQ(r.triangles, 4u);
  EXPECT_EQ(r.openEdges + r.nonManifoldEdges + r.inconsistentEdges + r.duplicateFaces + r.degenerateFaces, 0u);
  EXPECT_EQ(r.components, 1u);
  EXPECT_DOUBLE_EQ(r.signedVolume, 1.0 / 6);
  EXPECT_DOUBLE_EQ(r.area, 1.5 + std::sqrt(3.0) / 2);
  EXPECT_EQ(r.bounds.max, (Vec3d{1, 1, 1}));
  EXPECT_TRUE(r.closedAndConsistent());
}

TEST(MeshCheck, OpenAndTurnedFaces) {
  Mesh open = tetrahedron();
  open.triangles.pop_back();
  MeshReport r = checkMesh(open);
  EXPECT_EQ(r.openEdges, 3u);
  EXPECT_EQ(r.inconsistentEdges, 0u);
  EXPECT_FALSE(r.closedAndConsistent());

  Mesh turned = tetrahedron();
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  r = checkMesh(turned);
  EXPECT_EQ(r.openEdges, 0u);
  EXPECT_EQ(r.inconsistentEdges, 3u);
  EXPECT_FALSE(r.closedAndConsistent());
}

TEST(MeshCheck, EdgesOfManyFaces) {
  // Two tetrahedra that touch along the edge from (0,0,0) to (0,0,1): four faces there, which cancel.
  Mesh two = merged(tetrahedron(), transformed(tetrahedron(), {{{-1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, 1, 0}}}));
  MeshReport r = checkMesh(two);
  EXPECT_EQ(r.nonManifoldEdges, 1u);
  EXPECT_EQ(r.inconsistentEdges, 0u);
  EXPECT_EQ(r.components, 1u);
  EXPECT_TRUE(r.closedAndConsistent());
  EXPECT_DOUBLE_EQ(r.signedVolume, 1.0 / 3);

  // A fin on an edge: three faces cannot cancel.
  Mesh fin = tetrahedron();
  fin.positions.push_back({-1, -1, 0});
  fin.triangles.push_back({0, 3, 4});
  r = checkMesh(fin);
  EXPECT_EQ(r.nonManifoldEdges, 1u);
  EXPECT_EQ(r.inconsistentEdges, 1u);
  EXPECT_EQ(r.openEdges, 2u);

  // The same body twice: every edge has four faces, which cancel, and winding numbers are 2 inside.
  r = checkMesh(merged(tetrahedron(), tetrahedron()));
  EXPECT_EQ(r.nonManifoldEdges, 6u);
  EXPECT_EQ(r.duplicateFaces, 4u);
  EXPECT_TRUE(r.closedAndConsistent());
}

TEST(MeshCheck, WeldsEqualPositionsOnly) {
  Mesh soup;
  const Mesh solid = tetrahedron();
  for (const auto& t : solid.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (const std::uint32_t v : t) soup.positions.push_back(solid.positions[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  soup.positions[0][1] = -0.0;
  MeshReport r = checkMesh(soup);
  EXPECT_EQ(r.vertices, 12u);
  EXPECT_TRUE(r.closedAndConsistent());
  EXPECT_EQ(r.components, 1u);
  soup.positions[0][1] = std::numeric_limits<double>::denorm_min();
  r = checkMesh(soup);
  EXPECT_EQ(r.openEdges, 4u);
}

TEST(MeshCheck, DuplicateAndDegenerateFaces) {
  Mesh mesh = tetrahedron();
  mesh.positions.push_back({0.5, 0, 0});
  mesh.triangles.push_back({1, 3, 2}); // the slanted face, turned
  mesh.triangles.push_back({0, 0, 1}); // repeated corner: none of the counts of edges may see it
  mesh.triangles.push_back({0, 4, 1}); // on a line
  const MeshReport r = checkMesh(mesh);
  EXPECT_EQ(r.duplicateFaces, 1u);
  EXPECT_EQ(r.degenerateFaces, 2u);
  EXPECT_EQ(r.openEdges, 2u);
  EXPECT_EQ(checkMesh(merged(tetrahedron(), tetrahedron({3, 0, 0}))).components, 2u);
}

TEST(MeshCheck, VolumeFarFromTheOrigin) {
  const Affine tinyAndFar{{{1e-3, 0, 0, 1e6}, {0, 1e-3, 0, -2e6}, {0, 0, 1e-3, 3e6}}};
  const MeshReport r = checkMesh(transformed(tetrahedron(), tinyAndFar));
  EXPECT_TRUE(r.closedAndConsistent());
  EXPECT_NEAR(r.signedVolume, 1e-9 / 6, 1e-9 / 6 * 1e-6);
  EXPECT_EQ(r.degenerateFaces, 0u);
}

TEST(MeshCheck, RejectsWhatIsNoMesh) {
  Mesh mesh = tetrahedron();
  mesh.triangles[2][1] = 4;
  EXPECT_THROW(checkMesh(mesh), Error);
  mesh = tetrahedron();
  mesh.positions[1][2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(checkMesh(mesh), Error);
  mesh = tetrahedron();
  mesh.triangleGroup = {0, 0, 0, 1};
  mesh.groupNames = {"only"};
  EXPECT_THROW(checkMesh(mesh), Error);
  EXPECT_EQ(checkMesh({}).components, 0u);
}

TEST(MeshTransform, VolumeScalesWithTheDeterminantAndStaysOutwards) {
  const Affine shear{{{2, 1, 0, 5}, {0, 3, 0.5, -1}, {0, 0, 0.25, 2}}};
  EXPECT_NEAR(checkMesh(transformed(tetrahedron(), shear)).signedVolume, 1.5 / 6, 1e-15);
  const Affine mirror{{{-2, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  const Mesh mirrored = transformed(tetrahedron(), mirror);
  EXPECT_DOUBLE_EQ(checkMesh(mirrored).signedVolume, 2.0 / 6);
  EXPECT_EQ(mirrored.positions[1], (Vec3d{-2, 0, 0}));
}

TEST(MeshTransform, BoundsAreThoseOfTheSurface) {
  Mesh mesh = tetrahedron({1, 2, 3});
  mesh.positions.push_back({100, 100, 100});
  const Box box = bounds(mesh);
  EXPECT_EQ(box.min, (Vec3d{1, 2, 3}));
  EXPECT_EQ(box.max, (Vec3d{2, 3, 4}));
  EXPECT_EQ(bounds({}).max, (Vec3d{0, 0, 0}));
}

} // namespace
} // namespace volcaustic::test
