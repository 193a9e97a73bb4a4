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

/// A light as the voxels of a brick see it where nothing stands between: grid space.
struct LampView {
  Float3 low;         ///< the brick's low corner
  Float3 fromLight;   ///< point light: from it to the low corner
  Float3 direction;   ///< parallel light: unit vector
  Float3 strength;    ///< fluence (parallel light), or fluence times distance^2 in voxels (point light)
  Float3 attenuation; ///< of the ambient medium, 1/voxel
  Float3 box;         ///< high corner of the domain
  bool point, clear;
};

/// Fluence of the unobstructed light at the centre of the brick's voxel `k` (z fastest), and where it goes.
template <class F>
struct LampLight {
  Vec3<F> fluence, direction;
};
template <class F>
VOLCAUSTIC_HD inline LampLight<F> lampLight(const LampView& lamp, const IntOf<F>& k) {
  using I = IntOf<F>;
  const auto vec = [](const Float3& a) { return Vec3<F>(F(a.x), F(a.y), F(a.z)); };
  const Vec3<F> centre(toFloat(k >> 6) + F(0.5f), toFloat((k >> 3) & I(7)) + F(0.5f), toFloat(k & I(7)) + F(0.5f));
  LampLight<F> light{vec(lamp.strength), vec(lamp.direction)};
  F way(3.0e38f);
  if (lamp.point) {
    const Vec3<F> r = vec(lamp.fromLight) + centre;
    // Inside the light's own voxel: as at half a voxel.
    const F squared = dot(r, r), inverse = inverseRoot(larger(squared, F(1e-12f)));
    light.direction = r * inverse;
    light.fluence = light.fluence * reciprocal(larger(squared, F(0.25f)));
    way = squared * inverse;
  }
  if (lamp.clear) return light;
  // Back along the light to the face of the box, or to the light itself.
  const Vec3<F> p = vec(lamp.low) + centre;
  const auto axis = [&](F pa, F da, float high) {
    const F back = select(da > F(0), pa, pa - F(high));
    way = smaller(way, select(absOf(da) > F(1e-6f), back * reciprocal(da), F(3.0e38f)));
  };
  axis(p.x, light.direction.x, lamp.box.x);
  axis(p.y, light.direction.y, lamp.box.y);
  axis(p.z, light.direction.z, lamp.box.z);
  const Vec3<F> depth = vec(lamp.attenuation) * way;
  light.fluence = light.fluence * Vec3<F>(exponential(-depth.x), exponential(-depth.y), exponential(-depth.z));
  return light;
}

} // namespace volcaustic::kernels
