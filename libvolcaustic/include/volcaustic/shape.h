/// \file shape.h
/// Functional objects: quadrics with deviation functions, and what operations make of them (Vyatkin & Dolgovesov,
/// Volume-oriented visualization of caustics and dynamic refractive objects with complex material properties in real
/// time, section 1).
///
/// A shape is a function of space, positive inside. Every node's value is like a distance: in world units, zero on the
/// surface, where its gradient has length one (but on edges and at apexes). So blend radii, offsets and displacements
/// are lengths, true to first order at the surface. Away from it the value is no distance.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/placement.h"
#include "volcaustic/types.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace volcaustic {

struct ShapeNode;
struct StoredShape;

/// The kinds of nodes. Lengths are in the node's own space, before its placement.
namespace shapes {

/// q = a x^2 + b y^2 + c z^2 + d xy + e yz + f zx + g x + h y + i z + j, positive inside.
struct Quadric {
  std::array<double, 10> coefficients{-1, -1, -1, 0, 0, 0, 0, 0, 0, 1};
};
/// The half-space beneath a plane: q = offset - normal.p for a normal of length one.
struct Plane {
  Vec3d normal{0, 0, 1}; ///< outwards, of any length
  double offset = 0;     ///< of the plane from the origin, along the normal
};
/// Between two planes at thickness/2 on both sides of the origin: q = 1 - (2 normal.p / thickness)^2.
struct Slab {
  Vec3d normal{0, 0, 1};
  double thickness = 1;
};
/// q = 1 - (x^2 + y^2 + z^2)/radius^2.
struct Sphere {
  double radius = 1;
};
/// q = 1 - (x/a)^2 - (y/b)^2 - (z/c)^2.
struct Ellipsoid {
  Vec3d semiAxes{1, 1, 1};
};
/// Around the z axis, for |z| <= height/2: q = 1 - (x/a)^2 - (y/b)^2.
struct Cylinder {
  std::array<double, 2> radii{1, 1};
  double height = 2;
  bool endless = false; ///< the quadric alone, without its ends
};
/// Around the z axis, from its base in z = 0 to its apex: q = (1 - z/height)^2 - (x^2 + y^2)/radius^2.
struct Cone {
  double radius = 1, height = 2;
  bool endless = false; ///< the quadric alone: two cones that meet in the apex
};
/// A bowl around the z axis, from its apex at the origin to its rim in z = height: q = z/height - (x^2 + y^2)/radius^2.
struct Paraboloid {
  double radius = 1, height = 1;
  bool endless = false;
};
/// Around the z axis, for |z| <= height/2, where its radius is `rim`. Of one sheet it is `waist` wide at z = 0:
/// q = 1 + (rim^2/waist^2 - 1) (2z/height)^2 - (x^2 + y^2)/waist^2. Two sheets have their apexes at z = +-waist:
/// q = (z^2/waist^2 - 1) - ((height/2)^2/waist^2 - 1) (x^2 + y^2)/rim^2.
struct Hyperboloid {
  int sheets = 1;
  double waist = 0.5, rim = 1, height = 2;
  bool endless = false;
};
/// A cuboid around the origin.
struct Cuboid {
  Vec3d size{1, 1, 1};
  double rounding = 0; ///< radius of its edges; at most half its shortest side
};
/// Around the z axis.
struct Torus {
  double majorRadius = 1, minorRadius = 0.25;
};
/// All points within `radius` of a straight line between two points.
struct Capsule {
  Vec3d from{0, 0, 0}, to{0, 0, 1};
  double radius = 0.25;
};
/// A closed curve in a plane, from point to point and back to the first.
struct Profile {
  std::vector<std::array<double, 2>> points;
  /// Of the arc from each point to the next: tangent of a quarter of its angle, 0 for a straight line, positive where
  /// it bulges to the right of the way. Empty: all are straight.
  std::vector<double> bulges;
  bool smooth = false; ///< a smooth curve of arcs through the points in place of `bulges`
};
/// A profile of (distance from the z axis, z) turned about that axis. Points lie at distances of 0 and more.
struct Revolution {
  Profile profile;
};
/// A profile of (x, y) for |z| <= height/2.
struct Extrusion {
  Profile profile;
  double height = 1;
};

/// Union, or with a blend a smooth one: surfaces that come within `blend` of each other merge into one.
struct Union {
  double blend = 0;
};
struct Intersection {
  double blend = 0;
};
/// The first part without all the others.
struct Difference {
  double blend = 0;
};
/// Outside for inside.
struct Complement {};
/// Grown by a distance, or shrunk where that is negative.
struct Offset {
  double distance = 0;
};
/// What lies within `thickness` of the surface, on its inside.
struct Shell {
  double thickness = 0.1;
};
/// The surface moved outwards by a smooth noise between -amplitude and amplitude.
struct NoiseDisplacement {
  double amplitude = 0.1;
  double size = 1; ///< of its largest lumps
  int octaves = 1; ///< each half as large and `gain` times as high as the one before
  double gain = 0.5;
  Vec3d drift{0, 0, 0}; ///< where the noise has moved to
  int seed = 0;
};
/// The surface moved outwards by amplitude * cos(2 pi (direction.p / wavelength - phase)), or by rings around the
/// origin where `radial`, as far apart.
struct WaveDisplacement {
  double amplitude = 0.1, wavelength = 1;
  double phase = 0; ///< in turns
  Vec3d direction{1, 0, 0};
  bool radial = false; ///< rings around the z axis; `direction` has no meaning then
};
/// `count` copies, the first where it is, each next one placed by `step` from the one before.
struct Array {
  int count = 2;
  Placement step;
  double blend = 0;
};
/// A copy at each of the placements.
struct Instances {
  std::vector<Placement> placements;
  double blend = 0;
};

using Kind = std::variant<Quadric, Plane, Slab, Sphere, Ellipsoid, Cylinder, Cone, Paraboloid, Hyperboloid, Cuboid,
                          Torus, Capsule, Revolution, Extrusion, Union, Intersection, Difference, Complement, Offset,
                          Shell, NoiseDisplacement, WaveDisplacement, Array, Instances>;

} // namespace shapes

