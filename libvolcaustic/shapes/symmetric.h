// Symmetric matrices of three rows.
#pragma once

#include <array>

namespace volcaustic {

/// xx, yy, zz, xy, yz, zx.
using Symmetric3 = std::array<double, 6>;

constexpr double entry(const Symmetric3& a, int i, int j) {
  if (i == j) return a[i];
  return a[i + j == 1 ? 3 : i + j == 3 ? 4 : 5];
}

/// Its eigenvalues, greatest first, by Smith's closed form (Eigenvalues of a symmetric 3x3 matrix, 1961).
std::array<double, 3> eigenvalues(const Symmetric3& a);

} // namespace volcaustic
