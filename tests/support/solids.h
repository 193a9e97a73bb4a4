// Closed meshes in closed form, finely tessellated.
#pragma once

#include "volcaustic/mesh.h"

#include <cmath>
#include <memory>

namespace volcaustic::test {

/// An ellipsoid of `rings` x 2 `rings` patches, outward-facing, poles on the z axis.
inline Mesh ellipsoid(const Vec3d& centre, const Vec3d& radii, int rings) {
  const double pi = 3.14159265358979323846;
  const int columns = 2 * rings;
  Mesh m;
  m.positions.push_back({centre[0], centre[1], centre[2] + radii[2]});
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < columns; ++j) {
      const double theta = pi * i / rings, phi = 2 * pi * j / columns;
      m.positions.push_back({centre[0] + radii[0] * std::sin(theta) * std::cos(phi),
                             centre[1] + radii[1] * std::sin(theta) * std::sin(phi),
                             centre[2] + radii[2] * std::cos(theta)});
    }
  m.positions.push_back({centre[0], centre[1], centre[2] - radii[2]});
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(1 + (i - 1) * columns + j % columns); };
  const auto south = static_cast<std::uint32_t>(m.positions.size() - 1);
  for (int j = 0; j < columns; ++j) {
    m.triangles.push_back({0, at(1, j), at(1, j + 1)});
    for (int i = 1; i < rings - 1; ++i) {
      m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    m.triangles.push_back({at(rings - 1, j), south, at(rings - 1, j + 1)});
  }
  return m;
}

inline std::shared_ptr<const Mesh> ball(const Vec3d& centre, double radius, int rings = 64) {
  return std::make_shared<const Mesh>(ellipsoid(centre, {radius, radius, radius}, rings));
}

} // namespace volcaustic::test
