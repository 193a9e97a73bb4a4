// How much of a voxel's light has not met a bend yet: the raster's rays through the voxel, length by length.
#pragma once

#include "kernels/emission.h"

namespace volcaustic::kernels {

/// A raster as one voxel sees it: positions relative to the voxel's centre, distances relative to it too, so that
/// single precision does.
struct LitView {
  Float3 axisU, axisV, axisW;
  Float3 towards; ///< point light: unit vector from the light to the centre
  float distance; ///< point light: from the light to the centre
  float u0, v0, du,
      dv;      ///< middle of the footprint's first cell, and the size of a cell; parallel light: from the centre
  float shift; ///< what to add to an entry of the map to get a distance from the centre
  std::int32_t columns;   ///< of the footprint
  std::int32_t cells;     ///< in the footprint
  std::int32_t first;     ///< number of its first cell in the map
  std::int32_t mapStride; ///< columns of the map
  bool point;
};

/// Lengths inside the voxel of the ray through cell `i` of the footprint: all of it, and the part before its first
/// bend.
template <class F>
struct LitLengths {
  F all, lit;
};
template <class F>
VOLCAUSTIC_HD inline LitLengths<F> litLengths(const LitView& view, const float* entry, const IntOf<F>& i) {
  using I = IntOf<F>;
  const I row = toInt((toFloat(i) + F(0.5f)) * F(1 / static_cast<float>(view.columns)));
  const I column = i - row * I(view.columns);
  const F bend = gather(entry, I(view.first) + row * I(view.mapStride) + column) + F(view.shift);
  const F u = mulAdd(toFloat(column), F(view.du), F(view.u0)), v = mulAdd(toFloat(row), F(view.dv), F(view.v0));
  const auto vec = [](const Float3& a) { return Vec3<F>(F(a.x), F(a.y), F(a.z)); };

  // The ray's point at distance zero, from the voxel's centre.
  Vec3<F> direction = vec(view.axisW), at = vec(view.axisU) * u + vec(view.axisV) * v;
  F in(-1.0e30f), out(1.0e30f);
  if (view.point) {
    const Vec3<F> slanted = direction + at;
    direction = slanted * inverseRoot(dot(slanted, slanted));
    at = (direction - vec(view.towards)) * F(view.distance);
    in = F(-view.distance);
  }
  const auto axis = [&](F p, F d) {
    const F inverse = reciprocal(select(absOf(d) > F(1e-9f), d, F(1e-9f)));
    const F low = (F(-0.5f) - p) * inverse, high = (F(0.5f) - p) * inverse;
    in = larger(in, smaller(low, high));
    out = smaller(out, larger(low, high));
  };
  axis(at.x, direction.x);
  axis(at.y, direction.y);
  axis(at.z, direction.z);
  const F all = larger(out - in, F(0));
  return {all, clampTo(bend - in, F(0), all)};
}

} // namespace volcaustic::kernels
