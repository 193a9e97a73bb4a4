// The exact route: signed crossings along rows of sub-voxels.
#include "unit/voxelise_support.h"
#include "volcaustic/error.h"
#include "volume/column_bins.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <random>

namespace volcaustic::test {
namespace {

/// Where the voxeliser takes a sample to be: an edge or a face on it is decided as if it lay a little further.
Vec3d nudged(const Vec3d& p) { return {p[0] + 0x1p-24, p[1] + 0x1p-32, p[2] + 0x1p-18}; }

double relativeVolumeError(const Mesh& mesh, int resolution) {
  const Domain domain = domainAround(bounds(mesh), resolution, 0, 2);
  return volume(voxelise(mesh, domain, 4, FillRule::Exact), domain) / signedVolume(mesh) - 1;
}

TEST(VoxeliseExact, VolumeIsTheMeshVolume) {
  EXPECT_NEAR(relativeVolumeError(icosphere({0.1, 0.2, 0.3}, 1.7, 5), 256), 0, 1e-4);
  EXPECT_NEAR(relativeVolumeError(torus(1, 0.3, 300, 160), 256), 0, 3e-4);
  EXPECT_NEAR(relativeVolumeError(rotated(torus(1, 0.02, 300, 40), 0.4, 1.1), 256), 0, 2e-3);
  EXPECT_NEAR(relativeVolumeError(rotated(box({-1, -1, -1}, {1, 1, 1}), 0.3, 0.8), 256), 0, 3e-4);
}

TEST(VoxeliseExact, InsideOutIsInsideToo) {
  const Domain domain = cubeDomain(32);
  const Mesh ball = icosphere({16, 16, 16}, 11, 3);
  EXPECT_EQ(differing(dense(voxelise(ball, domain), domain), dense(voxelise(reversed(ball), domain), domain)), 0);
}

TEST(VoxeliseExact, FacesOnVoxelFacesGiveWholeVoxels) {
  const Domain domain = cubeDomain(24, 0.1, {1, 2, 3});
  const Mesh cube = box({1.5, 2.3, 3.4}, {2.1, 4.0, 5.2}); // voxels 5..10, 3..19, 4..21
  for (const int s : {1, 2, 4, 8}) {
    const std::vector<float> c = dense(voxelise(cube, domain, s), domain);
    for (std::size_t i = 0; i < c.size(); ++i) {
      const int x = int(i / 576), y = int(i / 24 % 24), z = int(i % 24);
      const bool inside = x >= 5 && x < 11 && y >= 3 && y < 20 && z >= 4 && z < 22;
      ASSERT_EQ(c[i], inside ? 1.0f : 0.0f) << x << ' ' << y << ' ' << z << " at " << s;
    }
  }
}

TEST(VoxeliseExact, FacesOnSamplesCountEachSampleOnce) {
  const Domain domain = cubeDomain(16);
  // Faces at x, y = 1/8 and z = 1/32 of a sub-voxel meet samples of every fourth and every sixteenth row, on both sides
  // of the box: one of the two owns them.
  const Vec3d low{10.125 / 4, 10.125 / 4, (10 + 1.0 / 32) / 4}, high{37.125 / 4, 37.125 / 4, (37 + 1.0 / 32) / 4};
  const CoveragePatch patch = voxelise(box(low, high), domain, 4);
  EXPECT_DOUBLE_EQ(volume(patch, domain) * 64, 27.0 * 27 * 27);
  // Two boxes that share such a face fill their union without a seam or a double layer.
  const double middle = (20 + 1.0 / 32) / 4;
  const auto a = dense(voxelise(box(low, {high[0], high[1], middle}), domain, 4), domain);
  const auto b = dense(voxelise(box({low[0], low[1], middle}, high), domain, 4), domain);
  const auto whole = dense(patch, domain);
  for (std::size_t i = 0; i < whole.size(); ++i) ASSERT_EQ(a[i] + b[i], whole[i]);
}

TEST(VoxeliseExact, VerticesAndEdgesOnSamplesNeitherLeakNorDouble) {
  // Every vertex is a sample: rows run through vertices everywhere.
  const Domain domain = cubeDomain(16);
  SubLattice lattice;
  lattice.log2 = 1;
  for (const double radius : {3.1, 5.3, 7.2}) {
    Mesh ball = icosphere({8, 8, 8}, radius, 2);
    for (Vec3d& p : ball.positions) {
      p = lattice.sample(int(2 * p[0]), int(2 * p[1]), int(2 * p[2]));
      for (double& c : p) c /= 2;
    }
    const auto expected =
        sampledCoverage(domain, 2, [&](const Vec3d& p) { return std::abs(windingNumber(ball, nudged(p))) >= 0.5; });
    EXPECT_EQ(differing(dense(voxelise(ball, domain, 2, FillRule::Exact), domain), expected), 0) << radius;
  }
}

TEST(VoxeliseExact, RotatedBoxesMatchTheirHalfSpaces) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(0, 6.28);
  const Domain domain = cubeDomain(24);
  for (int i = 0; i < 8; ++i) {
    const double z = angle(random), x = angle(random);
    const Mesh cube = translated(rotated(box({-6, -4, -5}, {6, 4, 5}), z, x), {12, 12, 12});
    const auto inside = [&](const Vec3d& p) { // the inverse rotation, then the box
      const Vec3d q{p[0] - 12, p[1] - 12, p[2] - 12};
      const double y1 = std::cos(x) * q[1] + std::sin(x) * q[2], z1 = -std::sin(x) * q[1] + std::cos(x) * q[2];
      const double x2 = std::cos(z) * q[0] + std::sin(z) * y1, y2 = -std::sin(z) * q[0] + std::cos(z) * y1;
      return std::abs(x2) < 6 && std::abs(y2) < 4 && std::abs(z1) < 5;
    };
    // Snapping moves a face by less than 2^-16 sub-voxel; a sample that near to one is possible, and rare.
    EXPECT_LE(differing(dense(voxelise(cube, domain), domain), sampledCoverage(domain, 4, inside)), 1);
  }
}

TEST(VoxeliseExact, ReversedInnerShellMakesAHollowBody) {
  const Domain domain = cubeDomain(40);
  const Vec3d centre{20, 20, 20};
  const Mesh outer = icosphere(centre, 17, 4), inner = icosphere(centre, 11, 4);
  const CoveragePatch hollow = voxelise(joined(outer, reversed(inner)), domain);
  EXPECT_EQ(dense(hollow, domain)[(20 * 40 + 20) * 40 + 20], 0.0f);
  EXPECT_NEAR(volume(hollow, domain), signedVolume(outer) - signedVolume(inner), 15); // a thousandth
  // An inner shell that faces outwards too is more of the same body.
  const CoveragePatch solid = voxelise(joined(outer, inner), domain);
  EXPECT_EQ(differing(dense(solid, domain), dense(voxelise(outer, domain), domain)), 0);
}

TEST(VoxeliseExact, SurvivesDegenerateAndDuplicateFaces) {
  const Domain domain = cubeDomain(24);
  Mesh ball = icosphere({12, 12, 12}, 8, 2);
  const auto expected = dense(voxelise(ball, domain), domain);
  ball.triangles.push_back({3, 3, 3});
  ball.triangles.push_back({1, 2, 2});
  ball.positions.push_back(ball.positions[0]); // a zero-area pair that closes itself
  const auto last = static_cast<std::uint32_t>(ball.positions.size() - 1);
  ball.triangles.insert(ball.triangles.end(), {{0, 5, last}, {last, 5, 0}});
  EXPECT_EQ(differing(dense(voxelise(ball, domain, 4, FillRule::Exact), domain), expected), 0);
}

TEST(VoxeliseExact, FarFromTheOriginTheBitsAreTheSame) {
  Mesh ball = icosphere({0, 0, 0}, 1.3, 3);
  for (Vec3d& p : ball.positions) // coordinates that stay exact when 2^21 is added
    for (double& c : p) c = std::round(c * 0x1p24) * 0x1p-24;
  const Domain near = cubeDomain(24, 0.125, {-1.5, -1.5, -1.5});
  const Vec3d offset{0x1p21, -0x1p20, 0x1p19};
  const Domain far = cubeDomain(24, 0.125, {offset[0] - 1.5, offset[1] - 1.5, offset[2] - 1.5});
  EXPECT_EQ(differing(dense(voxelise(ball, near), near), dense(voxelise(translated(ball, offset), far), far)), 0);
}

TEST(VoxeliseExact, SuperSamplingConverges) {
  const Domain domain = cubeDomain(20);
  const Mesh ball = icosphere({10.1, 9.8, 10.3}, 7.4, 4);
  const auto finest = dense(voxelise(ball, domain, 8), domain);
  double last = 1e9;
  for (const int s : {1, 2, 4}) {
    const auto c = dense(voxelise(ball, domain, s), domain);
    double squares = 0;
    for (std::size_t i = 0; i < c.size(); ++i) squares += (c[i] - finest[i]) * (c[i] - finest[i]);
    EXPECT_LT(squares, 0.5 * last) << s;
    last = squares;
  }
}

TEST(VoxeliseExact, AThinWallKeepsItsFraction) {
  const Domain domain = cubeDomain(16);
  const auto c = dense(voxelise(box({2, 2, 7.3}, {14, 14, 7.55}), domain, 4), domain);
  EXPECT_EQ(c[(8 * 16 + 8) * 16 + 7], 0.25f);
  EXPECT_EQ(c[(8 * 16 + 8) * 16 + 6], 0.0f);
}

TEST(VoxeliseExact, ThinWallsKeepTheirMeanFraction) {
  const Domain domain = cubeDomain(16);
  for (const double thickness : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    const Mesh wall = rotated(box({-6, -6, -0.5 * thickness}, {6, 6, 0.5 * thickness}), 0.2, 0.15);
    // A voxel's samples lie at 64 heights.
    EXPECT_NEAR(volume(voxelise(translated(wall, {8, 8, 8.07}), domain), domain) / 144, thickness, 1.0 / 64)
        << thickness;
  }
}

TEST(VoxeliseExact, DuplicatedAndOverlappingFacesChangeNothing) {
  const Domain domain = cubeDomain(24);
  const Mesh ball = icosphere({12, 12, 12}, 8, 3);
  EXPECT_EQ(differing(dense(voxelise(joined(ball, ball), domain, 4, FillRule::Exact), domain),
                      dense(voxelise(ball, domain), domain)),
            0);
  // Two boxes whose tops, bottoms and one side lie in common planes.
  const Mesh boxes = joined(box({3, 4, 5}, {14, 20, 17}), box({9, 4, 5}, {21, 12, 17}));
  const auto inside = [](const Vec3d& p) {
    const bool one = p[0] > 3 && p[0] < 14 && p[1] > 4 && p[1]<20, two = p[0]> 9 && p[0] < 21 && p[1] > 4 && p[1] < 12;
    return (one || two) && p[2] > 5 && p[2] < 17;
  };
  EXPECT_EQ(differing(dense(voxelise(boxes, domain, 4, FillRule::Exact), domain), sampledCoverage(domain, 4, inside)),
            0);
}

TEST(VoxeliseExact, TrianglesFarSmallerThanAVoxelAddUp) {
  const Domain domain = cubeDomain(8);
  for (const double radius : {0.03, 0.6, 2.4}) { // edges from 1e-3 voxel
    const Mesh ball = icosphere({4.03, 3.97, 4.11}, radius, 5);
    const double whole = signedVolume(ball);
    EXPECT_NEAR(volume(voxelise(ball, domain, 8, FillRule::Exact), domain), whole, 0.03 * whole + 2.0 / 512) << radius;
  }
}

TEST(VoxeliseExact, ThreadsDoNotChangeABit) {
  const Domain domain = cubeDomain(64);
  const Mesh knot = translated(rotated(torus(20, 7, 120, 60), 0.5, 0.7), {32, 32, 32});
  RunContext one, two;
  one.threads = 1;
  two.threads = 2;
  EXPECT_EQ(differing(dense(voxelise(knot, domain, 4, FillRule::Auto, one), domain),
                      dense(voxelise(knot, domain, 4, FillRule::Auto, two), domain)),
            0);
}

TEST(VoxeliseExact, WhatSticksOutIsClipped) {
  const Mesh ball = icosphere({3, 30, 17}, 19.3, 3);
  const Domain whole = cubeDomain(64, 1, {-20, 0, -10}), part{{-4, 8, 2}, 1, {19, 13, 21}};
  const auto all = dense(voxelise(ball, whole), whole), some = dense(voxelise(ball, part), part);
  std::size_t i = 0;
  for (int x = 16; x < 35; ++x)
    for (int y = 8; y < 21; ++y)
      for (int z = 12; z < 33; ++z) ASSERT_EQ(some[i++], all[(x * 64 + y) * 64 + z]);
  // A domain inside the body is full, and needs no voxels for it.
  const Domain core = cubeDomain(8, 1, {0, 26, 13});
  const CoveragePatch full = voxelise(ball, core);
  EXPECT_EQ(full.coverage.activeBrickCount(), 0);
  EXPECT_DOUBLE_EQ(volume(full, core), 512);
  // One outside it is empty.
  EXPECT_EQ(volume(voxelise(ball, cubeDomain(8, 1, {100, 0, 0})), cubeDomain(8, 1, {100, 0, 0})), 0);
}

TEST(VoxeliseExact, HugeTrianglesCutTheDomainWhereTheirPlaneDoes) {
  const double size = 0x1p28; // voxels
  const Mesh cube = translated(rotated(box({-size, -size, -size}, {size, size, 0}), 0.4, 0.3), {8, 8, 8});
  const Domain domain = cubeDomain(16);
  const auto expected = sampledCoverage(
      domain, 4, [](const Vec3d& p) { return -std::sin(0.3) * (p[1] - 8) + std::cos(0.3) * (p[2] - 8) < 0; });
  EXPECT_LE(differing(dense(voxelise(cube, domain), domain), expected), 2);
}

TEST(VoxeliseExact, BadMeshesAreNamed) {
  const Domain domain = cubeDomain(8);
  const auto messageOf = [&](Mesh mesh, FillRule fill = FillRule::Auto) {
    try {
      voxelise(std::move(mesh), domain, 4, fill);
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::Input);
      return std::string(e.what());
    }
    return std::string("no error");
  };
  Mesh cube = box({1, 1, 1}, {5, 5, 5});
  EXPECT_NE(messageOf({}).find("no triangle"), std::string::npos);
  for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                             double(std::numeric_limits<float>::max())}) {
    Mesh bad = cube;
    bad.positions[3][1] = wrong;
    EXPECT_NE(messageOf(bad).find("vertex 3"), std::string::npos);
  }
  Mesh out = cube;
  out.triangles[2][1] = 8;
  EXPECT_NE(messageOf(out).find("vertex 8 of 8"), std::string::npos);
  Mesh open = cube;
  open.triangles.pop_back();
  EXPECT_NE(messageOf(open, FillRule::Exact).find("3 open"), std::string::npos);
}

