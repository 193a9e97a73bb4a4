#include "volcaustic/placement.h"

#include <cmath>
#include <numbers>

namespace volcaustic {

namespace {

using Matrix = std::array<Vec3d, 3>;

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) c[i][j] += a[i][k] * b[k][j];
  return c;
}

/// Counter-clockwise rotation about a coordinate axis, seen from its tip. Quarter turns are exact.
Matrix rotation(int axis, double degrees) {
  constexpr double kQuarterCosine[] = {1, 0, -1, 0};
  const double quarters = degrees / 90;
  double c = std::cos(degrees * (std::numbers::pi / 180)), s = std::sin(degrees * (std::numbers::pi / 180));
  if (quarters == std::round(quarters)) {
    const int quarter = static_cast<int>(std::fmod(std::fmod(quarters, 4) + 4, 4));
    c = kQuarterCosine[quarter];
    s = kQuarterCosine[(quarter + 3) % 4];
  }
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  Matrix m{};
  m[axis][axis] = 1;
  m[u][u] = m[v][v] = c;
  m[v][u] = s;
  m[u][v] = -s;
  return m;
}

} // namespace

Affine affine(const Placement& placement) {
  const Matrix turn = product(rotation(2, placement.rotate[2]),
                              product(rotation(1, placement.rotate[1]), rotation(0, placement.rotate[0])));
  const auto& [xy, xz, yz] = placement.shear;
  Affine result{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result[i][j] = turn[i][j] * placement.scale[j];
    result[i][2] += result[i][0] * xz + result[i][1] * yz;
    result[i][1] += result[i][0] * xy;
    result[i][3] = placement.translate[i];
  }
  return result;
}

} // namespace volcaustic
