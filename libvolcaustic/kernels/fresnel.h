// Reflection where the index changes within a few voxels.
//
// A voxelised surface is a skin in which light bends. Geometric optics has no reflection in a medium that smooth, so
// the share that a sharp surface would send back is found afterwards: a ray is watched for crossings, runs of steps
// along which the index does nothing but rise, or fall. At the end of one, indices before and behind and the momentum
// along the surface give Fresnel's reflectance (Born, Wolf: Principles of Optics, 1.5.2, eqs. 35); a reflected ray
// starts where the index changed fastest. Slow gradients reflect nothing. Total reflection needs no help: there the ray
// turns round by itself, and such a crossing does not count.
#pragma once

#include "kernels/march.h"

namespace volcaustic::kernels {

/// Of unpolarised light at a plane surface from index `before` to `behind`; `along2` is the square of the optical
/// momentum along the surface, before sin(angle) = behind sin(angle behind), at most before^2.
template <class F>
VOLCAUSTIC_HD inline F fresnelReflectance(F before, F behind, F along2) {
  const F a2 = before * before, b2 = behind * behind;
  const F a = squareRoot(larger(a2 - along2, F(0))), b = squareRoot(larger(b2 - along2, F(0))); // across the surface
  const F s = (a - b) * reciprocal(larger(a + b, F(1e-12f)));
  const F p = (b2 * a - a2 * b) * reciprocal(larger(b2 * a + a2 * b, F(1e-12f)));
  return F(0.5f) * (s * s + p * p);
}

/// A run of steps along which the index rises, or falls.
template <class F>
struct SurfaceCrossing {
  F before{0};   ///< index where it began; 0: none is under way; below 0: one that reflects nothing
  F rise{0};     ///< above 0 where the index rises
  F steepest{0}; ///< greatest |grad n| so far, 1/voxel; and there:
  RayOf<F> at{{F(0), F(0), F(0)}, {F(0), F(0), F(0)}};
  Vec3<F> normal{F(0), F(0), F(0)}; ///< unit
  Vec3<F> light{F(0), F(0), F(0)};  ///< what the ray carried where the crossing began

  /// Calls visit(number) for each number of it.
  template <class Visit>
  VOLCAUSTIC_HD void forEach(const Visit& visit) {
    visit(before), visit(rise), visit(steepest);
    for (Vec3<F>* v : {&at.x, &at.v, &normal, &light}) visit(v->x), visit(v->y), visit(v->z);
  }
};
inline constexpr int kSurfaceCrossingNumbers = 15;

/// What a crossing that came to its end sends back. A surface reflects the light that comes to it: what the skin took
/// of that on the way in does not count.
template <class F>
struct Reflection {
  MaskOf<F> on;
  F share;     ///< reflectance
  RayOf<F> to; ///< the reflected ray's start
  F rise;      ///< of the crossing
  Vec3<F> light;
};

inline constexpr float kThickestSurface = 12;     ///< voxels: change of index over greatest slope
inline constexpr float kFaintestSurface = 0.002f; ///< change of index

/// Watches steps of arc length ds, for the lanes `on`; `light` is what they carry at their start.
template <class F>
VOLCAUSTIC_HD inline Reflection<F> watchStep(SurfaceCrossing<F>& c, const RayOf<F>& from, const RayOf<F>& to, F ds,
                                             const Vec3<F>& light, const MaskOf<F>& on) {
  using M = MaskOf<F>;
  const Vec3<F> kick = to.v - from.v, middle = (from.v + to.v) * F(0.5f);
  const F squared = dot(kick, kick), change = dot(kick, middle);
  const M under = both(on, negate(c.before == F(0)));
  const M bends = both(on, absOf(change) > F(1e-4f) * ds);
  const M goesOn = both(both(under, bends), change * c.rise > F(0));
  const M ends = both(under, negate(goesOn));
  const F inverse = inverseRoot(dot(from.v, from.v)), index = dot(from.v, from.v) * inverse;

  Reflection<F> r{ends, F(0), c.at, c.rise, c.light};
  if (any(ends)) {
    const F across = dot(c.at.v, c.normal), along2 = larger(dot(c.at.v, c.at.v) - across * across, F(0));
    const F moved = absOf(index - c.before);
    const M surface =
        both(c.before > F(0), both(moved > F(kFaintestSurface), moved < c.steepest * F(kThickestSurface)));
    r.on = both(ends, both(surface, across * dot(from.v, c.normal) > F(0)));
    r.share = select(r.on, smaller(fresnelReflectance(larger(c.before, F(0.1f)), index, along2), F(1)), F(0));
    r.to.v = mulAdd(c.normal, F(-2) * across, c.at.v);
  }

  const M begins = both(bends, negate(goesOn));
  c.before = select(begins, index, select(ends, F(0), c.before));
  c.rise = select(begins, change, c.rise);
  c.light = select<F>(begins, light, c.light);
  c.steepest = select(begins, F(0), c.steepest);
  const F slope2 = squared * reciprocal(larger(ds * ds, F(1e-12f)));
  const M steeper = both(bends, slope2 > c.steepest * c.steepest);
  if (any(steeper)) {
    c.steepest = select(steeper, squareRoot(slope2), c.steepest);
    c.at = {select<F>(steeper, (from.x + to.x) * F(0.5f), c.at.x), select<F>(steeper, middle, c.at.v)};
    c.normal = select<F>(steeper, kick * inverseRoot(larger(squared, F(1e-20f))), c.normal);
  }
  return r;
}

/// The state of a ray that was sent back: the rest of the surface reflects nothing.
template <class F>
VOLCAUSTIC_HD inline SurfaceCrossing<F> sentBack(const Reflection<F>& r) {
  SurfaceCrossing<F> c;
  c.before = F(-1);
  c.rise = F(0) - r.rise;
  c.at = r.to;
  return c;
}

} // namespace volcaustic::kernels
