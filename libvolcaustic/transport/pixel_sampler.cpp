#include "transport/pixel_sampler.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

namespace volcaustic {

namespace {

double radiusOf(PixelFilter filter) {
  switch (filter) {
  case PixelFilter::Box:
    return 0.5;
  case PixelFilter::Tent:
    return 1;
  case PixelFilter::Gaussian:
  case PixelFilter::BlackmanHarris:
    return 1.5;
  }
  return 0.5;
}

/// The filter along one axis, at a distance from the pixel's centre, to any scale. None is negative.
double weight(PixelFilter filter, double x) {
  const double radius = radiusOf(filter);
  switch (filter) {
  case PixelFilter::Box:
    return 1;
  case PixelFilter::Tent:
    return 1 - std::abs(x);
  case PixelFilter::Gaussian:
    return std::exp(-2 * x * x) - std::exp(-2 * radius * radius);
  case PixelFilter::BlackmanHarris: {
    // Harris, "On the use of windows for harmonic analysis", 1978: the minimum of four terms.
    const double t = std::numbers::pi * (x / radius + 1);
    return 0.35875 - 0.48829 * std::cos(t) + 0.14128 * std::cos(2 * t) - 0.01168 * std::cos(3 * t);
  }
  }
  return 1;
}

/// Strata taken a golden section of all of them apart lie far from each other early on.
std::int32_t strideOf(std::int32_t strata) {
  auto stride = static_cast<std::int32_t>(std::lround(strata / std::numbers::phi));
  while (std::gcd(stride, strata) != 1) ++stride;
  return stride;
}

} // namespace

kernels::PixelSampler pixelSampler(PixelFilter filter, int side, std::uint64_t seed) {
  constexpr int kCells = 4096;
  const double radius = radiusOf(filter), cell = 2 * radius / kCells;
  std::vector<double> below(kCells + 1, 0.0);
  for (int i = 0; i < kCells; ++i) below[i + 1] = below[i] + weight(filter, (i + 0.5) * cell - radius);

  kernels::PixelSampler sampler;
  constexpr int kIntervals = kernels::PixelSampler::kIntervals;
  sampler.inverse[0] = static_cast<float>(-radius);
  for (int k = 1, i = 0; k < kIntervals; ++k) {
    const double wanted = below.back() * k / kIntervals;
    while (below[i + 1] < wanted) ++i;
    sampler.inverse[k] = static_cast<float>((i + (wanted - below[i]) / (below[i + 1] - below[i])) * cell - radius);
  }
  sampler.inverse[kIntervals] = static_cast<float>(radius);
  sampler.perSide = side;
  sampler.stride = strideOf(side * side);
  sampler.seed =
      kernels::mixBits(static_cast<std::uint32_t>(seed) ^ kernels::mixBits(static_cast<std::uint32_t>(seed >> 32)));
  return sampler;
}

} // namespace volcaustic
