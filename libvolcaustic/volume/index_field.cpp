#include "volume/index_field.h"

#include "core/simd_clones.h"
#include "kernels/index_taps.h"

#include <algorithm>

namespace volcaustic {

namespace {

/// Both for `count` places in a row.
template <int Stride>
inline void tapBoth(const float* __restrict in, int count, float* __restrict values, float* __restrict slopes) {
  for (int i = 0; i < count; ++i) values[i] = kernels::valueTap<Stride>(in + i);
  for (int i = 0; i < count; ++i) slopes[i] = kernels::slopeTap<Stride>(in + i);
}
template <int Stride>
inline void tapValue(const float* __restrict in, int count, float* __restrict values) {
  for (int i = 0; i < count; ++i) values[i] = kernels::valueTap<Stride>(in + i);
}

template <int Plane, int Row>
inline void markCurved(const float* __restrict in, int count, std::uint8_t* __restrict curved) {
  for (int i = 0; i < count; ++i) curved[i] = kernels::curvedAt<Plane, Row>(in + i) ? kernels::kStepBendsBit : 0;
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
         kernels::kFlatIndex;
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
