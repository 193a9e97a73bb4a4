// Surfaces to deform, and what tests measure of them.
#pragma once

#include "support/solids.h"
#include "volcaustic/deform.h"
#include "volcaustic/error.h"

#include <gtest/gtest.h>
#include <string>

namespace volcaustic::test {

/// A closed bar along x from 0 to `length` with a square cross-section of edge 1 about the axis, `cells` squares of two
/// triangles for each unit.
inline Mesh bar(int length, int cells) {
  const int nx = length * cells;
  Mesh mesh;
  const auto side = [&](int count, int k) { return static_cast<double>(k) / cells - (count == nx ? 0 : .5); };
  const auto patch = [&](int nu, int nv, auto&& at) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (int v = 0; v <= nv; ++v)
      for (int u = 0; u <= nu; ++u) mesh.positions.push_back(at(side(nu, u), side(nv, v)));
    for (int v = 0; v < nv; ++v)
      for (int u = 0; u < nu; ++u) {
        const auto a = first + static_cast<std::uint32_t>(v * (nu + 1) + u), b = a + 1,
                   c = a + static_cast<std::uint32_t>(nu) + 1, d = c + 1;
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({a, d, c});
      }
  };
  patch(nx, cells, [](double x, double v) { return Vec3d{x, v, .5}; });
  patch(nx, cells, [](double x, double v) { return Vec3d{x, -v, -.5}; });
  patch(nx, cells, [](double x, double v) { return Vec3d{x, -.5, v}; });
  patch(nx, cells, [](double x, double v) { return Vec3d{x, .5, -v}; });
  patch(cells, cells, [&](double u, double v) { return Vec3d{double(length), u, v}; });
  patch(cells, cells, [](double u, double v) { return Vec3d{0, -u, v}; });
  return mesh;
}

inline Deformer handle(const Vec3d& center, double radius, const Placement& placement = {}) {
  Deformer d;
  d.center = center;
  d.radius = radius;
  d.placement = placement;
  return d;
}

inline Deformer brush(DeformerType type, const Vec3d& center, double radius, double strength,
                      const Vec3d& direction = {0, 0, 0}) {
  Deformer d;
  d.type = type;
  d.center = center;
  d.radius = radius;
  d.strength = strength;
  d.direction = direction;
  return d;
}

/// What `deformed` complains about; empty when it does not. Fails the test for another kind or more than one line.
inline std::string complaint(const Mesh& mesh, const std::vector<Deformer>& steps, const DeformOptions& options = {}) {
  try {
    (void)deformed(mesh, steps, options);
  } catch (const Error& error) {
    const std::string what = error.what();
    EXPECT_EQ(error.kind(), ErrorKind::Usage) << what;
    EXPECT_EQ(what.find('\n'), what.npos) << what;
    return what;
  }
  return {};
}

inline double distance(const Vec3d& a, const Vec3d& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

inline bool allFinite(const Mesh& mesh) {
  for (const Vec3d& p : mesh.positions)
    for (const double x : p)
      if (!std::isfinite(x)) return false;
  return true;
}

} // namespace volcaustic::test
