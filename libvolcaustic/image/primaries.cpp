#include "image/primaries.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

using Vector = std::array<double, 3>;
using Matrix = std::array<Vector, 3>; // rows

constexpr std::array<float, 8> kRec709{0.64F, 0.33F, 0.30F, 0.60F, 0.15F, 0.06F, 0.3127F, 0.3290F};

/// Cone responses: K. M. Lam, Metamerism and colour constancy, University of Bradford, 1985.
constexpr Matrix kBradford{{{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};

Vector operator*(const Matrix& m, const Vector& v) {
  Vector result{};
  for (int r = 0; r < 3; ++r) result[r] = m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2];
  return result;
}

Matrix operator*(const Matrix& a, const Matrix& b) {
  Matrix result{};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k) result[r][c] += a[r][k] * b[k][c];
  return result;
}

/// Numbers that are not finite where there is none.
Matrix inverse(const Matrix& m) {
  const auto minor = [&](int r, int c) {
    const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    return m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
  };
  const double determinant = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
  Matrix result;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) result[r][c] = minor(c, r) / determinant;
  return result;
}

Vector xyz(float x, float y) { return {double(x) / y, 1, (1 - double(x) - y) / y}; }

template <class Chromaticities>
Matrix xyzFromRgb(const Chromaticities& p) {
  Matrix m{};
  for (int c = 0; c < 3; ++c) {
    const Vector primary = xyz(p[2 * c], p[2 * c + 1]);
    for (int r = 0; r < 3; ++r) m[r][c] = primary[r];
  }
  const Vector amounts = inverse(m) * xyz(p[6], p[7]);
  for (Vector& row : m)
    for (int c = 0; c < 3; ++c) row[c] *= amounts[c];
  return m;
}

} // namespace

std::optional<ColourMatrix> rec709From(const std::vector<float>& chromaticities) {
  constexpr float kSame = 1e-3F; // 0.3127 is written with four places by some
  const auto same = [](float a, float b) { return std::abs(a - b) < kSame; };
  if (chromaticities.size() != kRec709.size() ||
      std::equal(kRec709.begin(), kRec709.end(), chromaticities.begin(), same))
    return std::nullopt;
  const Vector from = kBradford * xyz(chromaticities[6], chromaticities[7]),
               to = kBradford * xyz(kRec709[6], kRec709[7]);
  Matrix adaptation{};
  for (int i = 0; i < 3; ++i) adaptation[i][i] = to[i] / from[i];
  const Matrix whole =
      inverse(xyzFromRgb(kRec709)) * inverse(kBradford) * adaptation * kBradford * xyzFromRgb(chromaticities);
  ColourMatrix result;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      if (!std::isfinite(whole[r][c])) return std::nullopt;
      result[r][c] = static_cast<float>(whole[r][c]);
    }
  return result;
}

} // namespace volcaustic
