// What is beyond the domain, by direction: a gradient, or a map in latitude and longitude (docs/formats.md,
// "Backgrounds").
#pragma once

#include "kernels/lanes.h"

namespace volcaustic::kernels {

/// The angle of (x, y) from the x axis, in [-pi, pi]; some angle where both are 0.
template <class F>
VOLCAUSTIC_HD inline F polarAngle(F x, F y) {
  constexpr float kPi = 3.14159265f;
  const F ax = absOf(x), ay = absOf(y), most = larger(larger(ax, ay), F(1e-30f));
  const F octant = arctangent(quotient(smaller(ax, ay), most));
  const F quadrant = select(ay > ax, F(0.5f * kPi) - octant, octant);
  const F half = select(x < F(0), F(kPi) - quadrant, quadrant);
  return select(y < F(0), F(0) - half, half);
}

/// Radiance that comes from directions, grid space (whose axes are the world's). A map's pixels are areas of equal
/// steps in longitude and latitude, rows from the pole `up` down; the middle of the picture is at `front`, its right
/// edge behind, over -`left`.
struct Environment {
  Float3 up{0, 0, 1}, front{1, 0, 0}, left{0, 1, 0};    ///< unit vectors
  Float3 bottom, top;                                   ///< gradient in the height of the direction over the horizon
  const float* planes[3] = {nullptr, nullptr, nullptr}; ///< of a map: red, green, blue; it takes the gradient's place
  Float3 scale{1, 1, 1};                                ///< of a map
  std::int32_t width = 0, height = 0;

  /// `towards` is a unit vector, from the eye out.
  template <class F>
  [[nodiscard]] VOLCAUSTIC_HD Vec3<F> radiance(const Vec3<F>& towards) const {
    const F z = dot(towards, vec<F>(up));
    if (!planes[0]) return vec<F>(bottom) + vec<F>(top - bottom) * (F(0.5f) + F(0.5f) * z);
    return inMap(dot(towards, vec<F>(front)), dot(towards, vec<F>(left)), z);
  }

private:
  template <class F>
  VOLCAUSTIC_HD static Vec3<F> vec(const Float3& a) {
    return {F(a.x), F(a.y), F(a.z)};
  }

  /// Bilinear between the middles of pixels. Rows beyond a pole are those before it, on the other side.
  template <class F>
  [[nodiscard]] VOLCAUSTIC_HD Vec3<F> inMap(F x, F y, F z) const {
    using I = IntOf<F>;
    constexpr float kPerTurn = 0.15915494f;
    const F across2 = x * x + y * y, across = across2 * inverseRoot(larger(across2, F(1e-30f)));
    const F u = F(0.5f) - polarAngle(x, y) * F(kPerTurn), v = F(2 * kPerTurn) * polarAngle(z, across);
    // One more than the place among the pixels' middles, so that rounding is down; in bounds whatever the numbers.
    const auto placeIn = [](F share, std::int32_t count) {
      const auto n = static_cast<float>(count);
      return larger(F(0.5f), smaller(mulAdd(share, F(n), F(0.5f)), F(n + 0.5f)));
    };
    const F column = placeIn(u, width), row = placeIn(v, height);
    const I right = toInt(column), below = toInt(row);
    const F s = column - toFloat(right), t = row - toFloat(below);
    const Vec3<F> high = inRow(below - I(1), right, s), low = inRow(below, right, s);
    return mulAdd(low - high, t, high);
  }

  /// Between the pixels `right` - 1 and `right` of a row from -1 to height.
  template <class F, class I = IntOf<F>>
  [[nodiscard]] VOLCAUSTIC_HD Vec3<F> inRow(const I& row, const I& right, F s) const {
    const auto over = either(row<I(0), row> I(height - 1));
    const I inside = select(row < I(0), I(0), select(over, I(height - 1), row));
    const auto index = [&](const I& column) {
      const I turned = column + select(over, I(width >> 1), I(0));
      const I wrapped =
          select(turned < I(0), turned + I(width), select(turned > I(width - 1), turned - I(width), turned));
      return inside * I(width) + wrapped;
    };
    const I a = index(right - I(1)), b = index(right);
    const auto plane = [&](int c, float factor) {
      const F from = gather(planes[c], a);
      return mulAdd(gather(planes[c], b) - from, s, from) * F(factor);
    };
    return {plane(0, scale.x), plane(1, scale.y), plane(2, scale.z)};
  }
};

} // namespace volcaustic::kernels
