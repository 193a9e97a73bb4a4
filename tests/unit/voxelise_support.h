// Procedural meshes, and slow but obvious answers to compare the voxeliser with.
#pragma once

#include "volcaustic/medium.h"
#include "volcaustic/mesh.h"
#include "volume/coverage_rows.h"
#include "volume/voxelise.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

namespace volcaustic::test {

inline Mesh box(const Vec3d& low, const Vec3d& high) {
  Mesh m;
  for (int i = 0; i < 8; ++i)
    m.positions.push_back({i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]});
  m.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return m;
}

inline Mesh icosphere(const Vec3d& centre, double radius, int subdivisions) {
  const double g = std::numbers::phi;
  std::vector<Vec3d> p{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                       {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<std::uint32_t, 3>> t{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                              {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                              {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                              {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int s = 0; s < subdivisions; ++s) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, added] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(p.size()));
      if (added) p.push_back({p[a][0] + p[b][0], p[a][1] + p[b][1], p[a][2] + p[b][2]});
      const double length = std::hypot(p[it->second][0], p[it->second][1], p[it->second][2]);
      for (double& c : p[it->second]) c *= std::hypot(1.0, g) / length;
      return it->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : t) {
      const auto ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    t = std::move(finer);
  }
  Mesh m;
  for (const Vec3d& v : p) {
    const double scale = radius / std::hypot(v[0], v[1], v[2]);
    m.positions.push_back({centre[0] + scale * v[0], centre[1] + scale * v[1], centre[2] + scale * v[2]});
  }
  m.triangles = std::move(t);
  return m;
}

inline Mesh torus(double major, double minor, int around, int across) {
  Mesh m;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across;
      const double r = major + minor * std::cos(v);
      m.positions.push_back({r * std::cos(u), r * std::sin(u), minor * std::sin(v)});
    }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i % around * across + j % across); };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return m;
}

/// Rotated about z, then about x.
inline Mesh rotated(Mesh m, double aboutZ, double aboutX) {
  const double cz = std::cos(aboutZ), sz = std::sin(aboutZ), cx = std::cos(aboutX), sx = std::sin(aboutX);
  for (Vec3d& p : m.positions) {
    p = {cz * p[0] - sz * p[1], sz * p[0] + cz * p[1], p[2]};
    p = {p[0], cx * p[1] - sx * p[2], sx * p[1] + cx * p[2]};
  }
  return m;
}

inline Mesh translated(Mesh m, const Vec3d& by) {
  for (Vec3d& p : m.positions)
    for (int a = 0; a < 3; ++a) p[a] += by[a];
  return m;
}

inline Mesh reversed(Mesh m) {
  for (auto& t : m.triangles) std::swap(t[1], t[2]);
  return m;
}

inline Mesh joined(Mesh a, const Mesh& b) {
  const auto offset = static_cast<std::uint32_t>(a.positions.size());
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return a;
}

inline double signedVolume(const Mesh& m) {
  double six = 0;
  for (const auto& t : m.triangles) {
    const Vec3d &a = m.positions[t[0]], &b = m.positions[t[1]], &c = m.positions[t[2]];
    six += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return six / 6;
}

/// Generalised winding number, triangle by triangle.
inline double windingNumber(const Mesh& m, const Vec3d& p) {
  double sum = 0;
  for (const auto& t : m.triangles) {
    std::array<Vec3d, 3> v;
    std::array<double, 3> l;
    for (int i = 0; i < 3; ++i) {
      const Vec3d& q = m.positions[t[i]];
      v[i] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
      l[i] = std::sqrt(v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2]);
    }
    const auto dot = [](const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    const double det = v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) -
                       v[0][1] * (v[1][0] * v[2][2] - v[1][2] * v[2][0]) +
                       v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
    sum +=
        std::atan2(det, l[0] * l[1] * l[2] + dot(v[0], v[1]) * l[2] + dot(v[1], v[2]) * l[0] + dot(v[2], v[0]) * l[1]);
  }
  return sum / (2 * std::numbers::pi);
}

/// Voxels of edge 1 with the corner at the origin, unless said otherwise.
inline Domain cubeDomain(int n, double h = 1, const Vec3d& corner = {0, 0, 0}) { return {corner, h, {n, n, n}}; }

inline Body bodyOf(Mesh mesh, int priority = 0) {
  Body body;
  body.mesh = std::make_shared<const Mesh>(std::move(mesh));
  body.priority = priority;
  body.name = "body";
  return body;
}

inline CoveragePatch voxelise(Mesh mesh, const Domain& domain, int supersample = 4, FillRule fill = FillRule::Auto,
                              const RunContext& ctx = {}) {
  return voxeliseBody(bodyOf(std::move(mesh)), domain, supersample, fill, ctx);
}

/// All voxels of the domain, z fastest.
inline std::vector<float> dense(const CoveragePatch& patch, const Domain& domain) {
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(domain.voxelCount()));
  const Vec3i size = patch.coverage.dims();
  for (int x = 0; x < domain.dims[0]; ++x)
    for (int y = 0; y < domain.dims[1]; ++y)
      for (int z = 0; z < domain.dims[2]; ++z) {
        const Vec3i at{x - 8 * patch.firstBrick[0], y - 8 * patch.firstBrick[1], z - 8 * patch.firstBrick[2]};
        bool within = true;
        for (int a = 0; a < 3; ++a) within = within && at[a] >= 0 && at[a] < size[a];
        values.push_back(within ? patch.coverage.at(at[0], at[1], at[2]) : 0.0f);
      }
  return values;
}

inline double volume(const CoveragePatch& patch, const Domain& domain) {
  double sum = 0;
  for (const float c : dense(patch, domain)) sum += c;
  return sum * domain.voxelSize * domain.voxelSize * domain.voxelSize;
}

/// Coverage with inside(point) asked at every sample.
template <class Inside>
std::vector<float> sampledCoverage(const Domain& domain, int supersample, Inside&& inside) {
  std::vector<float> values;
  const int s = supersample;
  const double h = domain.voxelSize / s;
  SubLattice lattice;
  while (1 << lattice.log2 < s) ++lattice.log2;
  const auto isInside = [&](int i, int j, int k) {
    Vec3d p = lattice.sample(i, j, k);
    for (int a = 0; a < 3; ++a) p[a] = domain.minCorner[a] + h * p[a];
    return inside(p);
  };
  for (int x = 0; x < domain.dims[0]; ++x)
    for (int y = 0; y < domain.dims[1]; ++y)
      for (int z = 0; z < domain.dims[2]; ++z) {
        int count = 0;
        for (int i = 0; i < s; ++i)
          for (int j = 0; j < s; ++j)
            for (int k = 0; k < s; ++k) count += isInside(x * s + i, y * s + j, z * s + k);
        values.push_back(float(count) / float(s * s * s));
      }
  return values;
}

inline std::int64_t differing(const std::vector<float>& a, const std::vector<float>& b) {
  std::int64_t count = a.size() != b.size();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) count += a[i] != b[i];
  return count;
}

} // namespace volcaustic::test
