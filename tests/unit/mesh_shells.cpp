// checkMesh: orientation, shells and their nesting, and the words for all of it.
#include "support/solids.h"
#include "unit/mesh_support.h"

#include <bit>
#include <cmath>
#include <map>
#include <random>

namespace volcaustic::test {
namespace {

void append(Mesh& mesh, const Mesh& part) {
  const auto shift = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
  for (const auto& t : part.triangles) mesh.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
}

Mesh merged(std::initializer_list<Mesh> parts) {
  Mesh mesh;
  for (const Mesh& part : parts) append(mesh, part);
  return mesh;
}

Mesh reversed(Mesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// A cube of half side `r` around `centre`, faces outwards, turned about a diagonal by `angle`.
Mesh cube(const Vec3d& centre, double r, double angle = 0) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.push_back({i & 1 ? r : -r, i & 2 ? r : -r, i & 4 ? r : -r});
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  const double c = std::cos(angle), s = std::sin(angle), d = (1 - c) / 3, e = s / std::sqrt(3.0);
  return transformed(
      std::move(mesh),
      {{{c + d, d - e, d + e, centre[0]}, {d + e, c + d, d - e, centre[1]}, {d - e, d + e, c + d, centre[2]}}});
}

/// A closed band of `quads` quads that is turned over once: one-sided.
Mesh moebiusStrip(std::uint32_t quads) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < quads; ++i) {
    const double phi = 2 * 3.14159265358979323846 * i / quads;
    for (const double w : {-0.25, 0.25})
      mesh.positions.push_back({(1 + w * std::cos(phi / 2)) * std::cos(phi),
                                (1 + w * std::cos(phi / 2)) * std::sin(phi), w * std::sin(phi / 2)});
  }
  for (std::uint32_t i = 0; i < quads; ++i) {
    const bool last = i + 1 == quads;
    const std::uint32_t a = 2 * i, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    mesh.triangles.push_back({a, b, d});
    mesh.triangles.push_back({a, d, c});
  }
  return mesh;
}

std::vector<ShellRole> rolesOf(const MeshReport& report) {
  std::vector<ShellRole> roles;
  for (const MeshShell& shell : report.shells) roles.push_back(shell.role);
  return roles;
}

TEST(MeshOrientation, FlippedFacesAreTheFewestThatBruteForceFinds) {
  const Mesh whole = cube({0, 0, 0}, 1), open = [&] {
    Mesh mesh = whole;
    mesh.triangles.resize(9);
    return mesh;
  }();
  std::mt19937 random(5);
  for (int run = 0; run < 12; ++run) {
    Mesh mesh = run % 2 ? whole : open;
    const auto faces = static_cast<std::uint32_t>(mesh.triangles.size());
    for (auto& t : mesh.triangles)
      if (random() % 3 == 0) std::swap(t[0], t[1]);
    int fewest = 99;
    for (std::uint32_t set = 0; set < 1u << faces; ++set) {
      if (std::popcount(set) >= fewest) continue;
      Mesh turned = mesh;
      for (std::uint32_t f = 0; f < faces; ++f)
        if (set >> f & 1) std::swap(turned.triangles[f][0], turned.triangles[f][1]);
      if (checkMesh(turned).inconsistentEdges == 0) fewest = std::popcount(set);
    }
    EXPECT_EQ(checkMesh(mesh).flippedFaces, static_cast<std::uint64_t>(fewest));
  }
}

TEST(MeshOrientation, EachPatchCountsItsSmallerSide) {
  Mesh mesh = reversed(cube({0, 0, 0}, 1)); // all reversed is consistent
  EXPECT_EQ(checkMesh(mesh).flippedFaces, 0u);
  append(mesh, cube({5, 0, 0}, 1));
  std::swap(mesh.triangles[3][0], mesh.triangles[3][1]);
  for (int f = 12; f < 22; ++f) std::swap(mesh.triangles[f][0], mesh.triangles[f][1]);
  EXPECT_EQ(checkMesh(mesh).flippedFaces, 3u);
}

