#include "shapes/solids.h"

#include "core/simd_clones.h"
#include "shapes/affine.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

/// What can be under a root whose inverse is taken.
constexpr double kTiny = 1e-300;

/// Of a function that changes by no more than the way: its value in the middle, and half the diagonal to both sides.
template <class Function>
Interval lipschitzBound(const Function& function, const Box& box, double size) {
  Vec3d middle;
  double diagonal = 0, reach = size;
  for (int a = 0; a < 3; ++a) {
    middle[a] = .5 * (box.min[a] + box.max[a]);
    const double half = .5 * (box.max[a] - box.min[a]);
    diagonal += half * half;
    reach += std::max(std::abs(box.min[a]), std::abs(box.max[a]));
  }
  double value = 0;
  function.evaluate({&middle[0], &middle[1], &middle[2], 1}, {&value, {nullptr, nullptr, nullptr}});
  return widened({value, value}, std::sqrt(diagonal) * (1 + 1e-14) + kRoundingSlack * reach);
}

/// Arrays apart from each other and from the points.
struct Gradients {
  double* __restrict x;
  double* __restrict y;
  double* __restrict z;
};
Gradients gradientsOf(const ShapeValues& v) { return {v.gradient[0], v.gradient[1], v.gradient[2]}; }

/// The least and the greatest distance that points of a box have from the plane across an axis through the origin.
Interval awayFrom(const Box& box, int axis) {
  return {std::max({0.0, box.min[axis], -box.max[axis]}), std::max(std::abs(box.min[axis]), std::abs(box.max[axis]))};
}

class CuboidFunction final : public ShapeFunction {
public:
  explicit CuboidFunction(const shapes::Cuboid& s) : mRounding(s.rounding) {
    for (int a = 0; a < 3; ++a) mHalf[a] = .5 * s.size[a] - s.rounding;
  }
  void evaluate(const ShapePoints& p, const ShapeValues& v) const override {
    distance(p, v.value);
    if (v.wantsGradient()) slope(p, gradientsOf(v));
  }
  /// Exact: the further out along any axis, the less, and that holds of each step of the arithmetic.
  [[nodiscard]] Interval bound(const Box& box) const override {
    const Interval x = awayFrom(box, 0), y = awayFrom(box, 1), z = awayFrom(box, 2);
    double least, greatest;
    distance({&x.low, &y.low, &z.low, 1}, &greatest);
    distance({&x.high, &y.high, &z.high, 1}, &least);
    return {least, greatest};
  }

private:
  VOLCAUSTIC_SIMD_CLONES void distance(const ShapePoints p, double* __restrict value) const {
    const Vec3d half = mHalf;
    for (int i = 0; i < p.count; ++i) {
      const double x = std::abs(p.x[i]) - half[0], y = std::abs(p.y[i]) - half[1], z = std::abs(p.z[i]) - half[2];
      const double u = std::max(x, 0.0), v = std::max(y, 0.0), w = std::max(z, 0.0);
      const double inside = std::min(std::max(x, std::max(y, z)), 0.0);
      value[i] = mRounding - (std::sqrt(u * u + v * v + w * w) + inside);
    }
  }
  VOLCAUSTIC_SIMD_CLONES void slope(const ShapePoints p, const Gradients g) const {
    const Vec3d half = mHalf;
    for (int i = 0; i < p.count; ++i) {
      const double x = std::abs(p.x[i]) - half[0], y = std::abs(p.y[i]) - half[1], z = std::abs(p.z[i]) - half[2];
      const double u = std::max(x, 0.0), v = std::max(y, 0.0), w = std::max(z, 0.0);
      const double length = std::sqrt(u * u + v * v + w * w), k = 1 / std::max(length, kTiny);
      // Inside, the nearest face; of equal ones the first.
      const double isX = (x >= y) & (x >= z) ? 1 : 0, isY = (y >= z) & (x < y) ? 1 : 0;
      const bool outside = length > 0;
      g.x[i] = -std::copysign(outside ? u * k : isX, p.x[i]);
      g.y[i] = -std::copysign(outside ? v * k : isY, p.y[i]);
      g.z[i] = -std::copysign(outside ? w * k : 1 - isX - isY, p.z[i]);
    }
  }

