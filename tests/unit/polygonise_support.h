// What the tests of the polygoniser share.
#pragma once

#include "volcaustic/error.h"
#include "volcaustic/polygonise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace volcaustic::test {

inline RunContext threads(int count) {
  RunContext ctx;
  ctx.threads = count;
  return ctx;
}
inline PolygoniseOptions cells(double size) {
  PolygoniseOptions options;
  options.cellSize = size;
  return options;
}

/// 2 for a sphere, 0 for a torus. Vertices are those of the mesh, not of places.
inline long eulerCharacteristic(const Mesh& mesh) {
  return static_cast<long>(mesh.positions.size()) - static_cast<long>(mesh.triangles.size()) / 2;
}

/// Every edge has two triangles that run along it both ways, and the triangles at each vertex are one fan: a closed,
/// oriented manifold by its indices. By its places, too: no two vertices are in one.
inline void expectManifold(const Mesh& mesh) {
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> ahead; // of each directed edge the third corner
  std::vector<std::uint32_t> degree(mesh.positions.size(), 0);
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      ++degree[t[k]];
      EXPECT_TRUE(ahead.emplace(std::array{t[k], t[(k + 1) % 3]}, t[(k + 2) % 3]).second) << "an edge used twice";
    }
  std::vector<bool> seen(mesh.positions.size(), false);
  for (const auto& [edge, corner] : ahead) {
    ASSERT_TRUE(ahead.contains({edge[1], edge[0]})) << "an open edge";
    if (seen[edge[0]]) continue;
    seen[edge[0]] = true;
    std::uint32_t fan = 1;
    for (std::uint32_t at = corner; at != edge[1]; ++fan) {
      ASSERT_LE(fan, degree[edge[0]]);
      at = ahead.at({edge[0], at});
    }
    EXPECT_EQ(fan, degree[edge[0]]) << "two fans meet in a vertex";
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), false), 0) << "vertices of no triangle";
  std::vector<Vec3d> places = mesh.positions;
  std::sort(places.begin(), places.end());
  EXPECT_EQ(std::adjacent_find(places.begin(), places.end()), places.end()) << "two vertices in one place";
}

} // namespace volcaustic::test
