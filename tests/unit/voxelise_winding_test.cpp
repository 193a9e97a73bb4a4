// The winding-number route, against the definition summed triangle by triangle.
#include "unit/voxelise_support.h"
#include "volcaustic/error.h"
#include "volume/cap_offsets.h"

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
  EXPECT_LE(wrongVoxels(soup), 6); // a few samples lie within 1e-3 of one half
}

/// Samples of a domain at 4 sub-voxels that are on the wrong side, of `count` at random; the definition is known to a
/// thousandth.
std::int64_t wrongSamples(const Mesh& mesh, const Domain& domain, int count) {
  const auto c = dense(voxelise(mesh, domain, 4, FillRule::Winding), domain);
  SubLattice lattice;
  lattice.log2 = 2;
  std::mt19937 random(9);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  std::int64_t wrong = 0;
  for (int v = 0; v < count; ++v) {
    const Vec3i at{below(domain.dims[0]), below(domain.dims[1]), below(domain.dims[2])};
    const float coverage = c[(std::size_t(at[0]) * domain.dims[1] + at[1]) * domain.dims[2] + at[2]];
    Vec3d p = lattice.sample(4 * at[0] + below(4), 4 * at[1] + below(4), 4 * at[2] + below(4));
    for (double& x : p) x /= 4;
    const double w = std::abs(windingNumber(mesh, p));
    if (coverage == 0) wrong += w >= 0.5 + 1e-3;
    if (coverage == 1) wrong += w < 0.5 - 1e-3;
  }
  return wrong;
}

TEST(VoxeliseWinding, TrianglesThroughTheWholeDomainMatchTheDefinition) {
  // No brick is far from every side, few are on one side of all faces.
  std::mt19937 random(11);
  std::uniform_real_distribution<double> position(4, 60);
  Mesh soup;
  for (std::uint32_t t = 0; t < 40; ++t) {
    for (int i = 0; i < 3; ++i) soup.positions.push_back({position(random), position(random), position(random)});
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  EXPECT_LE(wrongSamples(soup, cubeDomain(64), 20000), 4);
}

TEST(VoxeliseWinding, FacesThatComeDozensOfTimesMatchTheDefinition) {
  // Winding numbers change by several between neighbouring bricks, and jump by 17 at the faces.
  Mesh many = translated(rotated(box({-17, -15, -13}, {16, 18, 14}), 0.3, 0.2), {32, 32, 32});
  const auto faces = many.triangles;
  for (int times = 1; times < 17; ++times)
    many.triangles.insert(many.triangles.end(), faces.begin(), faces.begin() + 8);
  EXPECT_LE(wrongSamples(many, cubeDomain(64), 20000), 4);
}

/// A height field over [margin, n - margin]^2 of voxels, its rim far from flat.
Mesh openHeightField(int n, double margin, int cells) {
  Mesh field;
  const auto at = [cells](int i, int j) { return static_cast<std::uint32_t>(i * (cells + 1) + j); };
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j) {
      const double x = margin + (n - 2 * margin) * i / cells, y = margin + (n - 2 * margin) * j / cells;
      field.positions.push_back({x, y, n * (0.5 + 0.2 * std::sin(5 * x / n) * std::cos(4 * y / n))});
      if (i < cells && j < cells)
        field.triangles.insert(field.triangles.end(), {{at(i, j), at(i + 1, j), at(i + 1, j + 1)},
                                                       {at(i, j), at(i + 1, j + 1), at(i, j + 1)}});
    }
  return field;
}

