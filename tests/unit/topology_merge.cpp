#include "support/shared_data.h"
#include "topology_support.h"
#include "volcaustic/error.h"

#include <map>

namespace volcaustic {
namespace {

using namespace test;

TEST(TopologyMerge, BallsHaveTheVolumeOfTheirUnion) {
  for (const double distance : {2.5, 1.95, 1.5, 1.0, 0.4}) {
    const Mesh mesh = twoBalls(distance, 32);
    const TopologyResult result = controlled(mesh, {}, Topology::Merge);
    expectSound(result, mesh);
    EXPECT_EQ(result.partsAfter, distance > 2 ? 2u : 1u) << distance;
    // The balls' own facets lack 0.5 % of the volume.
    const double facets = checkMesh(mesh).signedVolume / unionVolume(2);
    EXPECT_NEAR(checkMesh(result.mesh).signedVolume / (facets * unionVolume(distance)), 1, 2e-3) << distance;
  }
}

TEST(TopologyMerge, FarSurfaceStaysCornerByCorner) {
  const Mesh mesh = twoBalls(1.8, 48);
  TopologyOptions options;
  options.blend = 0.1;
  const TopologyResult result = controlled(mesh, options, Topology::Merge);
  expectSound(result, mesh);
  const std::set<Corners> kept = cornersOf(result.mesh, result.keptTriangles);
  std::size_t far = 0;
  for (const Corners& c : cornersOf(mesh, mesh.triangles.size())) {
    if (c[0][0] > 0.3 && c[0][0] < 1.5) continue;
    ++far;
    ASSERT_TRUE(kept.contains(c));
  }
  EXPECT_GT(far, mesh.triangles.size() / 2);
}

TEST(TopologyMerge, BlendJoinsWhatComesNearerThanItsWidth) {
  TopologyOptions options;
  options.blend = 0.2;
  EXPECT_EQ(controlled(twoBalls(2.25, 24), options, Topology::Merge).partsAfter, 2u);
  const Mesh near = twoBalls(2.12, 24);
  const TopologyResult joined = controlled(near, options, Topology::Merge);
  expectSound(joined, near);
  EXPECT_EQ(joined.partsAfter, 1u);
}

/// The angle between neighbouring faces stays small along a blend, and is that of the balls' crease without one.
double sharpestAngle(const Mesh& m) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3d> normals;
  double least = 1;
  for (const auto& t : m.triangles) {
    const auto d = [&](int k) {
      const Vec3d &a = m.positions[t[0]], &b = m.positions[t[k]];
      return Vec3d{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    };
    const Vec3d u = d(1), v = d(2);
    Vec3d n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (length < 1e-5) continue; // slivers have no direction to speak of
    for (double& x : n) x /= length;
    for (int k = 0; k < 3; ++k) {
      const auto edge = std::minmax(t[k], t[(k + 1) % 3]);
      const auto [entry, isNew] = normals.try_emplace(edge, n);
      if (!isNew) least = std::min(least, n[0] * entry->second[0] + n[1] * entry->second[1] + n[2] * entry->second[2]);
    }
  }
  return std::acos(std::clamp(least, -1.0, 1.0)) * 180 / std::numbers::pi;
}

TEST(TopologyMerge, BlendIsSmooth) {
  const Mesh mesh = twoBalls(1.6, 32);
  TopologyOptions options;
  EXPECT_GT(sharpestAngle(controlled(mesh, options, Topology::Merge).mesh), 45);
  options.blend = 0.4;
  EXPECT_LT(sharpestAngle(controlled(mesh, options, Topology::Merge).mesh), 30);
}

TEST(TopologyMerge, DeepBallsDoNotBulge) {
  const Mesh mesh = together(ellipsoid({0, 0, 0}, {1, 1, 1}, 24), ellipsoid({0.02, 0.01, 0}, {0.97, 0.97, 0.97}, 24));
  TopologyOptions options;
  options.blend = 0.3;
  const TopologyResult result = controlled(mesh, options, Topology::Merge);
  expectSound(result, mesh);
  EXPECT_EQ(result.partsAfter, 1u);
  EXPECT_NEAR(checkMesh(result.mesh).signedVolume, checkMesh(ellipsoid({0, 0, 0}, {1, 1, 1}, 24)).signedVolume, 0.02);
}

TEST(TopologyMerge, PartInsideAnotherGoes) {
  const Mesh outer = ellipsoid({0, 0, 0}, {1, 1, 1}, 16);
  const TopologyResult result =
      controlled(together(outer, ellipsoid({0.1, 0, 0}, {0.3, 0.3, 0.3}, 16)), {}, Topology::Merge);
  EXPECT_EQ(result.partsAfter, 1u);
  EXPECT_EQ(cornersOf(result.mesh, result.mesh.triangles.size()), cornersOf(outer, outer.triangles.size()));
}

TEST(TopologyMerge, SurfaceThatRunsThroughItselfIsHealed) {
  // An eight whose strands overlap where they cross.
  const Mesh mesh = tube(
      160, 24,
      [](double u) {
        return Vec3d{std::sin(u), std::sin(u) * std::cos(u), 0.1 * std::cos(u)};
      },
      [](double) { return 0.16; });
  const TopologyResult result = controlled(mesh, {}, Topology::Merge);
  expectSound(result, mesh);
  EXPECT_GT(result.newTriangles, 0u);
  EXPECT_GT(result.keptTriangles, mesh.triangles.size() / 3);
  EXPECT_EQ(result.partsAfter, 1u);
  // Each strand's overlap was counted twice, and is in the union once; genus 2: a hole on either side.
  const double before = checkMesh(mesh).signedVolume, after = checkMesh(result.mesh).signedVolume;
  EXPECT_LT(after, 0.995 * before);
  EXPECT_GT(after, 0.9 * before);
  const auto vertices = static_cast<std::int64_t>(result.mesh.positions.size());
  EXPECT_EQ(vertices - static_cast<std::int64_t>(result.mesh.triangles.size()) / 2, 2 - 2 * 2);
}

TEST(TopologyMerge, LargeTrianglesAreDividedWhereTheyAreCut) {
  Mesh cube;
  for (int i = 0; i < 8; ++i) cube.positions.push_back({i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0});
  cube.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const Mesh mesh = together(cube, ellipsoid({0.3, 0.2, 1}, {0.5, 0.5, 0.5}, 24));
  TopologyOptions options;
  options.voxelSize = 0.06;
  const TopologyResult result = controlled(mesh, options, Topology::Merge);
  expectSound(result, mesh);
  EXPECT_EQ(result.partsAfter, 1u);
  EXPECT_NEAR(checkMesh(result.mesh).signedVolume, 8 + 2 * std::numbers::pi / 3 * 0.125, 0.01);
}

TEST(TopologyMerge, ShrinkingDistanceDoesNotPop) {
  TopologyOptions options;
  options.voxelSize = 0.06;
  double last = 0;
  for (int step = 0; step < 24; ++step) {
    const double distance = 2.2 - 0.03 * step;
    const Mesh mesh = twoBalls(distance, 20);
    const TopologyResult result = controlled(mesh, options, Topology::Merge);
    const MeshReport report = checkMesh(result.mesh);
    EXPECT_TRUE(report.closedAndConsistent()) << distance << ": " << describeDefects(report);
    EXPECT_EQ(report.nonManifoldEdges, 0u) << distance;
    if (step > 0) {
      const double expected = unionVolume(distance) - unionVolume(distance + 0.03);
      EXPECT_NEAR(report.signedVolume - last, expected, 0.008) << distance;
    }
    last = report.signedVolume;
  }
}

TEST(TopologyMerge, SameBitsWhateverTheThreads) {
  TopologyOptions options;
  options.blend = 0.1;
  const Mesh mesh = twoBalls(1.7, 20);
  const TopologyResult one = controlled(mesh, options, Topology::Merge, 1);
  const TopologyResult many = controlled(mesh, options, Topology::Merge, 5);
  EXPECT_EQ(one.mesh.positions, many.mesh.positions);
  EXPECT_EQ(one.mesh.triangles, many.mesh.triangles);
}

TEST(TopologyMerge, GroupsGoWithTheSurface) {
  Mesh mesh = twoBalls(1.7, 20);
  mesh.groupNames = {"left", "right"};
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    mesh.triangleGroup.push_back(i < mesh.triangles.size() / 2 ? 0 : 1);
  const Mesh merged = controlled(mesh, {}, Topology::Merge).mesh;
  ASSERT_EQ(merged.triangleGroup.size(), merged.triangles.size());
  EXPECT_EQ(merged.groupNames, mesh.groupNames);
  for (std::size_t i = 0; i < merged.triangles.size(); ++i) {
    const double x = merged.positions[merged.triangles[i][0]][0];
    if (std::abs(x - 0.8631) > 0.2) {
      EXPECT_EQ(merged.triangleGroup[i], x < 0.8631 ? 0u : 1u);
    }
  }
}

TEST(TopologyMerge, BunnyWithABallKeepsItsEars) {
  const auto path = sharedPath("data/meshes_clean/bunny_hr_59k.obj");
  VOLCAUSTIC_NEED_SHARED(path);
  const Mesh bunny = readMesh(path);
  const Mesh mesh = together(bunny, ellipsoid({0.5, -0.3, 0.2}, {0.2, 0.2, 0.2}, 32));
  const TopologyResult result = controlled(mesh, {}, Topology::Merge);
  expectSound(result, mesh);
  EXPECT_EQ(result.partsAfter, 1u);
  EXPECT_GT(static_cast<double>(result.keptTriangles), 0.9 * static_cast<double>(bunny.triangles.size()));
}

TEST(TopologyMerge, NothingToDoGivesTheMeshBack) {
  const Mesh mesh = twoBalls(2.5, 12);
  for (const Topology topology : {Topology::Free, Topology::Keep, Topology::Merge, Topology::Split}) {
    const TopologyResult result = controlled(mesh, {}, topology);
    EXPECT_EQ(result.mesh.positions, mesh.positions);
    EXPECT_EQ(result.mesh.triangles, mesh.triangles);
    EXPECT_EQ(result.keptTriangles, mesh.triangles.size());
    EXPECT_EQ(result.partsAfter, 2u);
  }
}

ErrorKind kindOf(const Mesh& mesh, const TopologyOptions& options) {
  try {
    controlled(mesh, options, Topology::Merge);
  } catch (const Error& e) {
    return e.kind();
  }
  return ErrorKind::Internal;
}

TEST(TopologyMerge, WhatCannotBeDoneIsSaid) {
  const Mesh mesh = twoBalls(1.7, 12);
  Mesh open = mesh, inward = mesh;
  open.triangles.pop_back();
  for (auto& t : inward.triangles) std::swap(t[0], t[1]);
  TopologyOptions options;
  EXPECT_EQ(kindOf(open, options), ErrorKind::Input);
  EXPECT_EQ(kindOf(inward, options), ErrorKind::Input);
  options.voxelSize = 1e-12;
  EXPECT_EQ(kindOf(mesh, options), ErrorKind::Input);
  options.voxelSize = 1e-6;
  EXPECT_EQ(kindOf(mesh, options), ErrorKind::Input);
  options.voxelSize = -1;
  EXPECT_EQ(kindOf(mesh, options), ErrorKind::Usage);
}

} // namespace
} // namespace volcaustic