  Vec3d mHalf{};
  double mRounding;
};

class TorusFunction final : public ShapeFunction {
public:
  explicit TorusFunction(const shapes::Torus& s) : mMajor(s.majorRadius), mMinor(s.minorRadius) {}
  void evaluate(const ShapePoints& p, const ShapeValues& v) const override {
    distance(p, v.value);
    if (v.wantsGradient()) slope(p, gradientsOf(v));
  }
  [[nodiscard]] Interval bound(const Box& box) const override {
    const Interval x = awayFrom(box, 0), y = awayFrom(box, 1), z = awayFrom(box, 2);
    const double inner = std::hypot(x.low, y.low) - mMajor, outer = std::hypot(x.high, y.high) - mMajor;
    const Interval value{mMinor - std::hypot(std::max(-inner, outer), z.high),
                         mMinor - std::hypot(std::max({0.0, inner, -outer}), z.low)};
    return widened(value, kRoundingSlack * (mMajor + mMinor + x.high + y.high + z.high));
  }

private:
  VOLCAUSTIC_SIMD_CLONES void distance(const ShapePoints p, double* __restrict value) const {
    for (int i = 0; i < p.count; ++i) {
      const double ring = std::sqrt(p.x[i] * p.x[i] + p.y[i] * p.y[i]) - mMajor;
      value[i] = mMinor - std::sqrt(ring * ring + p.z[i] * p.z[i]);
    }
  }
  VOLCAUSTIC_SIMD_CLONES void slope(const ShapePoints p, const Gradients g) const {
    for (int i = 0; i < p.count; ++i) {
      const double axis = std::sqrt(p.x[i] * p.x[i] + p.y[i] * p.y[i]) + kTiny, ring = axis - mMajor;
      const double k = -1 / (std::sqrt(ring * ring + p.z[i] * p.z[i]) + kTiny);
      g.x[i] = k * ring * p.x[i] / axis;
      g.y[i] = k * ring * p.y[i] / axis;
      g.z[i] = k * p.z[i];
    }
  }

  double mMajor, mMinor;
};

class CapsuleFunction final : public ShapeFunction {
public:
  explicit CapsuleFunction(const shapes::Capsule& s) : mFrom(s.from), mRadius(s.radius) {
    double square = 0;
    for (int a = 0; a < 3; ++a) {
      mWay[a] = s.to[a] - s.from[a];
      square += mWay[a] * mWay[a];
    }
    mInverse = square > 0 ? 1 / square : 0;
  }
  void evaluate(const ShapePoints& p, const ShapeValues& v) const override {
    BatchNumbers x, y, z;
    distance(p, v.value, {x.data(), y.data(), z.data()});
    if (v.wantsGradient()) slope(p.count, {x.data(), y.data(), z.data()}, gradientsOf(v));
  }
  [[nodiscard]] Interval bound(const Box& box) const override {
    double size = mRadius;
    for (int a = 0; a < 3; ++a) size += std::abs(mFrom[a]) + std::abs(mWay[a]);
    return lipschitzBound(*this, box, size);
  }

private:
  /// And the way from the nearest point of the line.
  VOLCAUSTIC_SIMD_CLONES void distance(const ShapePoints p, double* __restrict value, const Gradients way) const {
    const Vec3d from = mFrom, along = mWay;
    for (int i = 0; i < p.count; ++i) {
      const double x = p.x[i] - from[0], y = p.y[i] - from[1], z = p.z[i] - from[2];
      const double t = std::min(std::max((x * along[0] + y * along[1] + z * along[2]) * mInverse, 0.0), 1.0);
      way.x[i] = x - t * along[0];
      way.y[i] = y - t * along[1];
      way.z[i] = z - t * along[2];
      value[i] = mRadius - std::sqrt(way.x[i] * way.x[i] + way.y[i] * way.y[i] + way.z[i] * way.z[i]);
    }
  }
  VOLCAUSTIC_SIMD_CLONES void slope(int count, const Gradients way, const Gradients g) const {
    for (int i = 0; i < count; ++i) {
      const double x = way.x[i], y = way.y[i], z = way.z[i], k = -1 / std::max(std::sqrt(x * x + y * y + z * z), kTiny);
      g.x[i] = k * x;
      g.y[i] = k * y;
      g.z[i] = k * z;
    }
  }