/// The bits of every brick of a column, and the crossings beside them.
std::vector<std::uint64_t> crossingsOf(const RowsTask& task, int bricks, int log2) {
  RowPages pages(bricks, log2);
  crossRowsOneByOne(task, pages);
  pages.sortExtra();
  std::vector<std::uint64_t> all(pages.extra().begin(), pages.extra().end());
  for (int b = 0; b < bricks; ++b) {
    all.push_back(pages.touched(b));
    if (!pages.touched(b)) continue;
    const auto* words = pages.page<std::uint32_t>(b);
    all.insert(all.end(), words, words + 2 * (8 << log2) * (8 << log2));
  }
  return all;
}

TEST(ColumnBins, NoColumnMissesATriangle) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(-1, 1);
  Mesh mesh; // of every size, some far outside
  for (std::uint32_t t = 0; t < 700; ++t) {
    const double size = std::exp2(-7 + 14.0 * (t % 50) / 50);
    const Vec3d middle{16 + 20 * unit(random), 16 + 20 * unit(random), 16 + 20 * unit(random)};
    for (int i = 0; i < 3; ++i)
      mesh.positions.push_back(
          {middle[0] + size * unit(random), middle[1] + size * unit(random), middle[2] + size * unit(random)});
    mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  SubLattice lattice;
  lattice.log2 = 1;
  lattice.scale = 2;
  lattice.size = {64, 64, 64};
  const LatticeTriangles triangles(mesh, {}, lattice, {});
  const ColumnBins bins(triangles, lattice, "test", {});
  std::vector<std::uint32_t> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  std::int64_t listed = 0;
  for (std::int64_t column = 0; column < bins.size(); ++column) {
    RowsTask task = bins.task(column);
    listed += task.count;
    const auto found = crossingsOf(task, 4, lattice.log2);
    task.ids = all.data();
    task.count = static_cast<std::int64_t>(all.size());
    EXPECT_EQ(found, crossingsOf(task, 4, lattice.log2)) << column;
  }
  EXPECT_LT(listed, bins.size() * static_cast<std::int64_t>(all.size()) / 2);
}

TEST(CoverageRows, OffsetsDecideWhereNothingIsCrossed) {
  std::mt19937 random(19);
  const auto small = [&] { return static_cast<int>(random() % 5) - 2; };
  for (const int samples : {8, 32}) {
    std::vector<std::int32_t> winding(64);
    std::vector<std::int16_t> offsets(64 * static_cast<std::size_t>(samples));
    for (auto& w : winding) w = small();
    for (auto& o : offsets) o = static_cast<std::int16_t>(small());
    std::vector<std::uint32_t> inside(64);
    insideOfOffsets(winding.data(), offsets.data(), 64, samples, inside.data());
    for (int row = 0; row < 64; ++row) {
      std::int32_t after = winding[row];
      EXPECT_EQ(inside[row], kernels::insideBits<std::uint32_t>(
                                 {0, 0}, nullptr, 0, offsets.data() + static_cast<std::ptrdiff_t>(row) * samples, 0,
                                 samples, after));
    }
  }
}

} // namespace
} // namespace volcaustic::test
