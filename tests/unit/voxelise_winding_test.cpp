// The winding-number route, against the definition summed triangle by triangle.
#include "unit/voxelise_support.h"
#include "volcaustic/error.h"
#include "volume/cap_winding.h"

#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {
namespace {

const Domain kDomain = cubeDomain(16);
constexpr int kSupersample = 2;

/// Voxels that differ from |w| >= 1/2 at every sample.
std::int64_t wrongVoxels(const Mesh& mesh) {
  const auto expected =
      sampledCoverage(kDomain, kSupersample, [&](const Vec3d& p) { return std::abs(windingNumber(mesh, p)) >= 0.5; });
  return differing(dense(voxelise(mesh, kDomain, kSupersample, FillRule::Winding), kDomain), expected);
}

Mesh ballWithHole(int removed) {
  Mesh ball = icosphere({8.1, 7.9, 8.2}, 6.3, 2);
  ball.triangles.erase(ball.triangles.begin(), ball.triangles.begin() + removed);
  return ball;
}

TEST(VoxeliseWinding, ClosedMeshesAreTheExactRouteToTheBit) {
  const Mesh ball = icosphere({8.1, 7.9, 8.2}, 6.3, 3);
  EXPECT_EQ(differing(dense(voxelise(ball, kDomain, 4, FillRule::Winding), kDomain),
                      dense(voxelise(ball, kDomain, 4, FillRule::Exact), kDomain)),
            0);
}

TEST(VoxeliseWinding, OpenBallsMatchTheDefinition) {
  for (const int removed : {1, 5, 40, 160}) EXPECT_LE(wrongVoxels(ballWithHole(removed)), 2) << removed;
}

TEST(VoxeliseWinding, DamagedMeshesMatchTheDefinition) {
  Mesh flipped = icosphere({8.1, 7.9, 8.2}, 6.3, 2);
  for (std::size_t t = 0; t < flipped.triangles.size(); t += 7)
    std::swap(flipped.triangles[t][0], flipped.triangles[t][1]);
  EXPECT_LE(wrongVoxels(flipped), 2);

  Mesh doubled = ballWithHole(30);
  doubled.triangles.insert(doubled.triangles.end(), doubled.triangles.begin(), doubled.triangles.begin() + 50);
  EXPECT_LE(wrongVoxels(doubled), 2);

  const Mesh shells = joined(ballWithHole(60), translated(ballWithHole(100), {1.2, 0.3, -0.4}));
  EXPECT_LE(wrongVoxels(shells), 2);
}

TEST(VoxeliseWinding, TriangleSoupMatchesTheDefinition) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> position(1, 15);
  Mesh soup;
  for (std::uint32_t t = 0; t < 60; ++t) {
    for (int i = 0; i < 3; ++i) soup.positions.push_back({position(random), position(random), position(random)});
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  EXPECT_LE(wrongVoxels(soup), 4); // dipoles: a few samples lie within 1e-3 of one half
}

TEST(VoxeliseWinding, AnInsideReachesBeyondTheMeshWhereTheDefinitionSaysSo) {
  Mesh dishes; // eight sheets on each other: the winding number is near 4 just above and below them
  for (int i = 0; i < 8; ++i) {
    Mesh sheet = box({5, 5, 8 + 0.01 * i}, {11, 11, 8 + 0.01 * i});
    sheet.triangles.resize(2);
    dishes = joined(dishes, sheet);
  }
  const auto c = dense(voxelise(dishes, kDomain, kSupersample, FillRule::Winding), kDomain);
  EXPECT_EQ(c[(8 * 16 + 8) * 16 + 9], 1.0f);
  EXPECT_LE(wrongVoxels(dishes), 2);
}

TEST(VoxeliseWinding, AHoleIsClosedSensibly) {
  const Domain domain = cubeDomain(64);
  Mesh ball = icosphere({32, 32, 32}, 25, 4);
  const double whole = signedVolume(ball);
  std::erase_if(ball.triangles, [&](const auto& t) { return ball.positions[t[0]][2] > 53; });
  const CoveragePatch patch = voxelise(ball, domain, 4, FillRule::Winding);
  const double cap = std::numbers::pi * 16.0 * (25 - 4.0 / 3); // of height 4
  EXPECT_NEAR(volume(patch, domain), whole - cap, 0.01 * whole);
  EXPECT_EQ(dense(patch, domain)[(32 * 64 + 32) * 64 + 60], 0.0f);
}

TEST(VoxeliseWinding, AutoWarnsOnceAndSaysWhy) {
  std::vector<std::string> lines;
  RunContext ctx;
  ctx.onLog = [&](LogLevel level, std::string_view line) {
    EXPECT_EQ(level, LogLevel::Warning);
    lines.emplace_back(line);
  };
  voxelise(icosphere({8, 8, 8}, 6, 2), kDomain, 2, FillRule::Auto, ctx);
  EXPECT_TRUE(lines.empty());
  voxelise(ballWithHole(1), kDomain, 2, FillRule::Auto, ctx);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("body: "), std::string::npos);
  EXPECT_NE(lines[0].find("3 open"), std::string::npos);
  EXPECT_EQ(lines[0].find('\n'), std::string::npos);
}

