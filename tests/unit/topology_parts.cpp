#include "topology_support.h"

namespace volcaustic {
namespace {

using namespace test;

/// The least distance between vertices on either side of a plane across x.
double gapAcross(const Mesh& m, double x) {
  double least = 1e9;
  for (const Vec3d& p : m.positions)
    for (const Vec3d& q : m.positions)
      if (p[0] < x && q[0] > x) least = std::min(least, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
  return least;
}

TEST(TopologyKeep, BallsEndWithTheGapBetween) {
  TopologyOptions options;
  options.voxelSize = 0.04;
  for (const double gap : {0.03, 0.12})
    for (const double distance : {2.02, 1.7}) {
      options.gap = gap;
      const Mesh mesh = twoBalls(distance, 24);
      const TopologyResult result = controlled(mesh, options, Topology::Keep);
      expectSound(result, mesh);
      EXPECT_EQ(result.partsAfter, 2u);
      EXPECT_NEAR(gapAcross(result.mesh, distance / 2 + 0.0131), gap, options.voxelSize) << distance;
    }
}

TEST(TopologyKeep, BothGiveWayAlikeAndNowhereElse) {
  TopologyOptions options;
  options.gap = 0.1;
  const Mesh mesh = twoBalls(1.7, 32);
  const TopologyResult result = controlled(mesh, options, Topology::Keep);
  double left = 0, right = 0;
  for (std::size_t i = 0; i < result.mesh.triangles.size(); ++i) {
    const auto& t = result.mesh.triangles[i];
    const Vec3d &a = result.mesh.positions[t[0]], &b = result.mesh.positions[t[1]], &c = result.mesh.positions[t[2]];
    const double middle = 0.85 + 0.0131, volume = ((a[0] - middle) * (b[1] * c[2] - b[2] * c[1]) +
                                                   a[1] * (b[2] * (c[0] - middle) - (b[0] - middle) * c[2]) +
                                                   a[2] * ((b[0] - middle) * c[1] - b[1] * (c[0] - middle))) /
                                                  6;
    (a[0] < middle ? left : right) += volume;
  }
  EXPECT_NEAR(left / right, 1, 0.005);
  EXPECT_GT(static_cast<double>(result.keptTriangles), 0.6 * static_cast<double>(mesh.triangles.size()));
}

TEST(TopologyKeep, ThreePartsGiveWayPairByPair) {
  TopologyOptions options;
  options.voxelSize = 0.05;
  options.gap = 0.1;
  const Mesh mesh = together(twoBalls(1.7, 20), ellipsoid({0.85, 1.5, 0.02}, {1, 1, 1}, 20));
  const TopologyResult result = controlled(mesh, options, Topology::Keep);
  expectSound(result, mesh);
  EXPECT_EQ(result.partsAfter, 3u);
}

TEST(TopologySplit, DumbbellFallsInTwo) {
  // Two balls that a thin rod joins.
  const auto profile = [](double z) {
    const double x = 1 - (std::abs(z) - 1.3) * (std::abs(z) - 1.3);
    return std::max(x > 0 ? std::sqrt(x) : 0, std::abs(z) < 1.3 ? 0.1 : 0.0);
  };
  const Mesh mesh = revolved(48, 2.3, profile);
  TopologyOptions options;
  options.voxelSize = 0.04;
  options.neck = 0.3;
  const TopologyResult result = controlled(mesh, options, Topology::Split);
  expectSound(result, mesh);
  EXPECT_EQ(result.partsBefore, 1u);
  EXPECT_EQ(result.partsAfter, 2u);
  EXPECT_GT(static_cast<double>(result.keptTriangles), 0.6 * static_cast<double>(mesh.triangles.size()));
  for (const Vec3d& p : result.mesh.positions) EXPECT_GT(std::abs(p[2]), 0.1); // the rod is gone
  options.neck = 0.16;                                                         // thinner than the rod
  EXPECT_EQ(controlled(mesh, options, Topology::Split).newTriangles, 0u);
}

TEST(TopologySplit, RingFallsApartAtTwoNecksAndNotAtOne) {
  const auto ring = [](double u) { return Vec3d{std::cos(u), std::sin(u), 0.0}; };
  const auto thin = [](double u, double at) {
    const double d = std::remainder(u - at, 2 * std::numbers::pi);
    return 0.17 * std::exp(-4 * d * d);
  };
  TopologyOptions options;
  options.voxelSize = 0.04;
  options.neck = 0.3;
  const Mesh one = tube(80, 20, ring, [&](double u) { return 0.25 - thin(u, 0); });
  EXPECT_EQ(controlled(one, options, Topology::Split).newTriangles, 0u);
  const Mesh two = tube(80, 20, ring, [&](double u) { return 0.25 - thin(u, 0) - thin(u, std::numbers::pi); });
  const TopologyResult result = controlled(two, options, Topology::Split);
  expectSound(result, two);
  EXPECT_EQ(result.partsAfter, 2u);
}

TEST(TopologySplit, SpikesStay) {
  const Mesh mesh = ellipsoid({0, 0, 0}, {1, 0.2, 0.2}, 24); // thin ends part nothing
  TopologyOptions options;
  options.neck = 0.25;
  EXPECT_EQ(controlled(mesh, options, Topology::Split).newTriangles, 0u);
}

} // namespace
} // namespace volcaustic
