#include "transport/footprint.h"

#include <algorithm>

namespace volcaustic {

using kernels::dot;
using kernels::Double3;

Footprint footprint(const kernels::EmissionFrame& frame, const Double3& low, double size) {
  double u0 = 1e300, u1 = -1e300, v0 = 1e300, v1 = -1e300, nearest = 1e300, farthest = -1e300;
  const Double3 fromLight = low - frame.origin;
  for (int i = 0; i < 8; ++i) {
    const Double3 r = fromLight + Double3(i & 1 ? size : 0, i & 2 ? size : 0, i & 4 ? size : 0);
    double u = dot(r, frame.axisU), v = dot(r, frame.axisV), depth = dot(r, frame.axisW);
    if (frame.point) {
      if (depth <= 0) {
        // Partly beside the light: take the whole raster on that side.
        u = u > 0 ? 1e9 : -1e9;
        v = v > 0 ? 1e9 : -1e9;
      } else {
        const double inverse = 1 / depth;
        u *= inverse;
        v *= inverse;
      }
      depth = dot(r, r); // its root is taken below
    }
    u0 = std::min(u0, u);
    u1 = std::max(u1, u);
    v0 = std::min(v0, v);
    v1 = std::max(v1, v);
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  if (frame.point) {
    // A cube is nearer to a point at its faces than at its corners.
    const auto toFace = [size](double r) { return std::max({r, -r - size, 0.0}); };
    nearest = kernels::length(Double3(toFace(fromLight.x), toFace(fromLight.y), toFace(fromLight.z)));
    farthest = std::sqrt(farthest);
  }
  const auto cell = [](double at, int count) {
    return static_cast<int>(kernels::clampTo(std::floor(at), 0.0, double(count)));
  };
  return {cell((u0 - frame.u0) / frame.du, frame.columns),
          cell((u1 - frame.u0) / frame.du + 1, frame.columns),
          cell((v0 - frame.v0) / frame.dv, frame.rows),
          cell((v1 - frame.v0) / frame.dv + 1, frame.rows),
          nearest - frame.depth0,
          farthest - frame.depth0};
}

} // namespace volcaustic
