#include "image/plane_filter.h"

#include "core/parallel.h"
#include "core/simd_clones.h"

#include <algorithm>

namespace volcaustic {

namespace {

constexpr std::int64_t kRowsAtOnce = 16;

VOLCAUSTIC_SIMD_CLONES void addScaled(float* __restrict sum, const float* __restrict values, float weight,
                                      std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) sum[i] += weight * values[i];
}

/// Of one row, from a copy of it that is wider by the filter's reach on either side.
void filterRow(float* row, std::size_t width, const FilterWeights& weights, std::vector<float>& wide) {
  const std::size_t reach = weights.size() / 2;
  wide.assign(width + 2 * reach, row[0]);
  std::copy_n(row, width, wide.begin() + static_cast<std::ptrdiff_t>(reach));
  std::fill_n(wide.end() - static_cast<std::ptrdiff_t>(reach), reach, row[width - 1]);
  std::fill_n(row, width, 0.0F);
  for (std::size_t k = 0; k < weights.size(); ++k) addScaled(row, wide.data() + k, weights[k], width);
}

} // namespace

Plane filtered(const Plane& plane, PlaneSize size, const FilterWeights& alongX, const FilterWeights& alongY,
               const RunContext& ctx) {
  const auto rows = static_cast<std::int64_t>(size.height);
  Plane sideways(plane), result(plane.size(), 0.0F);
  parallelFor(rows, kRowsAtOnce, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    std::vector<float> wide;
    for (std::int64_t y = begin; y < end; ++y)
      filterRow(sideways.data() + static_cast<std::size_t>(y) * size.width, size.width, alongX, wide);
  });
  const auto reach = static_cast<std::int64_t>(alongY.size() / 2);
  parallelFor(rows, kRowsAtOnce, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t y = begin; y < end; ++y)
      for (std::size_t k = 0; k < alongY.size(); ++k) {
        const std::int64_t from = std::clamp<std::int64_t>(y + static_cast<std::int64_t>(k) - reach, 0, rows - 1);
        addScaled(result.data() + static_cast<std::size_t>(y) * size.width,
                  sideways.data() + static_cast<std::size_t>(from) * size.width, alongY[k], size.width);
      }
  });
  return result;
}

} // namespace volcaustic