/// A functional object. A handle of one pointer to nodes that never change: copies are cheap and safe to share.
class VOLCAUSTIC_API Shape {
public:
  Shape() = default; ///< nothing: no point is inside
  /// \throws Error(Input) for what requireValid() does not take
  explicit Shape(ShapeNode node);

  [[nodiscard]] bool empty() const { return !mStored; }
  [[nodiscard]] const ShapeNode& node() const; ///< of a shape that is not empty

  static Shape quadric(const std::array<double, 10>& coefficients);
  static Shape plane(const Vec3d& normal, double offset = 0);
  static Shape slab(const Vec3d& normal, double thickness);
  static Shape sphere(double radius);
  static Shape ellipsoid(const Vec3d& semiAxes);
  static Shape cylinder(double radius, double height);
  static Shape cone(double radius, double height);
  static Shape paraboloid(double radius, double height);
  static Shape hyperboloid(double waist, double rim, double height);
  static Shape cuboid(const Vec3d& size, double rounding = 0);
  static Shape torus(double majorRadius, double minorRadius);
  static Shape capsule(const Vec3d& from, const Vec3d& to, double radius);
  static Shape revolution(shapes::Profile profile);
  static Shape extrusion(shapes::Profile profile, double height);

  /// Adds the deviation function weight * max(0, q)^3 to a quadric, q being that of `region`, another quadric: it
  /// bulges where the weight is positive and has a dent where it is negative (equations (1) and (2)).
  [[nodiscard]] Shape bulge(const Shape& region, double weight = 1) const;

  static Shape unite(std::vector<Shape> parts, double blend = 0);
  static Shape intersect(std::vector<Shape> parts, double blend = 0);
  static Shape subtract(std::vector<Shape> parts, double blend = 0); ///< from the first

