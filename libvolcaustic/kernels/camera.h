// The camera, and where its rays meet a box.
#pragma once

#include "kernels/lanes.h"

namespace volcaustic::kernels {

/// A box in grid space.
struct GridBox {
  Float3 low, high;

  /// Distance from x along the unit vector d to where the line leaves the box; below 0 where that is behind x.
  template <class F>
  [[nodiscard]] VOLCAUSTIC_HD F exit(const Vec3<F>& x, const Vec3<F>& d) const {
    const auto axis = [](F xa, F da, float from, float to) {
      const F face = select(da > F(0), F(to), F(from));
      return select(absOf(da) > F(1e-6f), (face - xa) * reciprocal(da), F(3.0e38f));
    };
    return smaller(axis(x.x, d.x, low.x, high.x),
                   smaller(axis(x.y, d.y, low.y, high.y), axis(x.z, d.z, low.z, high.z)));
  }
};

/// A ray of the camera where it meets a box, or its own start where that is inside.
template <class F>
struct CameraRay {
  Vec3<F> start, direction;
  F distance;     ///< to the start
  MaskOf<F> hits; ///< whether there is a way through the box
};

/// A pinhole in grid space: the direction through the raster point (u, v) in [0, 1]^2, v down, is corner + u right + v
/// down.
struct CameraFrame {
  Double3 origin, corner, right, down;
  std::int32_t width = 0, height = 0;

  /// Through the point (column, row) of the raster, in pixels.
  template <class F>
  [[nodiscard]] VOLCAUSTIC_HD CameraRay<F> ray(const GridBox& box, const DoubleOf<F>& column,
                                               const DoubleOf<F>& row) const {
    using D = DoubleOf<F>;
    const auto vec = [](const Double3& a) { return Vec3<D>(D(a.x), D(a.y), D(a.z)); };
    const Vec3<D> o = vec(origin),
                  towards = vec(corner) + vec(right) * (column * D(1.0 / width)) + vec(down) * (row * D(1.0 / height));
    const Vec3<D> d = towards * reciprocal(squareRoot(dot(towards, towards)));
    D entry(0), exit(1e300);
    const auto axis = [&](D oa, D da, float low, float high) {
      const D inverse = reciprocal(awayFromZero(da)), t0 = (D(low) - oa) * inverse, t1 = (D(high) - oa) * inverse;
      entry = larger(entry, smaller(t0, t1));
      exit = smaller(exit, larger(t0, t1));
    };
    axis(o.x, d.x, box.low.x, box.high.x);
    axis(o.y, d.y, box.low.y, box.high.y);
    axis(o.z, d.z, box.low.z, box.high.z);
    const Vec3<D> start = o + d * entry;
    return {{narrow(start.x), narrow(start.y), narrow(start.z)},
            {narrow(d.x), narrow(d.y), narrow(d.z)},
            narrow(entry),
            narrow(exit - entry) > F(0)};
  }
};

} // namespace volcaustic::kernels
