#include "shapes/revolution.h"

#include "core/simd_clones.h"
#include "shapes/profile.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

/// What can be divided by where the gradient has no direction.
constexpr double kTiny = 1e-300;

VOLCAUSTIC_SIMD_CLONES void axisDistances(const ShapePoints p, double* __restrict distance) {
  for (int i = 0; i < p.count; ++i) distance[i] = std::sqrt(p.x[i] * p.x[i] + p.y[i] * p.y[i]);
}

/// Turns gradients in the plane of a profile into that of each point; they come in the first two rows.
VOLCAUSTIC_SIMD_CLONES void turnGradients(const ShapePoints p, const double* distance, double* __restrict gx,
                                          double* __restrict gy, double* __restrict gz) {
  for (int i = 0; i < p.count; ++i) {
    const double k = gx[i] / (distance[i] + kTiny);
    gz[i] = gy[i];
    gx[i] = k * p.x[i];
    gy[i] = k * p.y[i];
  }
}

/// A profile's own distance is that of the solid: of all copies of the profile around the axis the nearest one to a
/// point is that in the same half-plane.
class RevolutionFunction final : public ShapeFunction {
public:
  explicit RevolutionFunction(const shapes::Revolution& s) : mCurve(s.profile, ProfileUse::Revolved) {}

  void evaluate(const ShapePoints& p, const ShapeValues& v) const override {
    BatchNumbers distance;
    axisDistances(p, distance.data());
    mCurve.evaluate(distance.data(), p.z, p.count, {v.value, {v.gradient[0], v.gradient[1]}});
    if (v.wantsGradient()) turnGradients(p, distance.data(), v.gradient[0], v.gradient[1], v.gradient[2]);
  }

  [[nodiscard]] Interval bound(const Box& box) const override {
    double least = 0, greatest = 0;
    for (int a = 0; a < 2; ++a) {
      least = std::hypot(least, std::max({0.0, box.min[a], -box.max[a]}));
      greatest = std::hypot(greatest, std::max(std::abs(box.min[a]), std::abs(box.max[a])));
    }
    return mCurve.bound({{least * (1 - 1e-15), box.min[2]}, {greatest * (1 + 1e-15), box.max[2]}});
  }

private:
  ProfileCurve mCurve;
};

// With a, the profile's distance, and b, that from the nearer end, the distance of an extrusion's surface is the lesser
// one of the two inside, and outside how far both are below 0 together. It grows with a and with b.

[[gnu::always_inline]] inline double prismDistance(double a, double b) {
  const double u = std::min(a, 0.0), v = std::min(b, 0.0);
  return std::max(std::min(a, b), 0.0) - std::sqrt(u * u + v * v);
}

VOLCAUSTIC_SIMD_CLONES void prismDistances(double half, const double* z, int count, double* __restrict value) {
  for (int i = 0; i < count; ++i) value[i] = prismDistance(value[i], half - std::abs(z[i]));
}

/// \param profile distances; the gradient's first two rows come as those of the profile
VOLCAUSTIC_SIMD_CLONES void prismGradients(double half, const double* profile, const double* z, int count,
                                           double* __restrict gx, double* __restrict gy, double* __restrict gz) {
  for (int i = 0; i < count; ++i) {
    const double a = profile[i], b = half - std::abs(z[i]);
    const double u = std::min(a, 0.0), v = std::min(b, 0.0), length = std::sqrt(u * u + v * v);
    const double k = -1 / (length + kTiny), inside = a <= b ? 1 : 0;
    const double across = length > 0 ? k * u : inside, along = length > 0 ? k * v : 1 - inside;
    gx[i] *= across;
    gy[i] *= across;
    gz[i] = -std::copysign(along, z[i]);
  }
}

class ExtrusionFunction final : public ShapeFunction {
public:
  explicit ExtrusionFunction(const shapes::Extrusion& s)
      : mCurve(s.profile, ProfileUse::Extruded), mHalf(.5 * s.height) {}

  void evaluate(const ShapePoints& p, const ShapeValues& v) const override {
    mCurve.evaluate(p.x, p.y, p.count, {v.value, {v.gradient[0], v.gradient[1]}});
    if (v.wantsGradient()) prismGradients(mHalf, v.value, p.z, p.count, v.gradient[0], v.gradient[1], v.gradient[2]);
    prismDistances(mHalf, p.z, p.count, v.value);
  }

  [[nodiscard]] Interval bound(const Box& box) const override {
    const Interval profile = mCurve.bound({{box.min[0], box.min[1]}, {box.max[0], box.max[1]}});
    const double close = std::max({0.0, box.min[2], -box.max[2]});
    const double far = std::max(std::abs(box.min[2]), std::abs(box.max[2]));
    const Interval value{prismDistance(profile.low, mHalf - far), prismDistance(profile.high, mHalf - close)};
    return widened(value, kRoundingSlack * magnitude(value));
  }

private:
  ProfileCurve mCurve;
  double mHalf;
};

} // namespace

std::unique_ptr<ShapeFunction> makeRevolution(const shapes::Revolution& revolution) {
  return std::make_unique<RevolutionFunction>(revolution);
}
std::unique_ptr<ShapeFunction> makeExtrusion(const shapes::Extrusion& extrusion) {
  return std::make_unique<ExtrusionFunction>(extrusion);
}

} // namespace volcaustic