TEST(VoxeliseWinding, ABodyThatEnclosesNothingIsSaidToBeEmpty) {
  std::vector<std::string> lines;
  RunContext ctx;
  ctx.onLog = [&](LogLevel, std::string_view line) { lines.emplace_back(line); };
  const Mesh shell = ballWithHole(0);
  EXPECT_EQ(volume(voxelise(joined(shell, reversed(shell)), kDomain, 2, FillRule::Auto, ctx), kDomain), 0);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("faces cancel"), std::string::npos);
}

TEST(VoxeliseWinding, ThreadsDoNotChangeABit) {
  RunContext one, two;
  one.threads = 1;
  two.threads = 2;
  EXPECT_EQ(differing(dense(voxelise(ballWithHole(40), kDomain, 4, FillRule::Winding, one), kDomain),
                      dense(voxelise(ballWithHole(40), kDomain, 4, FillRule::Winding, two), kDomain)),
            0);
}

TEST(BoundaryChain, CountsWhatDoesNotCancel) {
  Mesh cube = box({0, 0, 0}, {1, 1, 1});
  EXPECT_TRUE(boundaryChain(cube).empty());
  Mesh unshared; // the same corners, nothing shared by index
  for (const auto& t : cube.triangles) {
    const auto first = static_cast<std::uint32_t>(unshared.positions.size());
    for (const std::uint32_t v : t) unshared.positions.push_back(cube.positions[v]);
    unshared.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_TRUE(boundaryChain(unshared).empty());
  std::swap(cube.triangles[4][0], cube.triangles[4][1]); // both faces of each of its edges now run the same way
  EXPECT_EQ(boundaryChain(cube).size(), 6u);
  cube.triangles.erase(cube.triangles.begin() + 4);
  EXPECT_EQ(boundaryChain(cube).size(), 3u);
}

TEST(BoundaryChain, CapsCloseEveryMesh) {
  Mesh pinched = joined(ballWithHole(1), ballWithHole(100)); // equal positions: loops that touch
  for (std::size_t t = 0; t < pinched.triangles.size(); t += 11)
    std::swap(pinched.triangles[t][1], pinched.triangles[t][2]);
  const auto chain = boundaryChain(pinched);
  ASSERT_FALSE(chain.empty());
  const LoopCaps caps = capLoops(pinched, chain);
  EXPECT_EQ(caps.edges.size(), chain.size());
  Mesh asMesh;
  asMesh.positions = caps.positions;
  asMesh.triangles = caps.triangles;
  EXPECT_TRUE(boundaryChain(joined(pinched, asMesh)).empty());
}

TEST(CapWinding, TheHierarchyAgreesWithTheSum) {
  const Mesh mesh = ballWithHole(200);
  std::vector<std::array<Vec3d, 3>> triangles;
  for (const auto& t : mesh.triangles)
    triangles.push_back({mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
  std::vector<std::array<Vec3d, 2>> edges;
  for (const BoundaryEdge& e : boundaryChain(mesh)) edges.push_back({mesh.positions[e.from], mesh.positions[e.to]});
  const CapWinding fast(triangles, edges);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> position(-10, 26);
  for (int i = 0; i < 2000; ++i) {
    const Vec3d p{position(random), position(random), position(random)};
    ASSERT_NEAR(fast.at(p), windingNumber(mesh, p), 2e-3);
    // What is guaranteed of a ball holds inside it.
    const double radius = 0.3 * (1 + i % 5);
    if (const auto whole = fast.nearestWhole(p, radius)) {
      const Vec3d q{p[0] + 0.57 * radius, p[1] - 0.57 * radius, p[2] + 0.57 * radius};
      ASSERT_LT(std::abs(windingNumber(mesh, q) - *whole), 0.5 + 2e-3);
    }
  }
}

} // namespace
} // namespace volcaustic::test