TEST(MeshOrientation, OneSidedPatchesAreNamedAndNotCounted) {
  MeshReport r = checkMesh(moebiusStrip(24));
  EXPECT_EQ(r.unorientablePatches, 1u);
  EXPECT_EQ(r.flippedFaces, 0u);
  EXPECT_EQ(r.inconsistentEdges, 1u);
  Mesh both = merged({moebiusStrip(24), cube({9, 0, 0}, 1)});
  std::swap(both.triangles.back()[0], both.triangles.back()[1]);
  r = checkMesh(both);
  EXPECT_EQ(r.unorientablePatches, 1u);
  EXPECT_EQ(r.flippedFaces, 1u);
}

TEST(MeshShells, HangTogetherOverEdgesNotVertices) {
  const Mesh solid = tetrahedron();
  const Mesh inVertex = merged({solid, transformed(solid, {{{-1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 0}}})});
  MeshReport r = checkMesh(inVertex);
  EXPECT_EQ(r.components, 1u);
  EXPECT_EQ(r.shellCount, 2u);
  EXPECT_EQ(r.closedShells, 2u);
  const Mesh inEdge = merged({solid, transformed(solid, {{{-1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, 1, 0}}})});
  EXPECT_EQ(checkMesh(inEdge).shellCount, 1u);
  Mesh degenerate = solid;
  degenerate.triangles.push_back({1, 1, 2});
  EXPECT_EQ(checkMesh(degenerate).shellCount, 1u) << "a face with a repeated corner is no shell";
}

TEST(MeshShells, AreMeasuredEachAndListedByArea) {
  Mesh mesh = merged({cube({0, 0, 0}, 0.5), reversed(cube({1e6, 5e5, 0}, 2e-3)), cube({-9, 0, 0}, 2)});
  std::swap(mesh.triangles[0], mesh.triangles.back());
  mesh.triangles.pop_back(); // the small cube's first face: it has three open edges
  const MeshReport r = checkMesh(mesh);
  ASSERT_EQ(r.shells.size(), 3u);
  EXPECT_EQ(r.closedShells, 2u);
  EXPECT_DOUBLE_EQ(r.shells[0].signedVolume, 64);
  EXPECT_EQ(r.shells[0].bounds.min, (Vec3d{-11, -2, -2}));
  EXPECT_EQ(r.shells[1].role, ShellRole::Open);
  EXPECT_EQ(r.shells[1].openEdges, 3u);
  EXPECT_EQ(r.shells[1].triangles, 11u);
  EXPECT_NEAR(r.shells[2].signedVolume, -6.4e-8, 6.4e-8 * 1e-6);
  EXPECT_EQ(r.inwardBodies, 1u);
}

TEST(MeshNesting, RolesFollowTheWindingNumbersAndNotTheOrientationAlone) {
  using enum ShellRole;
  const Mesh outer = cube({0, 0, 0}, 4), inner = cube({0.3, 0, 0}, 2, 0.7), core = cube({0.3, 0.1, 0}, 0.5);
  const auto roles = [](std::initializer_list<Mesh> parts) { return rolesOf(checkMesh(merged(parts))); };
  EXPECT_EQ(roles({inner, outer}), (std::vector{Body, Immersed}));
  EXPECT_EQ(roles({reversed(inner), outer}), (std::vector{Body, Cavity}));
  EXPECT_EQ(roles({reversed(inner), reversed(outer)}), (std::vector{Body, Immersed}));
  EXPECT_EQ(roles({inner, reversed(outer)}), (std::vector{Body, Cavity}));
  EXPECT_EQ(roles({core, reversed(inner), outer}), (std::vector{Body, Cavity, Body}));
  EXPECT_EQ(roles({reversed(core), inner, outer}), (std::vector{Body, Immersed, Immersed})) << "2 - 1 is not 0";
  const MeshReport r = checkMesh(merged({core, reversed(inner), outer}));
  EXPECT_EQ(r.shells[2].depth, 2);
  EXPECT_EQ(r.shells[2].enclosedBy, 1u);
  EXPECT_EQ(r.shells[1].enclosedBy, 0u);
  EXPECT_EQ(r.shells[0].enclosedBy, MeshShell::kNone);
  EXPECT_EQ(r.cavities, 1u);
}