  [[nodiscard]] Shape offset(double distance) const;
  [[nodiscard]] Shape shell(double thickness) const;
  [[nodiscard]] Shape displaced(const shapes::NoiseDisplacement& noise) const;
  [[nodiscard]] Shape displaced(const shapes::WaveDisplacement& waves) const;
  [[nodiscard]] Shape repeated(int count, const Placement& step, double blend = 0) const;
  [[nodiscard]] Shape copied(std::vector<Placement> placements, double blend = 0) const;

  [[nodiscard]] Shape placed(const Placement& placement) const;
  [[nodiscard]] Shape translated(const Vec3d& by) const;
  [[nodiscard]] Shape rotated(const Vec3d& degrees) const; ///< about x, y and z in that order
  [[nodiscard]] Shape scaled(double factor) const;
  /// The name of a part: of the group of its triangles.
  [[nodiscard]] Shape named(std::string name) const;

private:
  friend struct StoredShape;
  std::shared_ptr<const StoredShape> mStored;
};

VOLCAUSTIC_API Shape operator|(const Shape& a, const Shape& b); ///< union
VOLCAUSTIC_API Shape operator&(const Shape& a, const Shape& b); ///< intersection
VOLCAUSTIC_API Shape operator-(const Shape& a, const Shape& b); ///< difference
VOLCAUSTIC_API Shape operator~(const Shape& a);                 ///< complement

/// weight * max(0, q)^3, where q is the function of `region`, a quadric as its definition above gives it, endless.
struct Deviation {
  Shape region;
  double weight = 1;
};

/// A node of a shape, as plain data.
struct ShapeNode {
  std::string name; ///< of its triangles' group, unless a part of it has a name of its own
  shapes::Kind kind;
  Placement placement;
  std::vector<Deviation> deviations; ///< of quadrics (Quadric to Hyperboloid)
  std::vector<Shape> parts;          ///< none for solids; one or more for set operations; one for all others
};

/// What a node may be: finite numbers in range, as many parts as its kind takes, not empty, and deviations of quadrics
/// by quadrics only. \throws Error(Input) "cone: radius must be ...".
VOLCAUSTIC_API void requireValid(const ShapeNode& node);

struct Interval {
  double low = 0, high = 0;
};

/// A shape compiled for evaluation. Safe to use from several threads.
class VOLCAUSTIC_API ShapeField {
public:
  /// \throws Error(Input) for a shape of more than a million nodes once its copies are written out
  explicit ShapeField(const Shape& shape);
  ~ShapeField();
  ShapeField(ShapeField&&) noexcept;
  ShapeField& operator=(ShapeField&&) noexcept;

  /// \param pWorld points; \param values as many results, positive inside
  void values(std::span<const Vec3d> pWorld, std::span<double> values) const;
  /// \param gradients as many results, per world unit; on an edge, of one of the surfaces that meet
  void gradients(std::span<const Vec3d> pWorld, std::span<Vec3d> gradients) const;
  /// Index into partNames() of the part that makes the surface next to each point.
  void parts(std::span<const Vec3d> pWorld, std::span<std::uint32_t> parts) const;
  /// Holds the values of all points of the box, and where it can be seen by this arithmetic little more.
  [[nodiscard]] Interval bound(const Box& box) const;
  /// A box that holds the whole shape and is little larger; of a shape without an inside it may be a box of zeros.
  /// \throws Error(Input) for a shape without end
  [[nodiscard]] Box bounds() const;
  /// Empty, for what has no name, and then the names that occur, in order of appearance.
  [[nodiscard]] const std::vector<std::string>& partNames() const;

private:
  std::unique_ptr<const class ShapeProgram> mProgram;
};

/// Of everything that decides a shape's values and names.
VOLCAUSTIC_API std::uint64_t shapeHash(const Shape& shape);

} // namespace volcaustic
