#include "deform/triangle_pair.h"

#include "deform/exact_sign.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

struct Triangle {
  Vec3d a, b, c;
};

/// Two coordinates in which a triangle keeps its area, and the way it turns there.
struct Projection {
  int u, v, turning;
};
Projection projectionOf(const Triangle& t) {
  for (const auto& [u, v] : {std::array{0, 1}, {1, 2}, {2, 0}})
    if (const int turning = turn(t.a, t.b, t.c, u, v); turning != 0) return {u, v, turning};
  return {0, 1, 0};
}

/// p in the plane of the triangle.
bool holds(const Triangle& t, const Vec3d& p, const Projection& on) {
  const auto outside = [&](const Vec3d& from, const Vec3d& to) { return turn(from, to, p, on.u, on.v) == -on.turning; };
  return !outside(t.a, t.b) && !outside(t.b, t.c) && !outside(t.c, t.a);
}

/// For four points on a line: whether the pieces pq and rs meet.
bool overlapOnLine(const Vec3d& p, const Vec3d& q, const Vec3d& r, const Vec3d& s) {
  for (std::size_t k = 0; k < 3; ++k)
    if (std::max(p[k], q[k]) < std::min(r[k], s[k]) || std::max(r[k], s[k]) < std::min(p[k], q[k])) return false;
  return true;
}

/// pq and rs in one plane.
bool meetInPlane(const Vec3d& p, const Vec3d& q, const Vec3d& r, const Vec3d& s, const Projection& on) {
  const int pSide = turn(r, s, p, on.u, on.v), qSide = turn(r, s, q, on.u, on.v);
  if (pSide * qSide > 0) return false;
  if (pSide == 0 && qSide == 0) return overlapOnLine(p, q, r, s);
  return turn(p, q, r, on.u, on.v) * turn(p, q, s, on.u, on.v) <= 0;
}

/// pq in the plane of the triangle.
bool meetsInPlane(const Triangle& t, const Vec3d& p, const Vec3d& q) {
  const Projection on = projectionOf(t);
  return holds(t, p, on) || holds(t, q, on) || meetInPlane(p, q, t.a, t.b, on) || meetInPlane(p, q, t.b, t.c, on) ||
         meetInPlane(p, q, t.c, t.a, on);
}

/// Whether the segment pq and the triangle have a point in common. The sides are those of its ends.
bool meets(const Triangle& t, const Vec3d& p, const Vec3d& q, int pSide, int qSide) {
  if (pSide * qSide > 0) return false;
  if (pSide == 0 && qSide == 0) return meetsInPlane(t, p, q);
  const int ab = orientation(p, q, t.a, t.b), bc = orientation(p, q, t.b, t.c);
  if (ab * bc < 0) return false;
  const int ca = orientation(p, q, t.c, t.a);
  return ab * ca >= 0 && bc * ca >= 0;
}

int sideOf(const Triangle& t, const Vec3d& p) { return orientation(t.a, t.b, t.c, p); }

/// Whether an edge of `s` has `t` on its other side where both are seen along an axis, but for their shared point `a`
/// if there is one. Then they have nothing else in common. Settles nearly all neighbours, also those in one plane, for
/// which the sides of planes would all have to be found exactly.
bool edgeBetween(const Triangle& s, const Triangle& t, bool sharePoint) {
  const Projection on = projectionOf(s);
  const auto between = [&](const Vec3d& from, const Vec3d& to) {
    const auto beyond = [&](const Vec3d& p) { return turn(from, to, p, on.u, on.v) == -on.turning; };
    return beyond(t.b) && beyond(t.c) && (sharePoint || beyond(t.a));
  };
  return between(s.a, s.b) || between(s.c, s.a) || (!sharePoint && between(s.b, s.c));
}

bool meetApart(const Triangle& s, const Triangle& t) {
  const std::array side{sideOf(t, s.a), sideOf(t, s.b), sideOf(t, s.c)};
  if (side[0] * side[1] > 0 && side[1] * side[2] > 0) return false;
  const std::array otherSide{sideOf(s, t.a), sideOf(s, t.b), sideOf(s, t.c)};
  if (otherSide[0] * otherSide[1] > 0 && otherSide[1] * otherSide[2] > 0) return false;
  return meets(t, s.a, s.b, side[0], side[1]) || meets(t, s.b, s.c, side[1], side[2]) ||
         meets(t, s.c, s.a, side[2], side[0]) || meets(s, t.a, t.b, otherSide[0], otherSide[1]) ||
         meets(s, t.b, t.c, otherSide[1], otherSide[2]) || meets(s, t.c, t.a, otherSide[2], otherSide[0]);
}

/// Of triangles that share their point `a` alone: from it, every further common point lies on a ray that leaves one of
/// them through the edge opposite, still inside the other.
bool meetBeyondPoint(const Triangle& s, const Triangle& t) {
  return meets(t, s.b, s.c, sideOf(t, s.b), sideOf(t, s.c)) || meets(s, t.b, t.c, sideOf(s, t.b), sideOf(s, t.c));
}

/// Of triangles that share their edge ab: both planes hold its line, so only in one plane is there more.
bool meetBeyondEdge(const Triangle& s, const Triangle& t) {
  if (sideOf(s, t.c) != 0) return false;
  const Projection on = projectionOf(s);
  return turn(s.a, s.b, t.c, on.u, on.v) == on.turning;
}

} // namespace

bool isFlat(const TriangleCorners& t, const std::vector<Vec3d>& points) {
  return hasRepeatedCorner(t) || projectionOf({points[t[0]], points[t[1]], points[t[2]]}).turning == 0;
}

bool crossEachOther(const TriangleCorners& s, const TriangleCorners& t, const std::vector<Vec3d>& points) {
  // Both with shared corners first, in the same order.
  TriangleCorners a = s, b = t;
  std::size_t shared = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto found = std::find(b.begin() + static_cast<std::ptrdiff_t>(shared), b.end(), a[i]);
    if (found == b.end()) continue;
    std::swap(*found, b[shared]);
    std::swap(a[i], a[shared]);
    ++shared;
  }
  const Triangle first{points[a[0]], points[a[1]], points[a[2]]}, second{points[b[0]], points[b[1]], points[b[2]]};
  if (shared < 2 && (edgeBetween(first, second, shared == 1) || edgeBetween(second, first, shared == 1))) return false;
  switch (shared) {
  case 0:
    return meetApart(first, second);
  case 1:
    return meetBeyondPoint(first, second);
  case 2:
    return meetBeyondEdge(first, second);
  default:
    return true;
  }
}

} // namespace volcaustic