TEST(MeshNesting, BoxesInsideBoxesAreNotEnough) {
  // What stands in the hollow of a body is inside its bounds and not inside it; nor is what overlaps it in part.
  const Mesh hollow = merged({cube({0, 0, 0}, 4), reversed(cube({0, 0, 0}, 3))});
  for (const Mesh& mesh :
       {merged({hollow, cube({0, 0, 0}, 1, 0.3)}), merged({cube({0, 0, 0}, 2), cube({3, 0, 0}, 2)})}) {
    for (const MeshShell& shell : checkMesh(mesh).shells) EXPECT_NE(shell.role, ShellRole::Immersed);
  }
  // A sheet with a face for each side lies inside and encloses nothing.
  Mesh sheet;
  sheet.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 1}};
  const MeshReport r = checkMesh(merged({cube({0, 0, 0}, 4), sheet}));
  EXPECT_EQ(rolesOf(r), (std::vector{ShellRole::Body, ShellRole::Flat}));
  EXPECT_EQ(r.flatShells, 1u);
}

/// A tree of turned cubes, each inside its parent and clear of its siblings, with what is to be found of each.
struct Family {
  struct Member {
    int depth, winding; // of the space around it
    bool inwards;
  };
  Mesh mesh;
  std::vector<Member> members;
  std::mt19937 random{17};

  void add(const Vec3d& centre, double inradius, int depth, int winding) {
    const bool inwards = random() % 2 == 0;
    const Mesh part = cube(centre, inradius, 0.001 * (random() % 3000));
    append(mesh, inwards ? reversed(part) : part);
    members.push_back({depth, winding, inwards});
    if (depth == 4) return;
    for (const double side : {-0.55, 0.55}) // circumradius 0.43 of the parent's inradius
      add({centre[0] + side * inradius, centre[1], centre[2]}, 0.25 * inradius, depth + 1,
          winding + (inwards ? -1 : 1));
  }
};

TEST(MeshNesting, FindsTheDepthOfEveryMemberOfATree) {
  Family family;
  family.add({1, 2, 3}, 64, 0, 0);
  const MeshReport r = checkMesh(family.mesh);
  ASSERT_EQ(r.shellCount, family.members.size());
  ASSERT_EQ(r.shells.size(), family.members.size());
  EXPECT_TRUE(r.nestingComplete);
  std::map<int, int> expected, found;
  std::uint64_t cavities = 0;
  for (const auto& m : family.members) {
    ++expected[m.depth];
    cavities += m.winding != 0 && m.winding + (m.inwards ? -1 : 1) == 0;
  }
  for (const MeshShell& shell : r.shells) {
    ++found[shell.depth];
    if (shell.depth == 0) continue;
    const MeshShell& parent = r.shells.at(shell.enclosedBy);
    EXPECT_EQ(parent.depth, shell.depth - 1);
    EXPECT_NEAR(parent.area / shell.area, 16, 1e-9);
    for (int a = 0; a < 3; ++a) {
      EXPECT_LT(parent.bounds.min[a], shell.bounds.min[a]);
      EXPECT_GT(parent.bounds.max[a], shell.bounds.max[a]);
    }
  }
  EXPECT_EQ(found, expected);
  EXPECT_EQ(r.cavities, cavities);
}

TEST(MeshNesting, TensOfThousandsOfBubblesAreCountedAndTheLargestListed) {
  Mesh mesh = cube({0, 0, 0}, 10);
  std::uint64_t inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const int x = i % 28, y = i / 28 % 28, z = i / 784;
    const Affine place{{{0.3, 0, 0, x * 1.5 - 9.9}, {0, 0.3, 0, y * 0.7 - 9.9}, {0, 0, 0.3, z * 0.7 - 9.9}}};
    append(mesh, reversed(transformed(tetrahedron(), place)));
    inside += x < 14; // the others stand beside the cube
  }
  const MeshReport r = checkMesh(mesh);
  EXPECT_EQ(r.shellCount, 20001u);
  EXPECT_TRUE(r.nestingComplete);
  EXPECT_EQ(r.shells.size(), MeshReport::kListedShells);
  EXPECT_EQ(r.cavities, inside);
  EXPECT_EQ(r.inwardBodies, 20000 - inside);
}

