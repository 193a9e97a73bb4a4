#include "volume/index_field.h"

#include "core/simd_clones.h"

#include <algorithm>

namespace volcaustic {

namespace {

// One tap at p[0] from p[-3 stride] to p[3 stride]. Written in differences, so that a constant gives itself and a slope
// of exactly zero.
//
// Between samples f, linear interpolation lies above a convex function by h^2 f''/12 on average. Taking that off the
// samples, f - (second difference)/12 along each axis, leaves an error that alternates in sign along a path instead of
// adding up. The gradient is the central difference of fourth order, (8 (f1 - f-1) - (f2 - f-2))/12, treated in the
// same way.
template <int Stride>
inline float value(const float* p) {
  return p[0] - ((p[Stride] - p[0]) + (p[-Stride] - p[0])) * (1 / 12.f);
}
template <int Stride>
inline float slope(const float* p) {
  return ((p[Stride] - p[-Stride]) * 113 - (p[2 * Stride] - p[-2 * Stride]) * 22 + (p[3 * Stride] - p[-3 * Stride])) *
         (1 / 144.f);
}

/// Both for `count` places in a row.
template <int Stride>
inline void tapBoth(const float* __restrict in, int count, float* __restrict values, float* __restrict slopes) {
  for (int i = 0; i < count; ++i) values[i] = value<Stride>(in + i);
  for (int i = 0; i < count; ++i) slopes[i] = slope<Stride>(in + i);
}
template <int Stride>
inline void tapValue(const float* __restrict in, int count, float* __restrict values) {
  for (int i = 0; i < count; ++i) values[i] = value<Stride>(in + i);
}

/// Least and greatest of the places themselves and of two on either side along each axis; then whether they differ.
template <int Plane, int Row>
inline void markCurved(const float* __restrict in, int count, std::uint8_t* __restrict curved) {
  for (int i = 0; i < count; ++i) {
    float low = in[i], high = in[i];
    for (const int offset : {-2 * Plane, -Plane, Plane, 2 * Plane, -2 * Row, -Row, Row, 2 * Row, -2, -1, 1, 2}) {
      low = std::min(low, in[i + offset]);
      high = std::max(high, in[i + offset]);
    }
    curved[i] = high - low > IndexField::kFlat ? kernels::kStepBendsBit : 0;
  }
}

inline void anyOfThree(const std::uint8_t* __restrict in, int stride, int count, std::uint8_t* __restrict out) {
  for (int i = 0; i < count; ++i) out[i] = in[i] | in[i + stride] | in[i + 2 * stride];
}

} // namespace

VOLCAUSTIC_SIMD_CLONES bool IndexField::flat() const {
  std::array<float, kRow> low, high;
  const float* p = mBlock.data();
  std::copy_n(p, kRow, low.begin());
  high = low;
  for (int row = 1; row < Block::kEdge * Block::kEdge; ++row) {
    p += kRow;
    for (int i = 0; i < kRow; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  }
  // The last of a row is padding.
  return *std::max_element(high.begin(), high.begin() + Block::kEdge) -
             *std::min_element(low.begin(), low.begin() + Block::kEdge) <
         kFlat;
}

VOLCAUSTIC_SIMD_CLONES void IndexField::filter(kernels::FieldVoxel* out) {
  constexpr int kRows = kEdge * kEdge;
  Partial& p = mPartial;
  const float* block = mBlock.data();
  tapBoth<kPlane>(block + Block::place(0, -3, -3), kEdge * kPlane, p.v.data(), p.s.data());
  for (int x = 0; x < kEdge; ++x) {
    const int from = x * kPlane + 3 * kRow, to = x * kEdge * kRow;
    tapBoth<kRow>(&p.v[from], kEdge * kRow, &p.vv[to], &p.vs[to]);
    tapValue<kRow>(&p.s[from], kEdge * kRow, &p.sv[to]);
  }
  tapBoth<1>(p.vv.data() + 3, kRows * kRow, p.vvv.data(), p.vvs.data());
  tapValue<1>(p.vs.data() + 3, kRows * kRow, p.vsv.data());
  tapValue<1>(p.sv.data() + 3, kRows * kRow, p.svv.data());
  for (int row = 0; row < kRows; ++row)
    for (int z = 0, i = row * kRow; z < kEdge; ++z, ++i) *out++ = {p.vvv[i], p.svv[i], p.vsv[i], p.vvs[i]};
}

VOLCAUSTIC_SIMD_CLONES void IndexField::findBends(std::span<std::uint8_t, kBrickVoxels> bends) {
  constexpr int kReachPlane = kReach * kRow;
  Partial& p = mPartial;
  // Voxels at which the gradient is not zero (the filter's outermost weight, 1/144, aside).
  for (int x = 0; x < kReach; ++x)
    markCurved<kPlane, kRow>(mBlock.data() + Block::place(x - 1, -1, -1), kReachPlane, &p.curved[x * kReachPlane]);
  anyOfThree(p.curved.data(), 1, kReach * kReachPlane, p.alongZ.data());
  for (int x = 0; x < kReach; ++x)
    anyOfThree(&p.alongZ[x * kReachPlane], kRow, kBrickSize * kRow, &p.alongY[x * kReachPlane]);
  for (int x = 0; x < kBrickSize; ++x)
    for (int y = 0; y < kBrickSize; ++y)
      anyOfThree(&p.alongY[x * kReachPlane + y * kRow], kReachPlane, kBrickSize, &bends[brickOffset(x, y, 0)]);
}

} // namespace volcaustic
