// Random shapes of every kind.
#pragma once

#include "shape_support.h"
#include "volcaustic/shape.h"

namespace volcaustic::test {

class ShapeTrees {
public:
  explicit ShapeTrees(Random& random) : mRandom(random) {}

  Shape any() { return tree(1 + mRandom.below(6)); }

  /// Of at most as many nodes one under the other.
  Shape tree(int depth) {
    if (depth <= 1) return solid();
    ShapeNode node{
        mRandom.chance(.3) ? "part" + std::to_string(mRandom.below(4)) : "", operation(), placement(), {}, {}};
    const int parts = partCount(node.kind);
    for (int i = 0; i < parts; ++i) node.parts.push_back(tree(depth - 1 - mRandom.below(2)));
    return Shape(node);
  }

  /// Somewhere, with deviations if it is a quadric; only these are scaled unevenly.
  Shape solid() {
    const int kind = mRandom.below(14);
    ShapeNode node{mRandom.chance(.5) ? "solid" + std::to_string(kind) : "", solidKind(kind), placement(), {}, {}};
    if (kind >= 9) node.placement.scale = {node.placement.scale[0], node.placement.scale[0], node.placement.scale[0]};
    if (kind >= 9) node.placement.shear = {0, 0, 0};
    for (int i = kind < 9 ? mRandom.below(3) : 0; i > 0; --i)
      node.deviations.push_back({Shape({"", solidKind(mRandom.below(9)), placement(), {}, {}}), between(-.5, .5)});
    return Shape(node);
  }

private:
  double between(double low, double high) { return mRandom.between(low, high); }
  Vec3d vector(double size) { return mRandom.point({{-size, -size, -size}, {size, size, size}}); }
  double blend() { return mRandom.chance(.5) ? 0 : between(.01, .4); }

  Placement placement() {
    Placement p;
    if (mRandom.chance(.2)) return p;
    p.translate = vector(1);
    if (mRandom.chance(.7)) p.rotate = vector(180);
    if (mRandom.chance(.5)) p.scale = {between(.5, 1.5), between(.5, 1.5), mRandom.chance(.1) ? -1 : between(.5, 1.5)};
    if (mRandom.chance(.2)) p.shear = vector(.4);
    return p;
  }

  shapes::Profile profile(double least) {
    shapes::Profile p;
    const int count = 3 + mRandom.below(6);
    for (int i = 0; i < count; ++i) {
      const double angle = 6.28 * i / count, radius = between(.3, .8);
      p.points.push_back({std::max(least, radius * std::cos(angle)), radius * std::sin(angle)});
      p.bulges.push_back(mRandom.chance(.4) ? 0 : between(-.6, .6));
    }
    for (int i = 0; i < count; ++i) // what was cut off at the axis
      if (p.points[i][0] == least) p.points[i][1] += 1e-3 * i;
    p.smooth = mRandom.chance(.3);
    if (p.smooth) p.bulges.clear();
    return p;
  }

  shapes::Kind solidKind(int kind) {
    const bool endless = mRandom.chance(.3);
    switch (kind) {
    case 0: {
      shapes::Quadric q;
      for (double& c : q.coefficients) c = between(-1, 1);
      return q;
    }
    case 1:
      return shapes::Plane{vector(1), between(-.5, .5)};
    case 2:
      return shapes::Slab{vector(1), between(.1, 1)};
    case 3:
      return shapes::Sphere{between(.3, 1)};
    case 4:
      return shapes::Ellipsoid{{between(.2, 1), between(.2, 1), between(.2, 1)}};
    case 5:
      return shapes::Cylinder{{between(.2, .8), between(.2, .8)}, between(.3, 2), endless};
    case 6:
      return shapes::Cone{between(.2, .8), between(.3, 2), endless};
    case 7:
      return shapes::Paraboloid{between(.2, .8), between(.3, 2), endless};
    case 8:
      return shapes::Hyperboloid{1 + mRandom.below(2), between(.1, .4), between(.5, .9), between(.9, 2), endless};
    case 9:
      return shapes::Cuboid{{between(.4, 1.5), between(.4, 1.5), between(.4, 1.5)}, endless ? .1 : 0};
    case 10:
      return shapes::Torus{between(.3, .8), between(.05, .25)};
    case 11:
      return shapes::Capsule{vector(.7), vector(.7), between(.1, .4)};
    case 12:
      return shapes::Revolution{profile(0)};
    default:
      return shapes::Extrusion{profile(-1), between(.2, 1.5)};
    }
  }

  shapes::Kind operation() {
    switch (mRandom.below(10)) {
    case 0:
      return shapes::Union{blend()};
    case 1:
      return shapes::Intersection{blend()};
    case 2:
      return shapes::Difference{blend()};
    case 3:
      return shapes::Complement{};
    case 4:
      return shapes::Offset{between(-.1, .2)};
    case 5:
      return shapes::Shell{between(.02, .2)};
    case 6: {
      shapes::NoiseDisplacement noise;
      noise.amplitude = between(0, .1);
      noise.size = between(.2, 1);
      noise.octaves = 1 + mRandom.below(3);
      noise.seed = mRandom.below(1000);
      return noise;
    }
    case 7:
      return shapes::WaveDisplacement{between(0, .1), between(.2, 1), between(0, 1), vector(1), mRandom.chance(.5)};
    case 8:
      return shapes::Array{1 + mRandom.below(4), placement(), blend()};
    default: {
      shapes::Instances copies;
      for (int i = 1 + mRandom.below(3); i > 0; --i) copies.placements.push_back(placement());
      copies.blend = blend();
      return copies;
    }
    }
  }
  int partCount(const shapes::Kind& kind) { return kind.index() < 17 ? 1 + mRandom.below(3) : 1; }

  Random& mRandom;
};

} // namespace volcaustic::test
