// Where in and around a pixel its samples lie: filter importance sampling (Ernst, Stamminger, Greiner, "Filter
// importance sampling", IEEE Symposium on Interactive Ray Tracing 2006). Samples are as dense as the reconstruction
// filter is high, so a pixel is their plain mean and depends on no other pixel's.
#pragma once

#include "kernels/vec.h"

namespace volcaustic::kernels {

/// A well-mixed function of a number (Wellons' lowbias32).
VOLCAUSTIC_HD inline std::uint32_t mixBits(std::uint32_t x) {
  x = (x ^ x >> 16) * 0x7feb352du;
  x = (x ^ x >> 15) * 0x846ca68bu;
  return x ^ x >> 16;
}

/// perSide^2 strata of the filter's square, one sample in each.
struct PixelSampler {
  static constexpr int kIntervals = 512;
  /// Distance from the pixel's centre, in pixels, below which i/kIntervals of the filter along an axis lies.
  float inverse[kIntervals + 1]{};
  std::int32_t perSide = 1;
  std::int32_t stride = 1; ///< from one sample's stratum to the next one's, without a common factor with perSide^2
  std::uint32_t seed = 0;

  struct Point {
    double column, row;
  };
  /// Sample s of a pixel, as a point of the raster. A single one is the pixel's centre; others are moved at random
  /// inside their strata, which are taken in an order that covers the square early. Few of them move little: noise
  /// would be seen more than regularity.
  [[nodiscard]] VOLCAUSTIC_HD Point point(std::int32_t column, std::int32_t row, std::int32_t s) const {
    if (perSide == 1) return {column + 0.5, row + 0.5};
    const auto count = static_cast<std::uint32_t>(perSide) * static_cast<std::uint32_t>(perSide);
    const std::uint32_t pixel =
        mixBits(mixBits(static_cast<std::uint32_t>(column) ^ seed) + static_cast<std::uint32_t>(row));
    const std::uint32_t stratum =
        (static_cast<std::uint32_t>(s) * static_cast<std::uint32_t>(stride) + pixel % count) % count;
    const std::uint32_t random = mixBits(pixel + stratum);
    const auto along = [this](std::uint32_t cell, std::uint32_t bits) {
      const float move = (static_cast<float>(bits) + 0.5f) * 0x1p-16f - 0.5f;
      const float most = smaller(static_cast<float>(perSide) * (1 / 8.0f), 1.0f);
      return quantile((static_cast<float>(cell) + 0.5f + move * most) / static_cast<float>(perSide));
    };
    const auto side = static_cast<std::uint32_t>(perSide);
    return {column + 0.5 + along(stratum % side, random & 0xffff), row + 0.5 + along(stratum / side, random >> 16)};
  }

private:
  [[nodiscard]] VOLCAUSTIC_HD double quantile(float u) const {
    const float at = u * kIntervals;
    const std::int32_t i = smaller(static_cast<std::int32_t>(at), kIntervals - 1);
    return inverse[i] + (at - static_cast<float>(i)) * (inverse[i + 1] - inverse[i]);
  }
};

} // namespace volcaustic::kernels
