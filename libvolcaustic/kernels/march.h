// The step of a ray of geometric optics, d/ds(n dx/ds) = grad n, through a flat medium. Written over lanes: F is float
// for one ray, or a backend's lane type for as many as it holds.
#pragma once

#include "kernels/flat_medium.h"

namespace volcaustic::kernels {

/// A ray's state: position and optical momentum v = n dx/ds, grid space.
template <class F>
struct RayOf {
  Vec3<F> x;
  Vec3<F> v;
};
using Ray = RayOf<float>;

/// How long steps may be, in voxels, and which scheme carries them.
struct MarchRules {
  float minStep = 1;
  float maxStep = 64;
  bool euler = false;   ///< VD equations (6) and (7) instead of drift-kick-drift
  bool nearest = false; ///< n and grad n of the nearest voxel centre instead of trilinear ones
};

/// Distance from x along the unit vector d to the boundary of the aligned cube of 2^level voxels that holds `voxel`.
/// Axes along which d hardly moves do not count: a ray that glides in a face of cubes would stand still.
template <class F>
VOLCAUSTIC_HD inline F distanceToCubeFace(const Vec3<F>& x, const Vec3<F>& d, const Vec3<IntOf<F>>& voxel,
                                          const IntOf<F>& level) {
  using I = IntOf<F>;
  const I edge = powerOfTwo(level), below = ~(edge - I(1));
  const auto axis = [&](F xa, F da, I va) {
    const I low = va & below;
    const F face = toFloat(select(da > F(0), low + edge, low));
    return select(absOf(da) > F(1e-6f), (face - xa) * reciprocal(da), F(3.0e38f));
  };
  return smaller(axis(x.x, d.x, voxel.x), smaller(axis(x.y, d.y, voxel.y), axis(x.z, d.z, voxel.z)));
}

/// Step length at x along the unit vector d, from the step field's byte of the voxel that holds x.
template <class F>
VOLCAUSTIC_HD inline F stepLength(const FlatMedium& m, const MarchRules& rules, const Vec3<F>& x, const Vec3<F>& d,
                                  const Vec3<IntOf<F>>& voxel, const IntOf<F>& step) {
  using I = IntOf<F>;
  const auto capped = (step & I(kStepCappedBit)) != I(0);
  const F longest = select(capped, F(smaller(rules.maxStep, m.cap)), F(rules.maxStep));
  return clampTo(distanceToCubeFace(x, d, voxel, step & I(kStepLevelMask)), F(rules.minStep),
                 larger(longest, F(rules.minStep)));
}

template <class F>
VOLCAUSTIC_HD inline FieldSample<F> lookUp(const FlatMedium& m, const MarchRules& rules, const Vec3<F>& p) {
  return rules.nearest ? nearestField(m, p) : sampleField(m, p);
}

/// One step of arc length ds. With dtau = ds/n the ray equation is Newton's, d2x/dtau2 = grad(n^2)/2, with unit mass:
/// half a drift, the kick n grad n at the middle, half a drift is second order and symplectic. |v| stands for n in
/// dtau, which it equals along an exact path, so a step costs one lookup.
template <class F>
VOLCAUSTIC_HD inline RayOf<F> driftKickDrift(const FlatMedium& m, const MarchRules& rules, const RayOf<F>& r, F ds) {
  const F dtau = ds * inverseRoot(dot(r.v, r.v)), half = F(0.5f) * dtau;
  const Vec3<F> middle = mulAdd(r.v, half, r.x);
  const FieldSample<F> f = lookUp(m, rules, middle);
  const Vec3<F> v = mulAdd(f.gradient, dtau * f.n, r.v);
  return {mulAdd(v, half, middle), v};
}

/// VD equations (6) and (7): x += (ds/n) v, v += ds grad n, both from the old position.
template <class F>
VOLCAUSTIC_HD inline RayOf<F> eulerStep(const FlatMedium& m, const MarchRules& rules, const RayOf<F>& r, F ds) {
  const FieldSample<F> f = lookUp(m, rules, r.x);
  return {mulAdd(r.v, ds * reciprocal(f.n), r.x), mulAdd(f.gradient, ds, r.v)};
}

template <class F>
VOLCAUSTIC_HD inline RayOf<F> advance(const FlatMedium& m, const MarchRules& rules, const RayOf<F>& r, F ds) {
  return rules.euler ? eulerStep(m, rules, r, ds) : driftKickDrift(m, rules, r, ds);
}

template <class F>
VOLCAUSTIC_HD inline MaskOf<F> insideBox(const Int3& dims, const Vec3<F>& p) {
  const Vec3<F> high(F(static_cast<float>(dims.x)), F(static_cast<float>(dims.y)), F(static_cast<float>(dims.z)));
  const F low = smaller(p.x, smaller(p.y, p.z));
  const F beyond = larger(p.x - high.x, larger(p.y - high.y, p.z - high.z));
  return both(low >= F(0), beyond <= F(0));
}

/// Fraction of the chord from a (inside the box) to b at which it leaves the box; above 1 when it does not.
template <class F>
VOLCAUSTIC_HD inline F exitFraction(const Int3& dims, const Vec3<F>& a, const Vec3<F>& b) {
  const auto axis = [](F pa, F pb, int dim) {
    const F high(static_cast<float>(dim));
    const F low = select(pb < F(0), pa * reciprocal(pa - pb), F(2));
    return smaller(low, select(pb > high, (high - pa) * reciprocal(pb - pa), F(2)));
  };
  return smaller(axis(a.x, b.x, dims.x), smaller(axis(a.y, b.y, dims.y), axis(a.z, b.z, dims.z)));
}

/// A point moved onto or into the box.
template <class F>
VOLCAUSTIC_HD inline Vec3<F> clampToBox(const Int3& dims, const Vec3<F>& p) {
  return {clampTo(p.x, F(0), F(static_cast<float>(dims.x))), clampTo(p.y, F(0), F(static_cast<float>(dims.y))),
          clampTo(p.z, F(0), F(static_cast<float>(dims.z)))};
}

/// A step and what it did.
template <class F>
struct StepResult {
  RayOf<F> ray;
  F ds;             ///< arc length of the step
  MaskOf<F> leaves; ///< the ray is on a face of the box, about to leave
};

/// Distance from x, inside the box, along the unit vector d to the face of the box in front.
template <class F>
VOLCAUSTIC_HD inline F distanceToBoxFace(const Int3& dims, const Vec3<F>& x, const Vec3<F>& d) {
  const auto axis = [](F xa, F da, int dim) {
    const F face = select(da > F(0), F(static_cast<float>(dim)), F(0));
    return select(absOf(da) > F(1e-6f), (face - xa) * reciprocal(da), F(3.0e38f));
  };
  return larger(F(0), smaller(axis(x.x, d.x, dims.x), smaller(axis(x.y, d.y, dims.y), axis(x.z, d.z, dims.z))));
}

/// How far p lies beyond the box's nearest face; negative inside.
template <class F>
VOLCAUSTIC_HD inline F beyondBox(const Int3& dims, const Vec3<F>& p) {
  const auto axis = [](F pa, int dim) { return larger(-pa, pa - F(static_cast<float>(dim))); };
  return larger(axis(p.x, dims.x), larger(axis(p.y, dims.y), axis(p.z, dims.z)));
}

/// Advances by ds along `towards` (v's unit vector), or to the face of the box that the step would cross. Where light
/// bends on the way and the step still ends beyond the face, a shortened one is taken afresh from the same start, so
/// position and direction on the face are as accurate as any other.
template <class F>
VOLCAUSTIC_HD inline StepResult<F> advanceInBox(const FlatMedium& m, const MarchRules& rules, const RayOf<F>& r,
                                                const Vec3<F>& towards, F ds) {
  constexpr float kOnFace = 1e-3f; // voxels: this close to the face ahead is on it
  const F toFace = distanceToBoxFace(m.dims, r.x, towards);
  StepResult<F> s;
  s.ds = smaller(ds, toFace);
  s.ray = advance(m, rules, r, s.ds);
  F beyond = beyondBox(m.dims, s.ray.x);
  s.leaves = either(both(ds >= toFace, beyond > F(-kOnFace)), beyond > F(0));
  if (!any(s.leaves)) return s;
  for (int attempt = 0; attempt < 3; ++attempt) {
    const MaskOf<F> outside = beyond > F(kOnFace);
    if (!any(outside)) break;
    s.ds = select(outside, s.ds * larger(exitFraction(m.dims, r.x, s.ray.x), F(0)), s.ds);
    const RayOf<F> again = advance(m, rules, r, s.ds);
    s.ray = {select<F>(outside, again.x, s.ray.x), select<F>(outside, again.v, s.ray.v)};
    beyond = beyondBox(m.dims, s.ray.x);
  }
  s.ray.x = select<F>(s.leaves, clampToBox(m.dims, s.ray.x), s.ray.x);
  return s;
}

/// Entry and exit distances of the line o + t d through the box [0, dims]; entry > exit when it misses. Not clipped at
/// t = 0.
struct Span {
  double entry, exit;
};
VOLCAUSTIC_HD inline Span clipToBox(const Int3& dims, const Double3& o, const Double3& d) {
  Span s{-1e300, 1e300};
  const auto axis = [&](double oa, double da, int dim) {
    if (da == 0) {
      if (oa < 0 || oa > dim) s = {1, -1};
      return;
    }
    const double t0 = (0 - oa) / da, t1 = (dim - oa) / da;
    s.entry = larger(s.entry, smaller(t0, t1));
    s.exit = smaller(s.exit, larger(t0, t1));
  };
  axis(o.x, d.x, dims.x);
  axis(o.y, d.y, dims.y);
  axis(o.z, d.z, dims.z);
  return s;
}

} // namespace volcaustic::kernels
