// The step of a ray of geometric optics, d/ds(n dx/ds) = grad n, through a flat medium.
#pragma once

#include "kernels/flat_medium.h"

namespace volcaustic::kernels {

/// A ray's state: position and optical momentum v = n dx/ds, grid space.
struct Ray {
  Float3 x;
  Float3 v;
};

/// How long steps may be, in voxels, and which scheme carries them.
struct MarchRules {
  float minStep = 1;
  float maxStep = 64;
  bool euler = false; ///< VD equations (6) and (7) instead of drift-kick-drift
};

/// Distance from x along the unit vector d to the boundary of the aligned cube of 2^level voxels that holds `voxel`.
/// Axes along which d hardly moves do not count: a ray that glides in a face of cubes would stand still.
VOLCAUSTIC_HD inline float distanceToCubeFace(const Float3& x, const Float3& d, const Int3& voxel, int level) {
  float t = 3.0e38f;
  const auto axis = [&](float xa, float da, int va) {
    const int low = (va >> level) << level;
    const float face = static_cast<float>(da > 0 ? low + (1 << level) : low);
    if (std::abs(da) > 1e-6f) t = smaller(t, (face - xa) / da);
  };
  axis(x.x, d.x, voxel.x);
  axis(x.y, d.y, voxel.y);
  axis(x.z, d.z, voxel.z);
  return t;
}

/// Step length at x along the unit vector d, from the step field's byte of the voxel that holds x.
VOLCAUSTIC_HD inline float stepLength(const FlatMedium& m, const MarchRules& rules, const Float3& x, const Float3& d,
                                      const Int3& voxel, std::uint8_t step) {
  float longest = rules.maxStep;
  if (step & kStepCappedBit) longest = smaller(longest, m.cap);
  return clampTo(distanceToCubeFace(x, d, voxel, step & kStepLevelMask), rules.minStep, larger(longest, rules.minStep));
}

/// One step of arc length ds. With dtau = ds/n the ray equation is Newton's, d2x/dtau2 = grad(n^2)/2, with unit mass:
/// half a drift, the kick n grad n at the middle, half a drift is second order and symplectic. |v| stands for n in
/// dtau, which it equals along an exact path, so a step costs one lookup.
VOLCAUSTIC_HD inline Ray driftKickDrift(const FlatMedium& m, const Ray& r, float ds) {
  const float dtau = ds / length(r.v);
  const Float3 middle = r.x + r.v * (0.5f * dtau);
  const FieldSample f = sampleField(m, middle);
  const Float3 v = r.v + f.gradient * (dtau * f.n);
  return {middle + v * (0.5f * dtau), v};
}

/// VD equations (6) and (7): x += (ds/n) v, v += ds grad n, both from the old position.
VOLCAUSTIC_HD inline Ray eulerStep(const FlatMedium& m, const Ray& r, float ds) {
  const FieldSample f = sampleField(m, r.x);
  return {r.x + r.v * (ds / f.n), r.v + f.gradient * ds};
}

VOLCAUSTIC_HD inline Ray advance(const FlatMedium& m, const MarchRules& rules, const Ray& r, float ds) {
  return rules.euler ? eulerStep(m, r, ds) : driftKickDrift(m, r, ds);
}

VOLCAUSTIC_HD inline bool insideBox(const Int3& dims, const Float3& p) {
  return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x <= static_cast<float>(dims.x) && p.y <= static_cast<float>(dims.y) &&
         p.z <= static_cast<float>(dims.z);
}

/// Fraction of the chord from a (inside the box) to b at which it leaves the box; above 1 when it does not.
VOLCAUSTIC_HD inline float exitFraction(const Int3& dims, const Float3& a, const Float3& b) {
  float t = 2;
  const auto axis = [&](float pa, float pb, int dim) {
    const float high = static_cast<float>(dim);
    if (pb < 0) t = smaller(t, pa / (pa - pb));
    if (pb > high) t = smaller(t, (high - pa) / (pb - pa));
  };
  axis(a.x, b.x, dims.x);
  axis(a.y, b.y, dims.y);
  axis(a.z, b.z, dims.z);
  return t;
}

/// A step and what it did.
struct StepResult {
  Ray ray;
  float ds = 0;        ///< arc length of the step
  bool leaves = false; ///< the ray is on a face of the box, about to leave
};

/// Advances by ds, or exactly to the face of the box that the step would cross: the shortened step is taken afresh from
/// its start, so position and direction on the face are as accurate as any other.
VOLCAUSTIC_HD inline StepResult advanceInBox(const FlatMedium& m, const MarchRules& rules, const Ray& r, float ds) {
  StepResult s{advance(m, rules, r, ds), ds, false};
  for (int attempt = 0; attempt < 3 && !insideBox(m.dims, s.ray.x); ++attempt) {
    s.leaves = true;
    s.ds *= larger(exitFraction(m.dims, r.x, s.ray.x), 0.0f);
    s.ray = advance(m, rules, r, s.ds);
  }
  if (!s.leaves) return s;
  s.ray.x = Float3(clampTo(s.ray.x.x, 0.0f, static_cast<float>(m.dims.x)),
                   clampTo(s.ray.x.y, 0.0f, static_cast<float>(m.dims.y)),
                   clampTo(s.ray.x.z, 0.0f, static_cast<float>(m.dims.z)));
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
