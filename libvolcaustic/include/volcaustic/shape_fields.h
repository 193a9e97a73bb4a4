/// \file shape_fields.h
/// The one description of what nodes of shapes hold (as options.h is of options): the JSON form, its schema, the tables
/// in docs/ and hashes are all readers of it.
#pragma once

#include "volcaustic/options.h"
#include "volcaustic/shape.h"

namespace volcaustic {

/// Of the alternatives of shapes::Kind, in order: "type" of a node in JSON.
inline constexpr std::array<const char*, std::variant_size_v<shapes::Kind>> kShapeTypes{
    "quadric",     "plane",      "slab",   "sphere",  "ellipsoid",  "cylinder",  "cone",  "paraboloid",
    "hyperboloid", "cuboid",     "torus",  "capsule", "revolution", "extrusion", "union", "intersection",
    "difference",  "complement", "offset", "shell",   "noise",      "waves",     "array", "instances"};

/// How many parts a kind of node takes.
enum class ShapeParts { None, One, Many };
constexpr ShapeParts partsOf(const shapes::Kind& kind) {
  const std::size_t i = kind.index();
  return i < 14 ? ShapeParts::None : i < 17 ? ShapeParts::Many : ShapeParts::One;
}
/// Whether it is a quadric: takes deviations, and is taken as the region of one.
constexpr bool isQuadric(const shapes::Kind& kind) { return kind.index() < 9; }

inline constexpr double kSmallestLength = 1e-9, kGreatestLength = 1e9;
inline constexpr FieldDoc kBlendDoc{"distance within which surfaces merge into one; 0 leaves a crease", "world", 0,
                                    kGreatestLength};

constexpr FieldDoc lengthDoc(const char* text) { return {text, "world", kSmallestLength, kGreatestLength}; }
inline constexpr FieldDoc kEndlessDoc{"the quadric alone, without the planes that end it"};

namespace shapes {

template <class Visitor>
void describe(Visitor&& visit, Quadric& s) {
  visit("coefficients", s.coefficients,
        FieldDoc{"of x2, y2, z2, xy, yz, zx, x, y, z and 1; inside is where their sum is positive", "1", -1e18, 1e18});
}
template <class Visitor>
void describe(Visitor&& visit, Plane& s) {
  visit("normal", s.normal, FieldDoc{"outwards, of any length: all behind it is inside", "1", -kHuge, kHuge});
  visit("offset", s.offset, FieldDoc{"of the plane from the origin, along the normal", "world", -1e9, 1e9});
}
template <class Visitor>
void describe(Visitor&& visit, Slab& s) {
  visit("normal", s.normal, FieldDoc{"of both planes, of any length", "1", -kHuge, kHuge});
  visit("thickness", s.thickness, lengthDoc("distance of the planes, the origin between them"));
}
template <class Visitor>
void describe(Visitor&& visit, Sphere& s) {
  visit("radius", s.radius, lengthDoc("of the sphere, around the origin"));
}
template <class Visitor>
void describe(Visitor&& visit, Ellipsoid& s) {
  visit("semiAxes", s.semiAxes, lengthDoc("along x, y and z"));
}
template <class Visitor>
void describe(Visitor&& visit, Cylinder& s) {
  visit("radii", s.radii, lengthDoc("along x and y; the z axis is its axis"));
  visit("height", s.height, lengthDoc("from end to end, the origin in the middle"));
  visit("endless", s.endless, kEndlessDoc);
}
template <class Visitor>
void describe(Visitor&& visit, Cone& s) {
  visit("radius", s.radius, lengthDoc("of the base, in the plane z = 0"));
  visit("height", s.height, lengthDoc("of the apex above the base"));
  visit("endless", s.endless, kEndlessDoc);
}
template <class Visitor>
void describe(Visitor&& visit, Paraboloid& s) {
  visit("radius", s.radius, lengthDoc("of the rim"));
  visit("height", s.height, lengthDoc("of the rim above the apex, which is the origin"));
  visit("endless", s.endless, kEndlessDoc);
}
template <class Visitor>
void describe(Visitor&& visit, Hyperboloid& s) {
  visit("sheets", s.sheets, FieldDoc{"1: a waist; 2: a gap", "", 1, 2});
  visit("waist", s.waist, lengthDoc("radius at z = 0; of two sheets, how far their apexes are from z = 0"));
  visit("rim", s.rim, lengthDoc("radius at both ends"));
  visit("height", s.height,
        lengthDoc("from end to end, the origin in the middle; of two sheets above twice the waist"));
  visit("endless", s.endless, kEndlessDoc);
}
template <class Visitor>
void describe(Visitor&& visit, Cuboid& s) {
  visit("size", s.size, lengthDoc("along x, y and z, the origin in the middle"));
  visit("rounding", s.rounding,
        FieldDoc{"radius of edges and corners; at most half the shortest side", "world", 0, kGreatestLength});
}
template <class Visitor>
void describe(Visitor&& visit, Torus& s) {
  visit("majorRadius", s.majorRadius, lengthDoc("of the circle around the z axis that the tube is about"));
  visit("minorRadius", s.minorRadius, lengthDoc("of the tube"));
}
template <class Visitor>
void describe(Visitor&& visit, Capsule& s) {
  visit("from", s.from, FieldDoc{"one end of the line in its middle", "world", -1e9, 1e9});
  visit("to", s.to, FieldDoc{"the other end", "world", -1e9, 1e9});
  visit("radius", s.radius, lengthDoc("of its surface about the line"));
}
template <class Visitor>
void describe(Visitor&& visit, Profile& s) {
  visit("points", s.points,
        FieldDoc{.text = "of a closed curve, [distance from the z axis, z] of a revolution, [x, y] of an extrusion",
                 .unit = "world",
                 .min = -1e9,
                 .max = 1e9,
                 .required = true});
  visit("bulges", s.bulges,
        FieldDoc{"of the way from each point to the next: tangent of a quarter of an arc's angle, 0 for a straight "
                 "line, above 0 for an arc that bulges to the right; empty: straight lines",
                 "1", -100, 100});
  visit("smooth", s.smooth, FieldDoc{"a smooth curve of arcs through the points, in place of bulges"});
}
template <class Visitor>
void describe(Visitor&& visit, Revolution& s) {
  describe(visit, s.profile);
}
template <class Visitor>
void describe(Visitor&& visit, Extrusion& s) {
  describe(visit, s.profile);
  visit("height", s.height, lengthDoc("along z, the origin in the middle"));
}
template <class Visitor>
void describe(Visitor&& visit, Union& s) {
  visit("blend", s.blend, kBlendDoc);
}
template <class Visitor>
void describe(Visitor&& visit, Intersection& s) {
  visit("blend", s.blend, kBlendDoc);
}
template <class Visitor>
void describe(Visitor&& visit, Difference& s) {
  visit("blend", s.blend, kBlendDoc);
}
template <class Visitor>
void describe(Visitor&&, Complement&) {}
template <class Visitor>
void describe(Visitor&& visit, Offset& s) {
  visit("distance", s.distance, FieldDoc{"that the surface moves outwards", "world", -1e9, 1e9});
}
template <class Visitor>
void describe(Visitor&& visit, Shell& s) {
  visit("thickness", s.thickness, lengthDoc("of the wall that is left beneath the surface"));
}
template <class Visitor>
void describe(Visitor&& visit, NoiseDisplacement& s) {
  visit("amplitude", s.amplitude, FieldDoc{"greatest height", "world", 0, kGreatestLength});
  visit("size", s.size, lengthDoc("of its largest lumps"));
  visit("octaves", s.octaves, FieldDoc{"layers, each of half the size of the one before", "", 1, 12});
  visit("gain", s.gain, FieldDoc{"height of a layer, as a part of the one before", "1", 0, 1});
  visit("drift", s.drift, FieldDoc{"where the noise has moved to", "world", -1e9, 1e9});
  visit("seed", s.seed, FieldDoc{"of another noise", "", -1e9, 1e9});
}
template <class Visitor>
void describe(Visitor&& visit, WaveDisplacement& s) {
  visit("amplitude", s.amplitude, FieldDoc{"greatest height", "world", 0, kGreatestLength});
  visit("wavelength", s.wavelength, lengthDoc("from crest to crest"));
  visit("phase", s.phase, FieldDoc{"how far the crests have moved, in wavelengths", "1", -kHuge, kHuge});
  visit("direction", s.direction, FieldDoc{"in which they move, of any length", "1", -kHuge, kHuge});
  visit("radial", s.radial, FieldDoc{"rings around the z axis that move outwards, in place of a direction"});
}
template <class Visitor>
void describe(Visitor&& visit, Array& s) {
  visit("count", s.count, FieldDoc{"copies, the first where it is", "", 1, 1000000});
  visit("step", s.step, FieldDoc{.text = "placement of each copy, from the one before", .required = true});
  visit("blend", s.blend, kBlendDoc);
}
template <class Visitor>
void describe(Visitor&& visit, Instances& s) {
  visit("placements", s.placements, FieldDoc{.text = "of the copies", .required = true});
  visit("blend", s.blend, kBlendDoc);
}

} // namespace shapes

} // namespace volcaustic