TEST(VoxeliseWinding, HugeHolesMatchTheDefinition) {
  // Whole bricks lie far from the rim here, and their winding numbers come from few points.
  const Domain domain = cubeDomain(64);
  const Mesh field = openHeightField(64, 3.3, 12);
  for (const int supersample : {1, 2, 4, 8}) {
    const auto c = dense(voxelise(field, domain, supersample, FillRule::Winding), domain);
    SubLattice lattice;
    while (1 << lattice.log2 < supersample) ++lattice.log2;
    std::mt19937 random(9);
    std::int64_t wrong = 0, inside = 0;
    constexpr int kVoxels = 1500;
    for (int v = 0; v < kVoxels; ++v) {
      const Vec3i at{int(random() % 64), int(random() % 64), int(18 + random() % 28)};
      const int i = at[0] * supersample + int(random() % unsigned(supersample));
      const int j = at[1] * supersample + int(random() % unsigned(supersample));
      const int k = at[2] * supersample + int(random() % unsigned(supersample));
      Vec3d p = lattice.sample(i, j, k);
      for (double& x : p) x /= supersample;
      const bool expected = std::abs(windingNumber(field, p)) >= 0.5;
      const float coverage = c[(at[0] * 64 + at[1]) * 64 + at[2]];
      wrong += expected ? coverage == 0 : coverage == 1;
      inside += expected;
    }
    EXPECT_LE(wrong, 1) << supersample;
    EXPECT_GT(inside, kVoxels / 50);
  }
}

TEST(VoxeliseWinding, AFlatSheetEnclosesNothing) {
  // Winding numbers come as near to one half as one likes without reaching it.
  Mesh sheet = box({2.2, 3.1, 8.03}, {13.7, 14.2, 8.03});
  sheet.triangles.resize(2);
  for (const double tilt : {0.0, 0.2}) {
    const Mesh tilted = translated(rotated(sheet, 0, tilt), {0, 0.8 * tilt, -7 * tilt});
    EXPECT_EQ(volume(voxelise(tilted, kDomain, 4, FillRule::Winding), kDomain), 0) << tilt;
  }
}