  Vec3d mFrom, mWay{};
  double mRadius, mInverse;
};

VOLCAUSTIC_SIMD_CLONES void mapPoints(const Affine m, const ShapePoints p, double* __restrict x, double* __restrict y,
                                      double* __restrict z) {
  for (int i = 0; i < p.count; ++i) {
    x[i] = m[0][0] * p.x[i] + m[0][1] * p.y[i] + m[0][2] * p.z[i] + m[0][3];
    y[i] = m[1][0] * p.x[i] + m[1][1] * p.y[i] + m[1][2] * p.z[i] + m[1][3];
    z[i] = m[2][0] * p.x[i] + m[2][1] * p.y[i] + m[2][2] * p.z[i] + m[2][3];
  }
}

VOLCAUSTIC_SIMD_CLONES void scaleValues(double by, int count, double* v) {
  for (int i = 0; i < count; ++i) v[i] *= by;
}

/// A gradient of local space, per world unit: times the transposed matrix.
VOLCAUSTIC_SIMD_CLONES void mapGradients(const Affine m, double scale, int count, const Gradients g) {
  for (int i = 0; i < count; ++i) {
    const double x = g.x[i] * scale, y = g.y[i] * scale, z = g.z[i] * scale;
    g.x[i] = m[0][0] * x + m[1][0] * y + m[2][0] * z;
    g.y[i] = m[0][1] * x + m[1][1] * y + m[2][1] * z;
    g.z[i] = m[0][2] * x + m[1][2] * y + m[2][2] * z;
  }
}

class PlacedFunction final : public ShapeFunction {
public:
  PlacedFunction(std::unique_ptr<ShapeFunction> local, const Affine& toWorld)
      : mLocal(std::move(local)), mToLocal(inverse(toWorld)), mScale(leastStretch(toWorld)) {}

  void evaluate(const ShapePoints& p, const ShapeValues& v) const override {
    BatchNumbers x, y, z;
    mapPoints(mToLocal, p, x.data(), y.data(), z.data());
    mLocal->evaluate({x.data(), y.data(), z.data(), p.count}, v);
    scaleValues(mScale, p.count, v.value);
    if (v.wantsGradient()) mapGradients(mToLocal, mScale, p.count, gradientsOf(v));
  }

  [[nodiscard]] Interval bound(const Box& world) const override {
    Box local;
    for (int a = 0; a < 3; ++a) {
      double middle = mToLocal[a][3], half = 0, size = std::abs(mToLocal[a][3]);
      for (int b = 0; b < 3; ++b) {
        middle += mToLocal[a][b] * .5 * (world.min[b] + world.max[b]);
        half += std::abs(mToLocal[a][b]) * .5 * (world.max[b] - world.min[b]);
        size += std::abs(mToLocal[a][b]) * std::max(std::abs(world.min[b]), std::abs(world.max[b]));
      }
      half += kRoundingSlack * size;
      local.min[a] = middle - half;
      local.max[a] = middle + half;
    }
    const Interval v = mLocal->bound(local);
    return widened({v.low * mScale, v.high * mScale}, kRoundingSlack * mScale * magnitude(v));
  }

private:
  std::unique_ptr<ShapeFunction> mLocal;
  Affine mToLocal;
  double mScale;
};

} // namespace

std::unique_ptr<ShapeFunction> makeCuboid(const shapes::Cuboid& cuboid) {
  return std::make_unique<CuboidFunction>(cuboid);
}
std::unique_ptr<ShapeFunction> makeTorus(const shapes::Torus& torus) { return std::make_unique<TorusFunction>(torus); }
std::unique_ptr<ShapeFunction> makeCapsule(const shapes::Capsule& capsule) {
  return std::make_unique<CapsuleFunction>(capsule);
}
std::unique_ptr<ShapeFunction> placedFunction(std::unique_ptr<ShapeFunction> local, const Affine& toWorld) {
  if (toWorld == kIdentity) return local;
  return std::make_unique<PlacedFunction>(std::move(local), toWorld);
}

} // namespace volcaustic
