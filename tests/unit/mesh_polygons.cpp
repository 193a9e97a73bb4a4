// Polygons into triangles: areas, counts and orientation.
#include "mesh/triangulate.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace volcaustic::test {
namespace {

using Polygon = std::vector<Vec3d>;

Polygon flat(const std::vector<std::array<double, 2>>& outline) {
  Polygon polygon;
  for (const auto& [x, y] : outline) polygon.push_back({x, y, 0});
  return polygon;
}

/// Turned into a slanted plane and moved far away.
Polygon placed(const Polygon& polygon, bool mirrored) {
  Polygon result;
  for (const Vec3d& p : polygon) {
    const double y = mirrored ? -p[1] : p[1];
    result.push_back({2e4 + 0.6 * p[0] - 0.64 * y, -1e4 + 0.8 * p[0] + 0.48 * y, 5e3 + 0.6 * y});
  }
  return result;
}

Vec3d areaVector(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d u{b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  return {(u[1] * v[2] - u[2] * v[1]) / 2, (u[2] * v[0] - u[0] * v[2]) / 2, (u[0] * v[1] - u[1] * v[0]) / 2};
}

struct Split {
  std::size_t triangles = 0;
  double covered = 0; ///< sum of the triangles' areas
  double net = 0;     ///< length of the sum of their area vectors: the polygon's area, if they do not overlap
};

Split split(const Polygon& polygon) {
  PolygonTriangulator triangulator;
  Split result;
  Vec3d sum{0, 0, 0};
  for (const auto& [a, b, c] : triangulator.triangulate(polygon)) {
    const Vec3d area = areaVector(polygon[a], polygon[b], polygon[c]);
    result.covered += std::hypot(area[0], area[1], area[2]);
    for (int k = 0; k < 3; ++k) sum[k] += area[k];
    ++result.triangles;
  }
  result.net = std::hypot(sum[0], sum[1], sum[2]);
  return result;
}

void expectArea(const Polygon& polygon, double area) {
  for (const bool mirrored : {false, true})
    for (std::size_t start = 0; start < polygon.size(); ++start) {
      Polygon turned;
      for (std::size_t i = 0; i < polygon.size(); ++i) turned.push_back(polygon[(start + i) % polygon.size()]);
      const Split result = split(placed(turned, mirrored));
      EXPECT_EQ(result.triangles, polygon.size() - 2);
      EXPECT_NEAR(result.covered, area, 1e-8 * area) << "start " << start;
      EXPECT_NEAR(result.net, area, 1e-8 * area) << "start " << start;
    }
}

TEST(MeshPolygons, ConvexOnesAreFans) {
  Polygon hexagon;
  for (int i = 0; i < 6; ++i)
    hexagon.push_back({std::cos(i * std::numbers::pi / 3), std::sin(i * std::numbers::pi / 3), 0});
  PolygonTriangulator triangulator;
  const auto triangles = triangulator.triangulate(hexagon);
  ASSERT_EQ(triangles.size(), 4u);
  for (std::uint32_t i = 0; i < 4; ++i) EXPECT_EQ(triangles[i], (std::array<std::uint32_t, 3>{0, i + 1, i + 2}));
  expectArea(hexagon, 1.5 * std::sqrt(3.0));
}

TEST(MeshPolygons, ConcaveOnesKeepTheirArea) {
  expectArea(flat({{0, 0}, {2, 2}, {0, 1}, {-2, 2}}), 2);                // arrow head
  expectArea(flat({{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}}), 5); // L
  expectArea(flat({{0, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1}, {3, 1}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}),
             11); // comb
}

TEST(MeshPolygons, CornersOnALineAreHarmless) {
  expectArea(flat({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}), 4);
  expectArea(flat({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1}, {2, 1}, {1, 1}, {1, 2}, {1, 3}, {0, 3}}), 5);
}

TEST(MeshPolygons, HolesOnABridge) {
  // A square of 4x4 with a hole of 2x2, joined along a doubled edge.
  expectArea(flat({{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}}), 12);
}

TEST(MeshPolygons, LargeSpiral) {
  // A band of constant width wound many times: every ear is hard to find.
  constexpr int kCorners = 1500;
  Polygon polygon;
  const auto at = [](double turn, double radius) { return Vec3d{radius * std::cos(turn), radius * std::sin(turn), 0}; };
  for (int i = 0; i < kCorners; ++i) polygon.push_back(at(0.05 * i, 1 + 0.05 * i));
  for (int i = kCorners; i-- > 0;) polygon.push_back(at(0.05 * i, 1.1 + 0.05 * i));
  const Split result = split(polygon);
  EXPECT_EQ(result.triangles, polygon.size() - 2);
  EXPECT_NEAR(result.covered, result.net, 1e-9 * result.net);
}

TEST(MeshPolygons, CrossingAndFlatOnesAreSplitAllTheSame) {
  EXPECT_EQ(split(flat({{0, 0}, {1, 1}, {1, 0}, {0, 1}})).triangles, 2u);         // bow tie
  EXPECT_EQ(split(flat({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}})).triangles, 3u); // a line
  EXPECT_EQ(split(Polygon(7, Vec3d{1, 2, 3})).triangles, 5u);                     // a point
  Polygon star;
  for (int i = 0; i < 5; ++i)
    star.push_back({std::cos(i * 0.8 * std::numbers::pi), std::sin(i * 0.8 * std::numbers::pi), 0});
  EXPECT_EQ(split(star).triangles, 3u);
  EXPECT_EQ(split({{1e300, 0, 0}, {0, 1e300, 0}, {-1e300, 0, 1e300}, {0, -1e300, 0}}).triangles, 2u);
}

TEST(MeshPolygons, TooManyCornersAreRefusedOnlyWhenConcave) {
  Polygon circle;
  const auto n = static_cast<int>(kMaxConcaveCorners) + 1;
  for (int i = 0; i < n; ++i)
    circle.push_back({std::cos(2 * std::numbers::pi * i / n), std::sin(2 * std::numbers::pi * i / n), 0});
  EXPECT_EQ(split(circle).triangles, circle.size() - 2);
  circle[100] = {0, 0, 0};
  EXPECT_EQ(split(circle).triangles, 0u);
}

} // namespace
} // namespace volcaustic::test
