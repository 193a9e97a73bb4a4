// Groups of a mesh: splitting, and bodies of different materials.
#include "unit/mesh_support.h"
#include "volcaustic/medium.h"

namespace volcaustic::test {
namespace {

/// A cube in a cube, the outer in two groups that close only together; the inner one unused vertices away.
Mesh vessel() {
  return readText("vessel.obj",
                  "v 9 9 9\n" // of no face
                  "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 0 0 4\nv 4 0 4\nv 4 4 4\nv 0 4 4\n"
                  "v 1 1 1\nv 3 1 1\nv 3 3 1\nv 1 3 1\nv 1 1 3\nv 3 1 3\nv 3 3 3\nv 1 3 3\n"
                  "usemtl wall\nf 5 4 3 2\nf 6 7 8 9\nf 2 3 7 6\nf 3 4 8 7\n"
                  "usemtl wine\nf 13 12 11 10\nf 14 15 16 17\nf 10 11 15 14\nf 11 12 16 15\nf 12 13 17 16\n"
                  "f 13 10 14 17\nusemtl label\nf 4 5 9 8\nf 5 2 6 9\n");
}

Material material(const std::string& name, double index) {
  Material m;
  m.name = name;
  m.index = index;
  return m;
}

std::string complaintOf(const Mesh& mesh, const std::vector<GroupMaterial>& groups) {
  try {
    (void)bodiesByGroup(std::make_shared<Mesh>(mesh), {}, 0, groups, "vessel.obj");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Input);
    return error.what();
  }
  return {};
}

TEST(MeshGroups, SplitIntoMeshesOfTheirOwn) {
  const std::vector<Mesh> parts = splitByGroup(vessel());
  ASSERT_EQ(parts.size(), 3u);
  expectClosed(parts[1], 12, 8);
  EXPECT_EQ(parts[0].triangles.size(), 8u);
  EXPECT_EQ(parts[0].positions.size(), 8u) << "vertices of no face and of other groups are dropped";
  EXPECT_EQ(parts[2].positions.size(), 6u);
  EXPECT_EQ(parts[2].groupNames, (std::vector<std::string>{"label"}));
  EXPECT_EQ(parts[2].triangleGroup, (std::vector<std::uint32_t>(4, 0)));
  EXPECT_EQ(bounds(parts[1]).min, (Vec3d{1, 1, 1}));
  EXPECT_EQ(splitByGroup(tetrahedron()).at(0).triangles, tetrahedron().triangles);

  Mesh unused = tetrahedron();
  unused.groupNames = {"a", "none", "b"};
  unused.triangleGroup = {0, 0, 2, 2};
  const std::vector<Mesh> three = splitByGroup(unused);
  ASSERT_EQ(three.size(), 3u);
  EXPECT_TRUE(three[1].empty());
  EXPECT_EQ(three[2].triangles.size(), 2u);
}

TEST(MeshGroups, BecomeBodiesInOrderTheRestFirst) {
  const auto mesh = std::make_shared<const Mesh>(vessel());
  const std::vector<GroupMaterial> wine{{"wine", material("wine", 1.34), 2}};
  const std::vector<Body> bodies = bodiesByGroup(mesh, material("glass", 1.5), 1, wine, "vessel.obj");
  ASSERT_EQ(bodies.size(), 2u);
  expectClosed(*bodies[0].mesh, 12, 64); // wall and label are one
  EXPECT_EQ(bodies[0].mesh->groupNames, (std::vector<std::string>{"wall", "label"}));
  EXPECT_EQ(bodies[0].material.index, 1.5);
  EXPECT_EQ(bodies[0].priority, 1);
  EXPECT_EQ(bodies[0].name, "vessel.obj");
  expectClosed(*bodies[1].mesh, 12, 8);
  EXPECT_EQ(bodies[1].material.name, "wine");
  EXPECT_EQ(bodies[1].priority, 2);
  EXPECT_EQ(bodies[1].name, "vessel.obj (wine)");

  const std::vector<Body> one = bodiesByGroup(mesh, {}, 3, {}, "vessel.obj");
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].mesh, mesh) << "without assignments nothing is copied";
}

TEST(MeshGroups, EqualMaterialsAreOneBody) {
  const auto mesh = std::make_shared<const Mesh>(vessel());
  const Material glass = material("glass", 1.5), wine = material("wine", 1.34);
  const std::vector<GroupMaterial> all{{"label", glass, 0}, {"wine", wine, 1}, {"wall", glass, 0}};
  const std::vector<Body> bodies = bodiesByGroup(mesh, material("ice", 1.31), 0, all, "v");
  ASSERT_EQ(bodies.size(), 2u) << "nothing is left for the rest";
  expectClosed(*bodies[0].mesh, 12, 64);
  EXPECT_EQ(bodies[1].name, "v (wine)");
  const std::vector<GroupMaterial> asRest{{"wall", glass, 0}, {"wine", wine, 1}};
  EXPECT_EQ(bodiesByGroup(mesh, glass, 0, asRest, "v").size(), 2u);
  const std::vector<GroupMaterial> otherPriority{{"wall", glass, 1}};
  EXPECT_EQ(bodiesByGroup(mesh, glass, 0, otherPriority, "v").size(), 2u);
}

TEST(MeshGroups, UnknownAndRepeatedGroupsAreNamed) {
  EXPECT_EQ(complaintOf(vessel(), {{"Win", {}, 0}}),
            "vessel.obj: no group is called \"Win\"; the nearest known one is \"wine\"");
  EXPECT_EQ(complaintOf(vessel(), {{"wine", {}, 0}, {"wine", {}, 1}}),
            "vessel.obj: group \"wine\" is listed twice; keep one");
  EXPECT_NE(complaintOf(tetrahedron(), {{"wine", {}, 0}}).find("the mesh has none"), std::string::npos);
}

} // namespace
} // namespace volcaustic::test
