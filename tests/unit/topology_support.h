// Surfaces that meet, and what every surface must be after its topology was controlled.
#pragma once

#include "support/solids.h"
#include "volcaustic/deform.h"
#include "volcaustic/topology.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <set>

namespace volcaustic::test {

inline Mesh together(Mesh a, const Mesh& b) {
  const auto offset = static_cast<std::uint32_t>(a.positions.size());
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return a;
}

/// Unit balls with `distance` between their centres, off the lattice.
inline Mesh twoBalls(double distance, int rings) {
  return together(ellipsoid({0.0131, 0.0072, 0.0033}, {1, 1, 1}, rings),
                  ellipsoid({distance + 0.0131, 0.0072, 0.0033}, {1, 1, 1}, rings));
}

/// Of the union of two unit balls.
inline double unionVolume(double distance) {
  const double height = std::max(0.0, 1 - distance / 2), pi = std::numbers::pi;
  return 8 * pi / 3 - 2 * pi * height * height * (3 - height) / 3;
}

/// A closed tube around the closed curve centre(u), 0 <= u < 2 pi, of radius radius(u); sides across z and the curve.
inline Mesh tube(int along, int around, const std::function<Vec3d(double)>& centre,
                 const std::function<double(double)>& radius) {
  Mesh m;
  const double turn = 2 * std::numbers::pi;
  for (int i = 0; i < along; ++i) {
    const double u = turn * i / along, step = 1e-4;
    const Vec3d c = centre(u), a = centre(u + step), b = centre(u - step);
    const double dx = a[0] - b[0], dy = a[1] - b[1], length = std::hypot(dx, dy);
    for (int j = 0; j < around; ++j) {
      const double w = turn * j / around, r = radius(u);
      m.positions.push_back(
          {c[0] + r * std::cos(w) * dy / length, c[1] - r * std::cos(w) * dx / length, c[2] + r * std::sin(w)});
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>((i % along) * around + j % around); };
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j) {
      m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  if (checkMesh(m).signedVolume < 0)
    for (auto& t : m.triangles) std::swap(t[1], t[2]);
  return m;
}

/// A surface of revolution around z of radius(z), from the pole at -end to that at end.
inline Mesh revolved(int rings, double end, const std::function<double(double)>& radius) {
  Mesh m = ellipsoid({0, 0, 0}, {1, 1, 1}, rings);
  for (Vec3d& p : m.positions) {
    const double z = end * (1 - 2 * std::acos(std::clamp(p[2], -1.0, 1.0)) / std::numbers::pi);
    const double length = std::hypot(p[0], p[1]), r = length > 0 ? radius(z) / length : 0;
    p = {p[0] * r, p[1] * r, z};
  }
  return m;
}

using Corners = std::array<Vec3d, 3>;

inline std::set<Corners> cornersOf(const Mesh& m, std::size_t count) {
  std::set<Corners> corners;
  for (std::size_t i = 0; i < count; ++i)
    corners.insert({m.positions[m.triangles[i][0]], m.positions[m.triangles[i][1]], m.positions[m.triangles[i][2]]});
  return corners;
}

/// Closed, consistently wound, manifold, nowhere through itself, and what is said to be kept is of the mesh as it was.
inline void expectSound(const TopologyResult& result, const Mesh& before) {
  const MeshReport report = checkMesh(result.mesh);
  EXPECT_TRUE(report.closedAndConsistent()) << describeDefects(report);
  EXPECT_EQ(report.nonManifoldEdges, 0u);
  EXPECT_EQ(report.shellCount, result.partsAfter);
  EXPECT_EQ(report.inwardBodies, 0u);
  EXPECT_EQ(findSelfIntersections(result.mesh).pairs, 0u);
  EXPECT_EQ(result.keptTriangles + result.newTriangles, result.mesh.triangles.size());
  const std::set<Corners> old = cornersOf(before, before.triangles.size());
  for (const Corners& c : cornersOf(result.mesh, result.keptTriangles)) ASSERT_TRUE(old.contains(c));
}

inline TopologyResult controlled(const Mesh& mesh, TopologyOptions options, Topology topology, int threads = 0) {
  options.topology = topology;
  RunContext ctx;
  ctx.threads = threads;
  return controlTopology(mesh, options, ctx);
}

} // namespace volcaustic::test
