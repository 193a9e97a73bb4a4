// Exact rasterisation of straight segments: every voxel crossed, and the length inside it (Amanatides and Woo, "A fast
// voxel traversal algorithm for ray tracing", Eurographics 1987).
#pragma once

#include "kernels/flat_medium.h"

namespace volcaustic::test {

using kernels::clampTo;
using kernels::Int3;
using kernels::smaller;
using kernels::Vec3;

/// Walks cells of edge 2^log2 along o + t d from t0 to t1, d of any length. Calls visit(cell, tIn, tOut) for each, cell
/// in units of 2^log2 voxels, until visit returns false. Cells outside [0, cells) end the walk.
template <class Real, class Visit>
inline void traverse(const Vec3<Real>& o, const Vec3<Real>& d, Real t0, Real t1, const Int3& cells, int log2,
                     const Visit& visit) {
  const Real edge = static_cast<Real>(1 << log2);
  const Vec3<Real> start = o + d * t0;
  constexpr Real kNever = static_cast<Real>(1e30);
  Int3 cell, step;
  Vec3<Real> next, delta;
  const auto axis = [&](Real sa, Real oa, Real da, int count, std::int32_t& c, std::int32_t& s, Real& n, Real& dl) {
    c = clampTo(static_cast<int>(std::floor(sa / edge)), 0, count - 1);
    s = da > 0 ? 1 : -1;
    if (da == 0) {
      n = kNever;
      dl = 0;
      return;
    }
    // On a face the cell behind it may be picked; then `next` lies at t0 and the walk moves on without length.
    n = (static_cast<Real>(da > 0 ? c + 1 : c) * edge - oa) / da;
    dl = edge / std::abs(da);
  };
  axis(start.x, o.x, d.x, cells.x, cell.x, step.x, next.x, delta.x);
  axis(start.y, o.y, d.y, cells.y, cell.y, step.y, next.y, delta.y);
  axis(start.z, o.z, d.z, cells.z, cell.z, step.z, next.z, delta.z);

  Real t = t0;
  while (true) {
    const Real nearest = smaller(next.x, smaller(next.y, next.z));
    const Real tOut = smaller(nearest, t1);
    if (tOut > t) {
      if (!visit(cell, t, tOut)) return;
      t = tOut;
    }
    if (nearest >= t1) return;
    if (next.x <= nearest) {
      cell.x += step.x;
      next.x += delta.x;
      if (cell.x < 0 || cell.x >= cells.x) return;
    } else if (next.y <= nearest) {
      cell.y += step.y;
      next.y += delta.y;
      if (cell.y < 0 || cell.y >= cells.y) return;
    } else {
      cell.z += step.z;
      next.z += delta.z;
      if (cell.z < 0 || cell.z >= cells.z) return;
    }
  }
}

} // namespace volcaustic::test
