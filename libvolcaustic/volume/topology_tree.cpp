#include "volume/topology_tree.h"

#include <algorithm>
#include <numeric>

namespace volcaustic {

namespace {

Vec3d onward(const Vec3d& a, double s, const Vec3d& u, double t = 0, const Vec3d& v = {0, 0, 0}) {
  return {a[0] + s * u[0] + t * v[0], a[1] + s * u[1] + t * v[1], a[2] + s * u[2] + t * v[2]};
}

double part(double numerator, double denominator) { return denominator > 0 ? numerator / denominator : 0; }

} // namespace

// Ericson, "Real-Time Collision Detection", 5.1.5, by the regions of the triangle's corners, edges and face.
Vec3d closestPointOfTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = difference(b, a), ac = difference(c, a);
  const Vec3d ap = difference(p, a), bp = difference(p, b), cp = difference(p, c);
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
               d6 = dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return onward(a, part(d1, d1 - d3), ab);
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return onward(a, part(d2, d2 - d6), ac);
  if (va <= 0 && d4 >= d3 && d5 >= d6) return onward(b, part(d4 - d3, (d4 - d3) + (d5 - d6)), difference(c, b));
  const double sum = va + vb + vc;
  return sum > 0 ? onward(a, vb / sum, ab, vc / sum, ac) : a;
}

TriangleTree::TriangleTree(std::span<const Vec3d> positions, std::vector<TriangleCorners> triangles)
    : mPositions(positions), mTriangles(std::move(triangles)), mOrder(mTriangles.size()) {
  std::iota(mOrder.begin(), mOrder.end(), 0u);
  std::vector<Vec3d> centres(mTriangles.size());
  for (std::uint32_t i = 0; i < centres.size(); ++i)
    for (int k = 0; k < 3; ++k) centres[i][k] = corner(i, 0)[k] + corner(i, 1)[k] + corner(i, 2)[k];
  mNodes.reserve(mTriangles.size());
  build(0, static_cast<std::uint32_t>(mOrder.size()), centres);
}

void TriangleTree::build(std::uint32_t begin, std::uint32_t end, const std::vector<Vec3d>& centres) {
  constexpr double kMost = std::numeric_limits<double>::max();
  Box box{{kMost, kMost, kMost}, {-kMost, -kMost, -kMost}}, span = box;
  for (std::uint32_t i = begin; i < end; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 0; k < 3; ++k) {
        box.min[axis] = std::min(box.min[axis], corner(mOrder[i], k)[axis]);
        box.max[axis] = std::max(box.max[axis], corner(mOrder[i], k)[axis]);
      }
      span.min[axis] = std::min(span.min[axis], centres[mOrder[i]][axis]);
      span.max[axis] = std::max(span.max[axis], centres[mOrder[i]][axis]);
    }
  const std::size_t self = mNodes.size();
  mNodes.push_back({box, begin, end - begin});
  if (end - begin <= kLeaf) return;
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (span.max[k] - span.min[k] > span.max[axis] - span.min[axis]) axis = k;
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(mOrder.begin() + begin, mOrder.begin() + middle, mOrder.begin() + end,
                   [&](std::uint32_t i, std::uint32_t j) {
                     return centres[i][axis] != centres[j][axis] ? centres[i][axis] < centres[j][axis] : i < j;
                   });
  build(begin, middle, centres);
  const auto right = static_cast<std::uint32_t>(mNodes.size());
  build(middle, end, centres);
  mNodes[self].first = right;
  mNodes[self].count = 0;
}

} // namespace volcaustic
