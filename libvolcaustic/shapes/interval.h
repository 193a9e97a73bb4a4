// Bounds of what a function takes over a box.
#pragma once

#include "volcaustic/shape.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

/// Relative to the magnitudes that were added up; some hundred roundings fit in.
inline constexpr double kRoundingSlack = 4e-14;

inline Interval operator+(const Interval& a, const Interval& b) { return {a.low + b.low, a.high + b.high}; }
inline Interval operator-(const Interval& a) { return {-a.high, -a.low}; }
inline Interval widened(const Interval& a, double by) { return {a.low - by, a.high + by}; }
inline double magnitude(const Interval& a) { return std::max(std::abs(a.low), std::abs(a.high)); }
inline Interval united(const Interval& a, const Interval& b) {
  return {std::min(a.low, b.low), std::max(a.high, b.high)};
}
inline Interval operator*(const Interval& a, const Interval& b) {
  const auto [low, high] = std::minmax({a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high});
  return {low, high};
}
inline Interval square(const Interval& a) {
  const double low = a.low * a.low, high = a.high * a.high;
  return {a.low <= 0 && a.high >= 0 ? 0 : std::min(low, high), std::max(low, high)};
}

} // namespace volcaustic
