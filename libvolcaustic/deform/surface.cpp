#include "deform/surface.h"

#include "mesh/vector.h"
#include "mesh/weld.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace volcaustic {

namespace {

/// Of a corner whose angle has no meaning: that of an equilateral triangle.
constexpr double kPlainCotangent = .57735026918962576;

double cotangent(const Vec3d& at, const Vec3d& b, const Vec3d& c) {
  const Vec3d u = difference(b, at), v = difference(c, at), n = cross(u, v);
  const double value = dot(u, v) / std::sqrt(dot(n, n));
  return std::isfinite(value) ? value : kPlainCotangent;
}

struct Edge {
  std::uint32_t a, b; // a < b
  double weight;      // of one triangle; of all once merged
  std::uint32_t triangles;
};

/// All edges once, sorted by their ends. The order of sums is that of the triangles.
std::vector<Edge> edgesOf(const DeformSurface& surface) {
  std::vector<Edge> edges;
  edges.reserve(3 * surface.triangles.size());
  for (const TriangleCorners& t : surface.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      const double cot = cotangent(surface.points[c], surface.points[a], surface.points[b]);
      edges.push_back({std::min(a, b), std::max(a, b), cot / 2, 1});
    }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const Edge& x, const Edge& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (kept > 0 && edges[kept - 1].a == edges[i].a && edges[kept - 1].b == edges[i].b) {
      edges[kept - 1].weight += edges[i].weight;
      ++edges[kept - 1].triangles;
    } else {
      edges[kept++] = edges[i];
    }
  }
  edges.resize(kept);
  for (Edge& edge : edges)
    edge.weight = std::clamp(edge.weight, DeformSurface::kLeastWeight, DeformSurface::kMostWeight);
  return edges;
}

/// Makes room in `lists` for counts[p] entries of each point p.
void layOut(PointLists& lists, const std::vector<std::uint32_t>& counts) {
  lists.start.assign(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), lists.start.begin() + 1);
  lists.entries.resize(lists.start.back());
}

void listNeighbours(DeformSurface& surface, const std::vector<Edge>& edges) {
  std::vector<std::uint32_t> counts(surface.points.size(), 0);
  for (const Edge& edge : edges) ++counts[edge.a], ++counts[edge.b];
  layOut(surface.neighbours, counts);
  surface.weights.resize(surface.neighbours.entries.size());
  std::vector<std::uint32_t> next(surface.neighbours.start.begin(), surface.neighbours.start.end() - 1);
  const auto add = [&](std::uint32_t from, std::uint32_t to, double weight) {
    surface.neighbours.entries[next[from]] = to;
    surface.weights[next[from]++] = weight;
  };
  surface.onBorder.assign(surface.points.size(), false);
  for (const Edge& edge : edges) {
    add(edge.a, edge.b, edge.weight);
    add(edge.b, edge.a, edge.weight);
    if (edge.triangles == 1) surface.onBorder[edge.a] = surface.onBorder[edge.b] = true;
  }
}

void listTriangles(DeformSurface& surface) {
  std::vector<std::uint32_t> counts(surface.points.size(), 0);
  for (const TriangleCorners& t : surface.triangles)
    for (const std::uint32_t p : t) ++counts[p];
  layOut(surface.trianglesOf, counts);
  std::vector<std::uint32_t> next(surface.trianglesOf.start.begin(), surface.trianglesOf.start.end() - 1);
  for (std::uint32_t i = 0; i < surface.triangles.size(); ++i)
    for (const std::uint32_t p : surface.triangles[i]) surface.trianglesOf.entries[next[p]++] = i;
}

void numberComponents(DeformSurface& surface) {
  constexpr std::uint32_t kNone = 0xffffffffu;
  surface.component.assign(surface.points.size(), kNone);
  std::vector<std::uint32_t> open;
  for (std::uint32_t first = 0; first < surface.points.size(); ++first) {
    if (surface.component[first] != kNone) continue;
    surface.component[first] = surface.componentCount;
    for (open.push_back(first); !open.empty();) {
      const std::uint32_t p = open.back();
      open.pop_back();
      for (const std::uint32_t q : surface.neighbours.of(p)) {
        if (surface.component[q] != kNone) continue;
        surface.component[q] = surface.componentCount;
        open.push_back(q);
      }
    }
    ++surface.componentCount;
  }
}

} // namespace

DeformSurface makeDeformSurface(const Mesh& mesh) {
  DeformSurface surface;
  PositionWelder welder(mesh.positions.size());
  surface.pointOf.reserve(mesh.positions.size());
  for (const Vec3d& p : mesh.positions) surface.pointOf.push_back(welder.add(p));
  surface.points = welder.takePositions();
  surface.triangles.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    const TriangleCorners corners{surface.pointOf[t[0]], surface.pointOf[t[1]], surface.pointOf[t[2]]};
    if (!hasRepeatedCorner(corners)) surface.triangles.push_back(corners);
  }
  listNeighbours(surface, edgesOf(surface));
  listTriangles(surface);
  numberComponents(surface);
  return surface;
}

} // namespace volcaustic