TEST(MeshNesting, TheWorkIsBounded) {
  Mesh mesh;
  for (int i = 0; i < 5000; ++i) append(mesh, cube({0, 0, 0}, 1 + 1e-3 * i));
  const MeshReport r = checkMesh(mesh);
  EXPECT_FALSE(r.nestingComplete);
  ASSERT_EQ(r.shells.size(), MeshReport::kListedShells);
  for (std::size_t i = 0; i < r.shells.size(); ++i) EXPECT_EQ(r.shells[i].depth, static_cast<int>(i));
  EXPECT_NE(shellRemarks(r).back().find("64 of most area"), std::string::npos);
}

TEST(MeshWords, SayHowAMeshIsFilledAndWhy) {
  EXPECT_EQ(describeDefects(checkMesh(tetrahedron())), "");
  EXPECT_TRUE(fillRoute(checkMesh(tetrahedron())).exact);
  EXPECT_EQ(fillRoute(checkMesh(tetrahedron())).reason, "closed and consistently wound");
  EXPECT_TRUE(shellRemarks(checkMesh(tetrahedron())).empty());

  Mesh broken = cube({0, 0, 0}, 1);
  broken.triangles.pop_back();
  std::swap(broken.triangles[0][0], broken.triangles[0][1]);
  broken.triangles.push_back({0, 0, 1});
  EXPECT_FALSE(fillRoute(checkMesh(broken)).exact);
  EXPECT_EQ(fillRoute(checkMesh(broken)).reason,
            "3 open edges, 3 inconsistently wound edges (1 flipped face), 1 degenerate face");
  EXPECT_EQ(describeDefects(checkMesh(moebiusStrip(9))),
            "18 open edges, 1 inconsistently wound edge, 1 one-sided part");

  const Mesh outer = cube({0, 0, 0}, 4), inner = cube({0, 0, 0}, 2);
  const auto remarks = shellRemarks(checkMesh(merged({outer, inner})));
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_NE(remarks[0].find("reverse the inner faces"), std::string::npos);
  EXPECT_NE(remarks[0].find("material group"), std::string::npos);
  EXPECT_NE(shellRemarks(checkMesh(reversed(outer))).at(0).find("1 shell faces inwards"), std::string::npos);
}

TEST(MeshShells, RealMeshesAddUp) {
  VOLCAUSTIC_NEED_SHARED(sharedPath("data/meshes_messy"));
  for (const std::string folder : {"meshes_clean", "meshes_messy", "meshes_quirky"})
    for (const auto& entry : std::filesystem::directory_iterator(sharedPath("data/" + folder))) {
      SCOPED_TRACE(entry.path());
      Mesh mesh;
      try {
        mesh = readMesh(entry.path());
      } catch (const Error&) {
        continue; // mesh_corpus.cpp knows which
      }
      const MeshReport r = checkMesh(mesh);
      EXPECT_GE(r.shellCount, r.components - (r.degenerateFaces > 0 ? r.components : 0));
      if (r.shells.size() < r.shellCount) continue;
      std::uint64_t triangles = 0, openEdges = 0, inconsistent = 0, closed = 0;
      double volume = 0, area = 0;
      for (const MeshShell& shell : r.shells) {
        triangles += shell.triangles;
        openEdges += shell.openEdges;
        inconsistent += shell.inconsistentEdges;
        closed += shell.closed();
        volume += shell.signedVolume;
        area += shell.area;
      }
      EXPECT_LE(triangles, r.triangles);
      EXPECT_GE(triangles + r.degenerateFaces, r.triangles);
      EXPECT_EQ(openEdges, r.openEdges);
      EXPECT_EQ(inconsistent, r.inconsistentEdges);
      EXPECT_EQ(closed, r.closedShells);
      EXPECT_NEAR(area, r.area, 1e-9 * r.area);
      if (closed == r.shellCount) {
        EXPECT_NEAR(volume, r.signedVolume, 1e-6 * std::pow(r.area, 1.5));
      }
      EXPECT_TRUE(r.nestingComplete);
      if (entry.path().filename() == "multibody.stl") {
        EXPECT_EQ(r.flippedFaces, 6u);
      }
    }
}

} // namespace
} // namespace volcaustic::test
