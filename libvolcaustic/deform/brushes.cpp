#include "deform/brushes.h"

#include "mesh/vector.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace volcaustic {

namespace {

// Taubin's pairs of steps, one that shrinks and one that swells: what changes over less than some ten edges fades, the
// rest stays. kPairs bring noise from vertex to vertex down to a thousandth.
constexpr double kShrink = .5, kSwell = -.53;
constexpr int kPairs = 10;

/// Of the points in the ball.
struct Touched {
  std::uint32_t point;
  double part; // of the brush's strength
};

std::vector<Touched> touchedBy(const Deformer& brush, const DeformSurface& surface) {
  std::vector<Touched> touched;
  for (std::uint32_t i = 0; i < surface.points.size(); ++i) {
    const double part = ballPart(brush, surface.points[i]);
    if (part < 1) touched.push_back({i, (1 - part) * (1 - part)});
  }
  return touched;
}

Vec3d scaled(const Vec3d& v, double factor) { return {v[0] * factor, v[1] * factor, v[2] * factor}; }
Vec3d sum(const Vec3d& a, const Vec3d& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

/// Zero for a vector that has no direction.
Vec3d unit(const Vec3d& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  return length > 0 && std::isfinite(length) ? scaled(v, 1 / length) : Vec3d{0, 0, 0};
}

/// Mean of the triangles' normals, each weighted by its angle at the point, so that it does not depend on how flat
/// parts are cut into triangles.
Vec3d pointNormal(std::uint32_t point, const std::vector<Vec3d>& points, const DeformSurface& surface) {
  Vec3d normal{0, 0, 0};
  for (const std::uint32_t t : surface.trianglesOf.of(point)) {
    const TriangleCorners& c = surface.triangles[t];
    const std::size_t k = c[0] == point ? 0 : c[1] == point ? 1 : 2;
    const Vec3d u = unit(difference(points[c[(k + 1) % 3]], points[point]));
    const Vec3d v = unit(difference(points[c[(k + 2) % 3]], points[point]));
    const Vec3d n = cross(u, v);
    normal = sum(normal, scaled(unit(n), std::atan2(std::sqrt(dot(n, n)), dot(u, v))));
  }
  return unit(normal);
}

void push(std::vector<Vec3d>& points, const std::vector<Touched>& touched, const Vec3d& way) {
  for (const Touched& t : touched) points[t.point] = sum(points[t.point], scaled(way, t.part));
}

/// Where a push of length one goes.
Vec3d pushDirection(const std::vector<Vec3d>& points, const DeformSurface& surface, const std::vector<Touched>& touched,
                    const Deformer& brush, const std::string& place) {
  const Vec3d given = unit(brush.direction);
  if (given != Vec3d{0, 0, 0} || touched.empty()) return given;
  Vec3d mean{0, 0, 0};
  double all = 0;
  for (const Touched& t : touched) {
    mean = sum(mean, scaled(pointNormal(t.point, points, surface), t.part));
    all += t.part;
  }
  constexpr double kLeast = 1e-6; // of the normals' lengths: below, what is left of them is rounding
  if (!(std::hypot(mean[0], mean[1], mean[2]) > kLeast * all))
    throw Error(ErrorKind::Usage, place + "the normals in the ball cancel out; give a direction, or a smaller radius");
  return scaled(unit(mean), -1);
}

void inflate(std::vector<Vec3d>& points, const DeformSurface& surface, const std::vector<Touched>& touched,
             double strength) {
  std::vector<Vec3d> normals;
  normals.reserve(touched.size());
  for (const Touched& t : touched) normals.push_back(pointNormal(t.point, points, surface));
  for (std::size_t i = 0; i < touched.size(); ++i)
    points[touched[i].point] = sum(points[touched[i].point], scaled(normals[i], strength * touched[i].part));
}

void twist(std::vector<Vec3d>& points, const std::vector<Touched>& touched, const Deformer& brush) {
  const Vec3d axis = unit(brush.direction);
  for (const Touched& t : touched) {
    const double angle = brush.strength * t.part * (std::numbers::pi / 180);
    const Vec3d d = difference(points[t.point], brush.center);
    const Vec3d along = scaled(axis, dot(axis, d)), across = difference(d, along);
    const Vec3d turned = sum(scaled(across, std::cos(angle)), scaled(cross(axis, across), std::sin(angle)));
    points[t.point] = sum(brush.center, sum(along, turned));
  }
}

/// One step of Taubin's for all touched points at once. Borders and points outside the ball stay.
void relax(std::vector<Vec3d>& points, const DeformSurface& surface, const std::vector<Touched>& touched,
           std::vector<Vec3d>& next, double factor) {
  for (std::size_t i = 0; i < touched.size(); ++i) {
    const std::uint32_t p = touched[i].point;
    next[i] = points[p];
    if (surface.onBorder[p] || surface.neighbours.of(p).empty()) continue;
    Vec3d mean{0, 0, 0};
    double weight = 0;
    for (std::uint32_t e = surface.neighbours.start[p]; e < surface.neighbours.start[p + 1]; ++e) {
      mean = sum(mean, scaled(points[surface.neighbours.entries[e]], surface.weights[e]));
      weight += surface.weights[e];
    }
    next[i] = sum(points[p], scaled(difference(scaled(mean, 1 / weight), points[p]), factor));
  }
  for (std::size_t i = 0; i < touched.size(); ++i) points[touched[i].point] = next[i];
}

void smooth(std::vector<Vec3d>& points, const DeformSurface& surface, const std::vector<Touched>& touched,
            double strength, const RunContext& ctx) {
  std::vector<Vec3d> fair = points, next(touched.size());
  for (int i = 0; i < kPairs; ++i) {
    ctx.throwIfCancelled();
    relax(fair, surface, touched, next, kShrink);
    relax(fair, surface, touched, next, kSwell);
  }
  for (const Touched& t : touched) {
    const Vec3d way = difference(fair[t.point], points[t.point]);
    points[t.point] = sum(points[t.point], scaled(way, strength * t.part));
  }
}

} // namespace

double ballPart(const Deformer& deformer, const Vec3d& rest) {
  const Vec3d d = scaled(difference(rest, deformer.center), 1 / deformer.radius);
  return dot(d, d);
}

void applyBrush(std::vector<Vec3d>& points, const DeformSurface& surface, const Deformer& brush,
                const std::string& place, const RunContext& ctx) {
  if (brush.strength == 0) return;
  const std::vector<Touched> touched = touchedBy(brush, surface);
  switch (brush.type) {
  case DeformerType::Push:
  case DeformerType::Pull: {
    const double way = brush.type == DeformerType::Push ? brush.strength : -brush.strength;
    return push(points, touched, scaled(pushDirection(points, surface, touched, brush, place), way));
  }
  case DeformerType::Inflate:
    return inflate(points, surface, touched, brush.strength);
  case DeformerType::Twist:
    return twist(points, touched, brush);
  case DeformerType::Smooth:
    return smooth(points, surface, touched, brush.strength, ctx);
  case DeformerType::Handle:
    return;
  }
}

} // namespace volcaustic
