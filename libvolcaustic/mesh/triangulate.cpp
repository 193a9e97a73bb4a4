#include "mesh/triangulate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace volcaustic {

namespace {

using Point = std::array<double, 2>;

/// Twice the signed area of a triangle, positive when counter-clockwise.
double cross(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Newell's normal, from differences to the first corner so that a polygon far from the origin keeps its digits.
Vec3d newellNormal(std::span<const Vec3d> corners) {
  Vec3d normal{0, 0, 0};
  const Vec3d& o = corners[0];
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3d& p = corners[i];
    const Vec3d& q = corners[(i + 1) % corners.size()];
    for (int k = 0; k < 3; ++k) {
      const int u = (k + 1) % 3, v = (k + 2) % 3;
      normal[k] += ((p[u] - o[u]) - (q[u] - o[u])) * ((p[v] - o[v]) + (q[v] - o[v]));
    }
  }
  return normal;
}

} // namespace

std::span<const std::array<std::uint32_t, 3>> PolygonTriangulator::triangulate(std::span<const Vec3d> corners) {
  mTriangles.clear();
  if (!project(corners) || isConvex())
    fan(static_cast<std::uint32_t>(corners.size()));
  else if (corners.size() <= kMaxConcaveCorners)
    clipEars();
  return mTriangles;
}

bool PolygonTriangulator::project(std::span<const Vec3d> corners) {
  const Vec3d normal = newellNormal(corners);
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
  if (!(std::abs(normal[axis]) > 0) || !std::isfinite(normal[axis])) return false;
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (normal[axis] < 0) std::swap(u, v);
  mPoints.resize(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i)
    mPoints[i] = {corners[i][u] - corners[0][u], corners[i][v] - corners[0][v]};
  return true;
}

bool PolygonTriangulator::isConvex() const {
  // No right turn, and once around only: the direction changes from rightwards to leftwards and back once.
  const std::size_t n = mPoints.size();
  int firstSign = 0, sign = 0, changes = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Point &a = mPoints[i], &b = mPoints[(i + 1) % n];
    if (cross(a, b, mPoints[(i + 2) % n]) < 0) return false;
    const int s = (b[0] > a[0]) - (b[0] < a[0]);
    if (s == 0) continue;
    if (firstSign == 0) firstSign = s;
    if (sign != 0 && s != sign) ++changes;
    sign = s;
  }
  return changes + (sign != firstSign ? 1 : 0) <= 2;
}

void PolygonTriangulator::fan(std::uint32_t count) {
  for (std::uint32_t i = 2; i < count; ++i) mTriangles.push_back({0, i - 1, i});
}

double PolygonTriangulator::turn(std::uint32_t corner) const {
  return cross(mPoints[mPrevious[corner]], mPoints[corner], mPoints[mNext[corner]]);
}

bool PolygonTriangulator::isEar(std::uint32_t corner) const {
  const Point &a = mPoints[mPrevious[corner]], &b = mPoints[corner], &c = mPoints[mNext[corner]];
  if (mIsReflex[corner]) return false;
  // Where any corner lies inside the triangle, a reflex one does. Doubles of the triangle's own corners do not count:
  // they belong to the bridge of a hole.
  return std::none_of(mReflex.begin(), mReflex.end(), [&](std::uint32_t r) {
    const Point& p = mPoints[r];
    return mIsReflex[r] && p != a && p != b && p != c && cross(a, b, p) >= 0 && cross(b, c, p) >= 0 &&
           cross(c, a, p) >= 0;
  });
}

void PolygonTriangulator::classify(std::uint32_t corner) {
  mIsReflex[corner] = turn(corner) <= 0;
  mIsEar[corner] = isEar(corner);
}

std::uint32_t PolygonTriangulator::pickCorner(std::uint32_t start) const {
  // A simple polygon always has an ear. Of any other one, cut a flat corner, which changes nothing, or just a convex
  // one.
  std::uint32_t flat = start, convex = start;
  std::uint32_t corner = start;
  do {
    if (mIsEar[corner]) return corner;
    if (turn(flat) != 0 && turn(corner) == 0) flat = corner;
    if (mIsReflex[convex] && !mIsReflex[corner]) convex = corner;
    corner = mNext[corner];
  } while (corner != start);
  return turn(flat) == 0 ? flat : convex;
}

void PolygonTriangulator::clipEars() {
  const auto n = static_cast<std::uint32_t>(mPoints.size());
  mPrevious.resize(n);
  mNext.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) mPrevious[i] = (i + n - 1) % n, mNext[i] = (i + 1) % n;
  mIsReflex.assign(n, 0);
  mIsEar.assign(n, 0);
  mReflex.clear();
  for (std::uint32_t i = 0; i < n; ++i) {
    mIsReflex[i] = turn(i) <= 0;
    if (mIsReflex[i]) mReflex.push_back(i);
  }
  for (std::uint32_t i = 0; i < n; ++i) mIsEar[i] = isEar(i);

  std::uint32_t corner = 0;
  for (std::uint32_t left = n; left > 3; --left) {
    corner = pickCorner(corner);
    const std::uint32_t before = mPrevious[corner], after = mNext[corner];
    mTriangles.push_back({before, corner, after});
    mNext[before] = after;
    mPrevious[after] = before;
    mIsReflex[corner] = mIsEar[corner] = 0;
    classify(before);
    classify(after);
    corner = after;
  }
  mTriangles.push_back({mPrevious[corner], corner, mNext[corner]});
}

} // namespace volcaustic