TEST(VoxeliseWinding, FacesThatComeManyTimesCountManyTimes) {
  Mesh many;
  for (int i = 0; i < 4; ++i) many = joined(many, ballWithHole(30));
  EXPECT_LE(wrongVoxels(many), 4);
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

TEST(BoundaryChain, OneFaceOfManyIsFound) {
  Mesh ball = icosphere({0, 0, 0}, 1, 3); // 1280 faces
  ASSERT_TRUE(boundaryChain(ball).empty());
  for (const std::size_t face : {0, 255, 256, 777, 1279}) {
    Mesh turned = ball, open = ball;
    std::swap(turned.triangles[face][0], turned.triangles[face][1]);
    EXPECT_EQ(boundaryChain(turned).size(), 6u) << face;
    open.triangles.erase(open.triangles.begin() + static_cast<std::ptrdiff_t>(face));
    EXPECT_EQ(boundaryChain(open).size(), 3u) << face;
  }
  ball.triangles.push_back({5, 5, 9}); // its edges cancel each other
  EXPECT_TRUE(boundaryChain(ball).empty());
}

TEST(CapOffsets, OfSamplesIsTheRoundedSum) {
  const Mesh field = openHeightField(48, 2.7, 10);
  const LoopCaps caps = capLoops(field, boundaryChain(field));
  Mesh capMesh;
  capMesh.positions = caps.positions;
  capMesh.triangles = caps.triangles;
  SubLattice lattice;
  lattice.log2 = 2;
  lattice.scale = 4;
  lattice.size = {192, 192, 192};
  const CapOffsets offsets(caps, lattice, {});
  std::vector<std::int16_t> ofBrick;
  std::int64_t checked = 0, wrong = 0;
  for (int b = 0; b < 216; ++b) {
    const Vec3i brick{b / 36, b / 6 % 6, b % 6};
    offsets.ofSamples(brick, ofBrick);
    const std::int16_t constant = offsets.ofBrick(b);
    for (std::size_t i = 37; i < ofBrick.size(); i += 1009) {
      if (constant != CapOffsets::kVaries) {
        ASSERT_EQ(ofBrick[i], constant);
      }
      const auto at = static_cast<int>(i);
      Vec3d p = lattice.sample(32 * brick[0] + at / 1024, 32 * brick[1] + at / 32 % 32, 32 * brick[2] + at % 32);
      for (double& x : p) x /= 4;
      const double w = windingNumber(capMesh, p);
      ++checked;
      wrong += std::abs(w + ofBrick[i]) > 0.5 + 1e-3;
    }
  }
  EXPECT_GT(checked, 6000);
  EXPECT_EQ(wrong, 0);
}

TEST(CubeInterpolation, MeetsSmoothFunctionsAtTheSamples) {
  const Vec3d pole{-30, 11, 9}; // 3.3 half edges from the centre
  const auto potential = [&](const Vec3d& p) { return 1 / std::hypot(p[0] - pole[0], p[1] - pole[1], p[2] - pole[2]); };
  SubLattice lattice;
  lattice.log2 = 2;
  for (const bool octant : {false, true}) {
    const CubeInterpolation whole(16, 2), cube(octant ? 8 : 16, 2);
    CubeInterpolation::Values values;
    for (int i = 0; i < 125; ++i) values[i] = potential({whole.node(i / 25), whole.node(i / 5 % 5), whole.node(i % 5)});
    if (octant) values = CubeInterpolation::atOctant(values, 3); // +y, +z
    std::vector<double> samples;
    cube.atSamples(values, samples);
    const int n = cube.size();
    for (int i = 0; i < n * n * n; ++i) {
      Vec3d p = lattice.sample(i / n / n, i / n % n, i % n);
      if (octant) p = {p[0], p[1] + 8, p[2] + 8};
      ASSERT_NEAR(samples[i] / potential(p), 1, 2e-3) << i;
    }
  }
}

TEST(CubeInterpolation, RangesHoldAtEverySample) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> unit(-1, 1);
  const CubeInterpolation cube(16, 2);
  std::vector<double> samples;
  for (int i = 0; i < 40; ++i) {
    CubeInterpolation::Values values;
    const double slope = unit(random), noise = i % 4 == 0 ? 0.3 : 1e-3;
    for (int v = 0; v < 125; ++v) values[v] = slope * cube.node(v % 5) + noise * unit(random);
    const auto [middle, change] = CubeInterpolation::range(values);
    cube.atSamples(values, samples);
    const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
    EXPECT_GE(*low, middle - change - 1e-12);
    EXPECT_LE(*high, middle + change + 1e-12);
    if (noise < 0.01) {
      EXPECT_LT(change, 8 * std::abs(slope) + 0.2); // nearly linear: half its range and little more
    }
  }
}

TEST(CubeInterpolation, FarFunctionsNeedFewPoints) {
  const CubeInterpolation cube(32, 2);
  const Vec3d pole{16 + 10.2 * 16, 20, 9};
  const auto potential = [&](const Vec3d& p) { return 1 / std::hypot(p[0] - pole[0], p[1] - pole[1], p[2] - pole[2]); };
  PointSums sums = cube.farNodes();
  for (int i = 0; i < sums.size(); ++i) {
    auto& block = sums.blocks()[i / PointSums::kLanes];
    const int lane = i % PointSums::kLanes;
    block.sum[lane] = potential({block.x[lane], block.y[lane], block.z[lane]});
  }
  const auto values = CubeInterpolation::fromFarNodes(sums);
  for (int i = 0; i < 125; ++i)
    ASSERT_NEAR(values[i] / potential({cube.node(i / 25), cube.node(i / 5 % 5), cube.node(i % 5)}), 1, 1e-3) << i;
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
    ASSERT_NEAR(fast.at(p), windingNumber(mesh, p), 1e-3);
    // What is guaranteed of a ball holds inside it.
    const double radius = 0.3 * (1 + i % 5);
    if (const auto whole = fast.wholeWithin(p, radius)) {
      const Vec3d q{p[0] + 0.57 * radius, p[1] - 0.57 * radius, p[2] + 0.57 * radius};
      ASSERT_LT(std::abs(windingNumber(mesh, q) - *whole), 0.5 + 2e-3);
    }
  }
}

} // namespace
} // namespace volcaustic::test
