// Pixels: what one is made of, and the layers of a picture.
#pragma once

#include "kernels/lanes.h"

#include <limits>

namespace volcaustic::kernels {

/// What a pixel is made of; radiance in W/(m2 sr), depth in voxels.
template <class F>
struct PixelSumOf {
  Vec3<F> caustic{F(0), F(0), F(0)}, direct{F(0), F(0), F(0)}, background{F(0), F(0), F(0)}, receiver{F(0), F(0), F(0)},
      transmittance{F(0), F(0), F(0)};
  F depth{3.0e38f};
  F steps{0};
};
using PixelSum = PixelSumOf<float>;

/// The layers of a picture, each a plane of as many numbers as there are pixels: R G B of the whole, opacity, R G B of
/// caustic, direct, background, receivers and transmittance, depth, steps.
inline constexpr int kPixelPlanes = 21, kDepthPlane = 19;
struct PixelPlanes {
  float* of[kPixelPlanes];
  float* spread = nullptr; ///< of each pixel's luminance: sum of squares about the mean; null where nobody asks
  float voxelSize = 1;

  /// Calls put(plane, value) for each.
  template <class F, class Put>
  VOLCAUSTIC_HD void forEach(const PixelSumOf<F>& p, const Put& put) const {
    int plane = 0;
    const auto putRgb = [&](const Vec3<F>& v) {
      put(plane++, v.x);
      put(plane++, v.y);
      put(plane++, v.z);
    };
    putRgb(p.caustic + p.direct + p.background + p.receiver);
    put(plane++, F(1) - (p.transmittance.x + p.transmittance.y + p.transmittance.z) * F(1 / 3.0f));
    putRgb(p.caustic);
    putRgb(p.direct);
    putRgb(p.background);
    putRgb(p.receiver);
    putRgb(p.transmittance);
    put(plane++, select(p.depth < F(1e38f), p.depth * F(voxelSize), F(std::numeric_limits<float>::infinity())));
    put(plane++, p.steps);
  }

  /// Takes sample number `index` of pixels side by side into their means (the depth is the least), after those before
  /// it. numbers(plane) points at the samples' numbers for a plane.
  template <class Numbers>
  VOLCAUSTIC_HD void add(std::int64_t pixel, std::int32_t count, std::int32_t index, const Numbers& numbers) const {
    const float weight = 1 / static_cast<float>(index + 1);
    if (spread)
      for (std::int32_t i = 0; i < count; ++i) {
        const auto colour = [i](const float* r, const float* g, const float* b) { return Float3(r[i], g[i], b[i]); };
        const float l = luminance(colour(numbers(0), numbers(1), numbers(2))),
                    before = luminance(colour(of[0] + pixel, of[1] + pixel, of[2] + pixel)), more = l - before;
        spread[pixel + i] = index == 0 ? 0 : spread[pixel + i] + more * (more - more * weight);
      }
    for (int plane = 0; plane < kPixelPlanes; ++plane) {
      float* to = of[plane] + pixel;
      const float* from = numbers(plane);
      if (index == 0)
        for (std::int32_t i = 0; i < count; ++i) to[i] = from[i];
      else if (plane == kDepthPlane)
        for (std::int32_t i = 0; i < count; ++i) to[i] = smaller(to[i], from[i]);
      else
        for (std::int32_t i = 0; i < count; ++i) to[i] += (from[i] - to[i]) * weight;
    }
  }
};

} // namespace volcaustic::kernels
