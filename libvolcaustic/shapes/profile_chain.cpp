#include "shapes/profile_chain.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

Vec2d difference(const Vec2d& a, const Vec2d& b) { return {a[0] - b[0], a[1] - b[1]}; }
double dot(const Vec2d& a, const Vec2d& b) { return a[0] * b[0] + a[1] * b[1]; }
double cross(const Vec2d& a, const Vec2d& b) { return a[0] * b[1] - a[1] * b[0]; }

void addArc(std::vector<ChainLink>& chain, const Vec2d& from, const Vec2d& to, double bulge) {
  if (std::abs(bulge) <= 1) {
    chain.push_back({from, bulge});
    return;
  }
  const Vec2d way = difference(to, from);
  const Vec2d middle{.5 * (from[0] + to[0] + bulge * way[1]), .5 * (from[1] + to[1] - bulge * way[0])};
  const double half = bulge / (1 + std::sqrt(1 + bulge * bulge)); // of half the angle
  chain.push_back({from, half});
  chain.push_back({middle, half});
}

/// At a point of a smooth curve: that of the circle through it and its neighbours, but turned no further than across
/// the way from or to either of them, so that no arc begins by going back.
Vec2d tangentAt(const Vec2d& before, const Vec2d& point, const Vec2d& after) {
  Vec2d in = difference(point, before), out = difference(after, point);
  const double inLength = std::hypot(in[0], in[1]), outLength = std::hypot(out[0], out[1]);
  for (int a = 0; a < 2; ++a) {
    in[a] /= inLength;
    out[a] /= outLength;
  }
  const double ratio = inLength / outLength, inWeight = ratio < 1 ? 1 : 1 / ratio, outWeight = ratio < 1 ? ratio : 1;
  Vec2d tangent{inWeight * in[0] + outWeight * out[0], inWeight * in[1] + outWeight * out[1]};
  for (const Vec2d& way : {in, out}) {
    const double back = std::min(dot(tangent, way), 0.0);
    tangent = {tangent[0] - back * way[0], tangent[1] - back * way[1]};
  }
  const double length = std::hypot(tangent[0], tangent[1]);
  if (length < 1e-12) return {-out[1], out[0]}; // it turns back the way it came
  return {tangent[0] / length, tangent[1] / length};
}

/// Two arcs that begin and end with given directions, both tangents as long as each other (Bolton, Biarc curves, 1975).
void addBiarc(std::vector<ChainLink>& chain, const Vec2d& from, const Vec2d& fromTangent, const Vec2d& to,
              const Vec2d& toTangent) {
  const Vec2d way = difference(to, from);
  const double square = dot(way, way), along = dot(way, fromTangent) + dot(way, toTangent);
  const double turn = std::max(0.0, 1 - dot(fromTangent, toTangent));
  const double length = square / (along + std::sqrt(along * along + 2 * turn * square));
  Vec2d joint{.5 * (from[0] + to[0]), .5 * (from[1] + to[1])};
  if (std::isfinite(length)) // it is not where the way is straight across both tangents: two half circles
    for (int a = 0; a < 2; ++a) joint[a] += .5 * length * (fromTangent[a] - toTangent[a]);
  // The angle between a tangent and a chord is half that of the arc.
  const Vec2d first = difference(joint, from), second = difference(to, joint);
  const double one = cross(fromTangent, first) / (std::hypot(first[0], first[1]) + dot(fromTangent, first));
  const double two = cross(second, toTangent) / (std::hypot(second[0], second[1]) + dot(toTangent, second));
  addArc(chain, from, joint, std::isfinite(one) ? one : 0);
  addArc(chain, joint, to, std::isfinite(two) ? two : 0);
}

std::vector<ChainLink> smoothChain(const std::vector<Vec2d>& points, ProfileUse use) {
  const std::size_t count = points.size();
  const auto onAxis = [&](const Vec2d& p) { return use == ProfileUse::Revolved && p[0] == 0; };
  std::vector<Vec2d> tangents(count);
  for (std::size_t i = 0; i < count; ++i)
    tangents[i] = onAxis(points[i]) ? Vec2d{1, 0}
                                    : tangentAt(points[(i + count - 1) % count], points[i], points[(i + 1) % count]);
  std::vector<ChainLink> chain;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t next = (i + 1) % count;
    if (onAxis(points[i]) && onAxis(points[next]))
      chain.push_back({points[i], 0, true});
    else // away from the axis, and back to it
      addBiarc(chain, points[i], tangents[i], points[next], onAxis(points[next]) ? Vec2d{-1, 0} : tangents[next]);
  }
  return chain;
}

} // namespace

std::vector<ChainLink> chainOf(const shapes::Profile& profile, ProfileUse use) {
  const std::vector<Vec2d>& points = profile.points;
  if (profile.smooth) return smoothChain(points, use);
  std::vector<ChainLink> chain;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2d &from = points[i], &to = points[(i + 1) % points.size()];
    const double bulge = profile.bulges.empty() ? 0 : profile.bulges[i];
    addArc(chain, from, to, bulge);
    chain.back().onAxis = use == ProfileUse::Revolved && bulge == 0 && from[0] == 0 && to[0] == 0;
  }
  return chain;
}

} // namespace volcaustic
