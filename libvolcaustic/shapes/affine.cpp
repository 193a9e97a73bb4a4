#include "shapes/affine.h"

#include "shapes/symmetric.h"

#include <cmath>

namespace volcaustic {

double determinant(const Affine& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

double leastStretch(const Affine& m) {
  // Stretches are the roots of the eigenvalues of M^T M.
  Symmetric3 square{};
  constexpr int kRows[] = {0, 1, 2, 0, 1, 2}, kColumns[] = {0, 1, 2, 1, 2, 0};
  for (int k = 0; k < 6; ++k)
    for (int i = 0; i < 3; ++i) square[k] += m[i][kRows[k]] * m[i][kColumns[k]];
  // The least one is the product of all by the others: as a difference it would lose digits.
  const std::array<double, 3> values = eigenvalues(square);
  return std::abs(determinant(m)) / std::sqrt(values[0] * values[1]);
}

Affine inverse(const Affine& m) {
  const auto minor = [&](int i, int j) {
    const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
    return m[a][c] * m[b][d] - m[a][d] * m[b][c];
  };
  const double d = determinant(m);
  Affine r{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r[i][j] = minor(j, i) / d;
    r[i][3] = -(r[i][0] * m[0][3] + r[i][1] * m[1][3] + r[i][2] * m[2][3]);
  }
  return r;
}

Affine product(const Affine& outer, const Affine& inner) {
  Affine r{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 3; ++k) r[i][j] += outer[i][k] * inner[k][j];
    r[i][3] += outer[i][3];
  }
  return r;
}

} // namespace volcaustic
