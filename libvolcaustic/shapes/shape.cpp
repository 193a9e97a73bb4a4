#include "volcaustic/shape.h"

#include "core/field_hash.h"
#include "shapes/stored_shape.h"
#include "volcaustic/error.h"
#include "volcaustic/shape_fields.h"

#include <algorithm>
#include <utility>

namespace volcaustic {

namespace {

constexpr int kDeepest = 1000;

std::uint64_t hashOf(const ShapeNode& node) {
  Hash hash;
  hash.text(node.name).value(node.kind.index());
  std::visit([&](const auto& kind) { addFields(hash, kind); }, node.kind);
  addFields(hash, node.placement);
  hash.value(node.deviations.size());
  for (const Deviation& d : node.deviations) hash.value(shapeHash(d.region)).value(d.weight);
  hash.value(node.parts.size());
  for (const Shape& part : node.parts) hash.value(shapeHash(part));
  return hash.digest();
}

std::uint64_t copiesOf(const shapes::Kind& kind) {
  if (const auto* array = std::get_if<shapes::Array>(&kind)) return static_cast<std::uint64_t>(array->count);
  if (const auto* instances = std::get_if<shapes::Instances>(&kind)) return instances->placements.size();
  return 1;
}

std::uint64_t pointsOf(const shapes::Kind& kind) {
  if (const auto* revolution = std::get_if<shapes::Revolution>(&kind)) return revolution->profile.points.size();
  if (const auto* extrusion = std::get_if<shapes::Extrusion>(&kind)) return extrusion->profile.points.size();
  return 0;
}

/// A quadric that ends is cut out by planes; everything else is one instruction of its own and its parts. Some sixteen
/// points of a profile, of which every copy has its own, take the memory of one.
std::uint64_t sizeOf(const ShapeNode& node) {
  constexpr std::uint64_t kOwn = 4;
  std::uint64_t size = kOwn + node.deviations.size() + pointsOf(node.kind) / 16;
  for (const Shape& part : node.parts) size += StoredShape::of(part).size;
  return std::min(size * copiesOf(node.kind) + copiesOf(node.kind), StoredShape::kLargest + 1);
}

Shape simple(shapes::Kind kind) { return Shape(ShapeNode{{}, std::move(kind), {}, {}, {}}); }
Shape combined(shapes::Kind kind, std::vector<Shape> parts) {
  return Shape(ShapeNode{{}, std::move(kind), {}, {}, std::move(parts)});
}

bool isPlain(const Placement& p) { return affine(p) == kIdentity; }

/// a op b, without a node more where `a` came from the same operator: long chains stay flat.
template <class Operation>
Shape chained(const Shape& a, const Shape& b) {
  const auto* operation = std::get_if<Operation>(&a.node().kind);
  if (operation && operation->blend == 0 && a.node().name.empty() && isPlain(a.node().placement)) {
    std::vector<Shape> parts = a.node().parts;
    parts.push_back(b);
    return combined(Operation{}, std::move(parts));
  }
  return combined(Operation{}, {a, b});
}

} // namespace

Shape::Shape(ShapeNode node) {
  requireValid(node);
  int depth = 0;
  for (const Shape& part : node.parts) depth = std::max(depth, part.mStored->depth);
  if (depth >= kDeepest)
    throw Error(ErrorKind::Input, std::string(kShapeTypes[node.kind.index()]) +
                                      ": shapes nested more than 1000 deep; put more parts into one operation");
  const std::uint64_t hash = hashOf(node), size = sizeOf(node);
  mStored = std::make_shared<const StoredShape>(StoredShape{std::move(node), depth + 1, size, hash});
}

const ShapeNode& Shape::node() const { return mStored->node; }
std::uint64_t shapeHash(const Shape& shape) { return shape.empty() ? 0 : StoredShape::of(shape).hash; }

Shape Shape::quadric(const std::array<double, 10>& coefficients) { return simple(shapes::Quadric{coefficients}); }
Shape Shape::plane(const Vec3d& normal, double offset) { return simple(shapes::Plane{normal, offset}); }
Shape Shape::slab(const Vec3d& normal, double thickness) { return simple(shapes::Slab{normal, thickness}); }
Shape Shape::sphere(double radius) { return simple(shapes::Sphere{radius}); }
Shape Shape::ellipsoid(const Vec3d& semiAxes) { return simple(shapes::Ellipsoid{semiAxes}); }
Shape Shape::cylinder(double radius, double height) { return simple(shapes::Cylinder{{radius, radius}, height}); }
Shape Shape::cone(double radius, double height) { return simple(shapes::Cone{radius, height}); }
Shape Shape::paraboloid(double radius, double height) { return simple(shapes::Paraboloid{radius, height}); }
Shape Shape::hyperboloid(double waist, double rim, double height) {
  return simple(shapes::Hyperboloid{1, waist, rim, height});
}
Shape Shape::cuboid(const Vec3d& size, double rounding) { return simple(shapes::Cuboid{size, rounding}); }
Shape Shape::torus(double majorRadius, double minorRadius) { return simple(shapes::Torus{majorRadius, minorRadius}); }
Shape Shape::capsule(const Vec3d& from, const Vec3d& to, double radius) {
  return simple(shapes::Capsule{from, to, radius});
}
Shape Shape::revolution(shapes::Profile profile) { return simple(shapes::Revolution{std::move(profile)}); }
Shape Shape::extrusion(shapes::Profile profile, double height) {
  return simple(shapes::Extrusion{std::move(profile), height});
}

Shape Shape::bulge(const Shape& region, double weight) const {
  if (empty()) throw Error(ErrorKind::Input, "bulge: the empty shape has none; start from a quadric");
  ShapeNode changed = node();
  changed.deviations.push_back({region, weight});
  return Shape(std::move(changed));
}

Shape Shape::unite(std::vector<Shape> parts, double blend) { return combined(shapes::Union{blend}, std::move(parts)); }
Shape Shape::intersect(std::vector<Shape> parts, double blend) {
  return combined(shapes::Intersection{blend}, std::move(parts));
}
Shape Shape::subtract(std::vector<Shape> parts, double blend) {
  return combined(shapes::Difference{blend}, std::move(parts));
}
Shape Shape::offset(double distance) const { return combined(shapes::Offset{distance}, {*this}); }
Shape Shape::shell(double thickness) const { return combined(shapes::Shell{thickness}, {*this}); }
Shape Shape::displaced(const shapes::NoiseDisplacement& noise) const { return combined(noise, {*this}); }
Shape Shape::displaced(const shapes::WaveDisplacement& waves) const { return combined(waves, {*this}); }
Shape Shape::repeated(int count, const Placement& step, double blend) const {
  return combined(shapes::Array{count, step, blend}, {*this});
}
Shape Shape::copied(std::vector<Placement> placements, double blend) const {
  return combined(shapes::Instances{std::move(placements), blend}, {*this});
}

Shape Shape::placed(const Placement& placement) const {
  if (empty()) return *this;
  // A node that was placed before is a part of a new one: placements do not multiply into numbers of the same kind.
  ShapeNode changed = isPlain(node().placement) ? node() : ShapeNode{{}, shapes::Union{}, {}, {}, {*this}};
  changed.placement = placement;
  return Shape(std::move(changed));
}
Shape Shape::translated(const Vec3d& by) const {
  Placement p;
  p.translate = by;
  return placed(p);
}
Shape Shape::rotated(const Vec3d& degrees) const {
  Placement p;
  p.rotate = degrees;
  return placed(p);
}
Shape Shape::scaled(double factor) const {
  Placement p;
  p.scale = {factor, factor, factor};
  return placed(p);
}
Shape Shape::named(std::string name) const {
  if (empty()) return *this;
  ShapeNode changed = node();
  changed.name = std::move(name);
  return Shape(std::move(changed));
}

Shape operator|(const Shape& a, const Shape& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  return chained<shapes::Union>(a, b);
}
Shape operator&(const Shape& a, const Shape& b) {
  if (a.empty() || b.empty()) return {};
  return chained<shapes::Intersection>(a, b);
}
Shape operator-(const Shape& a, const Shape& b) {
  if (a.empty() || b.empty()) return a;
  return chained<shapes::Difference>(a, b);
}
Shape operator~(const Shape& a) { return combined(shapes::Complement{}, {a}); }

} // namespace volcaustic
