#include "core/range_check.h"
#include "shapes/affine.h"
#include "volcaustic/error.h"
#include "volcaustic/shape_fields.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

[[noreturn]] void fail(const std::string& type, const std::string& what) {
  throw Error(ErrorKind::Input, type + ": " + what);
}

void requirePlacement(const char* type, const Placement& placement) {
  for (const double s : placement.scale)
    if (s == 0) fail(type, "scale is 0 along an axis, which flattens it; give another number");
  const double d = determinant(affine(placement));
  if (!std::isfinite(d) || d == 0) fail(type, "its placement flattens it or has no end; take other scales and shears");
}

bool isZero(const Vec3d& v) { return v[0] == 0 && v[1] == 0 && v[2] == 0; }

/// What ranges alone do not say of a kind.
struct Rules {
  const char* type;

  void operator()(const shapes::Quadric& s) const {
    const auto& c = s.coefficients;
    if (std::all_of(c.begin(), c.end() - 1, [](double v) { return v == 0; }))
      fail(type, "the coefficients of all powers of x, y and z are 0, so there is no surface; give one that is not");
  }
  void operator()(const shapes::Plane& s) const { requireDirection(s.normal, "normal"); }
  void operator()(const shapes::Slab& s) const { requireDirection(s.normal, "normal"); }
  void operator()(const shapes::Hyperboloid& s) const {
    if (s.sheets == 2 && s.height <= 2 * s.waist)
      fail(type,
           "two sheets whose apexes are at `waist` are not reached by its height; give more than twice the waist");
  }
  void operator()(const shapes::Cuboid& s) const {
    if (s.rounding > .5 * *std::min_element(s.size.begin(), s.size.end()))
      fail(type, "rounding is more than half the shortest side; give a smaller one");
  }
  void operator()(const shapes::Revolution& s) const {
    requireProfile(s.profile);
    for (const auto& point : s.profile.points)
      if (point[0] < 0) fail(type, "points: a distance from the axis is below 0; give 0 or more");
    const bool lines = s.profile.smooth || isStraight(s.profile);
    if (lines && std::all_of(s.profile.points.begin(), s.profile.points.end(), [](auto& p) { return p[0] == 0; }))
      fail(type, "points: all are on the axis, which encloses nothing; add one at a distance from it");
  }
  void operator()(const shapes::Extrusion& s) const { requireProfile(s.profile); }
  void operator()(const shapes::WaveDisplacement& s) const {
    if (!s.radial) requireDirection(s.direction, "direction");
  }
  void operator()(const shapes::Array& s) const { requirePlacement(type, s.step); }
  void operator()(const shapes::Instances& s) const {
    if (s.placements.empty()) fail(type, "placements: there is none; give one for each copy");
    for (const Placement& placement : s.placements) requirePlacement(type, placement);
  }
  template <class Other>
  void operator()(const Other&) const {}

private:
  void requireDirection(const Vec3d& v, const char* name) const {
    if (isZero(v)) fail(type, std::string(name) + " is 0 0 0, which is no direction; give another");
  }
  static bool isStraight(const shapes::Profile& p) {
    return std::all_of(p.bulges.begin(), p.bulges.end(), [](double bulge) { return bulge == 0; });
  }
  void requireProfile(const shapes::Profile& p) const {
    constexpr std::size_t kMostPoints = 65536;
    if (p.points.size() < 2 || p.points.size() > kMostPoints)
      fail(type, "points: needs 2 to 65536 of them, got " + std::to_string(p.points.size()));
    if (!p.bulges.empty() && p.bulges.size() != p.points.size())
      fail(type, "bulges: needs one for each of " + std::to_string(p.points.size()) + " points or none, got " +
                     std::to_string(p.bulges.size()));
    if (!p.smooth && isStraight(p) && p.points.size() < 3)
      fail(type, "points: two of them and straight lines enclose nothing; add a point");
    for (std::size_t i = 0; i < p.points.size(); ++i)
      if (p.points[i] == p.points[(i + 1) % p.points.size()])
        fail(type, "points: " + std::to_string(i) + " and the one after it are the same; leave one out");
  }
};

void requireParts(const char* type, const ShapeNode& node) {
  const std::size_t count = node.parts.size();
  const ShapeParts wanted = partsOf(node.kind);
  if (wanted == ShapeParts::None && count > 0) fail(type, "is a solid, which has no parts; leave them out");
  if (wanted == ShapeParts::One && count != 1)
    fail(type, "works on one part, got " + std::to_string(count) + "; unite several first");
  if (wanted == ShapeParts::Many && count == 0) fail(type, "has no parts; give one or more");
  for (const Shape& part : node.parts)
    if (part.empty()) fail(type, "a part of it is the empty shape; leave it out");
}

void requireDeviations(const char* type, const ShapeNode& node) {
  if (node.deviations.empty()) return;
  if (!isQuadric(node.kind)) fail(type, "is no quadric, which alone has deviations; give them to a quadric");
  for (const Deviation& d : node.deviations) {
    if (!std::isfinite(d.weight) || std::abs(d.weight) > 1e9)
      fail(type, "the weight of a deviation is out of range; give a value from -1e9 to 1e9");
    if (d.region.empty() || !isQuadric(d.region.node().kind))
      fail(type, "the region of a deviation is no quadric; give one of the types from quadric to hyperboloid");
    if (!d.region.node().deviations.empty())
      fail(type, "the region of a deviation has deviations itself, which have no meaning there; leave them out");
  }
}

} // namespace

void requireValid(const ShapeNode& node) {
  const char* type = kShapeTypes[node.kind.index()];
  ShapeNode copy = node; // describe() hands out references that a reader may write to
  const RangeCheck ranges(ErrorKind::Input, type);
  std::visit([&](auto& kind) { describe(ranges, kind); }, copy.kind);
  describe(ranges, copy.placement);
  requirePlacement(type, node.placement);
  std::visit(Rules{type}, node.kind);
  requireParts(type, node);
  requireDeviations(type, node);
}

} // namespace volcaustic
