// Points and results side by side, as loops over them become SIMD by themselves (core/simd_clones.h).
#pragma once

#include <array>

namespace volcaustic {

/// What is evaluated at once: enough that the cost of walking a program is shared, few enough to stay in cache.
inline constexpr int kShapeBatch = 256;

/// At most kShapeBatch points, world or local.
struct ShapePoints {
  const double* x;
  const double* y;
  const double* z;
  int count;
};

using BatchNumbers = std::array<double, kShapeBatch>;

/// Values of a function at as many points, and its gradient where asked for.
struct ShapeValues {
  double* value;
  double* gradient[3]; ///< all null where only values are wanted

  [[nodiscard]] bool wantsGradient() const { return gradient[0] != nullptr; }
};

} // namespace volcaustic
