// The filters of the index along one axis, for a place in an array whose neighbours are `Stride` numbers apart. Both
// machines take these bodies, and neither fuses a product with a sum, so they agree to the bit.
#pragma once

#include "kernels/vec.h"

namespace volcaustic::kernels {

/// Changes of n under this between voxels are rounding, not refraction: a ray that meets it all along 256 voxels turns
/// by 0.015 degrees.
inline constexpr float kFlatIndex = 1e-6f;

/// p[0] + sum over t of w_t ((p[-t] + p[t]) - 2 p[0]): a convolution whose weights sum to exactly 1, so that constants
/// keep their bits. weights[0] is that of the first neighbours.
template <int Radius, int Stride>
VOLCAUSTIC_HD inline float blurTap(const float* p, const float* weights) {
  float sum = p[0];
  for (int t = 1; t <= Radius; ++t) sum += weights[t - 1] * ((p[-t * Stride] + p[t * Stride]) - 2 * p[0]);
  return sum;
}

// From p[-3 Stride] to p[3 Stride], written in differences, so that a constant gives itself and a slope of exactly
// zero.
//
// Between samples f, linear interpolation lies above a convex function by h^2 f''/12 on average. Taking that off the
// samples, f - (second difference)/12 along each axis, leaves an error that alternates in sign along a path instead of
// adding up. The gradient is the central difference of fourth order, (8 (f1 - f-1) - (f2 - f-2))/12, treated in the
// same way.
template <int Stride>
VOLCAUSTIC_HD inline float valueTap(const float* p) {
  return p[0] - ((p[Stride] - p[0]) + (p[-Stride] - p[0])) * (1 / 12.f);
}
template <int Stride>
VOLCAUSTIC_HD inline float slopeTap(const float* p) {
  return ((p[Stride] - p[-Stride]) * 113 - (p[2 * Stride] - p[-2 * Stride]) * 22 + (p[3 * Stride] - p[-3 * Stride])) *
         (1 / 144.f);
}

/// Whether the place itself and two on either side along each axis differ.
template <int Plane, int Row>
VOLCAUSTIC_HD inline bool curvedAt(const float* p) {
  float low = p[0], high = p[0];
  for (const int offset : {-2 * Plane, -Plane, Plane, 2 * Plane, -2 * Row, -Row, Row, 2 * Row, -2, -1, 1, 2}) {
    low = smaller(low, p[offset]);
    high = larger(high, p[offset]);
  }
  return high - low > kFlatIndex;
}

} // namespace volcaustic::kernels
