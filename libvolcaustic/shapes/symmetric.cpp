#include "shapes/symmetric.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace volcaustic {

std::array<double, 3> eigenvalues(const Symmetric3& a) {
  const double mean = (a[0] + a[1] + a[2]) / 3;
  const double off = a[3] * a[3] + a[4] * a[4] + a[5] * a[5];
  const double x = a[0] - mean, y = a[1] - mean, z = a[2] - mean;
  const double p = std::sqrt((x * x + y * y + z * z + 2 * off) / 6);
  if (p == 0) return {mean, mean, mean};
  const double det = x * (y * z - a[4] * a[4]) - a[3] * (a[3] * z - a[4] * a[5]) + a[5] * (a[3] * a[4] - y * a[5]);
  const double angle = std::acos(std::clamp(det / p / p / p / 2, -1.0, 1.0)) / 3;
  const double high = mean + 2 * p * std::cos(angle);
  const double low = mean + 2 * p * std::cos(angle + 2 * std::numbers::pi / 3);
  return {high, 3 * mean - high - low, low};
}

} // namespace volcaustic
