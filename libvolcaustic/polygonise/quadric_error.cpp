#include "polygonise/quadric_error.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

/// Turns a symmetric matrix until it is diagonal (Jacobi); columns of `turned` are its eigenvectors.
void diagonalise(double (&m)[3][3], double (&turned)[3][3]) {
  constexpr int kSweeps = 12; // converges quadratically: six are enough for all of double precision
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const double off = std::abs(m[0][1]) + std::abs(m[0][2]) + std::abs(m[1][2]);
    if (off <= 1e-17 * (std::abs(m[0][0]) + std::abs(m[1][1]) + std::abs(m[2][2]))) return;
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (m[p][q] == 0) continue;
        const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
        const double t = std::copysign(1 / (std::abs(theta) + std::sqrt(theta * theta + 1)), theta);
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double kp = m[k][p], kq = m[k][q];
          m[k][p] = c * kp - s * kq;
          m[k][q] = s * kp + c * kq;
        }
        for (int k = 0; k < 3; ++k) {
          const double pk = m[p][k], qk = m[q][k];
          m[p][k] = c * pk - s * qk;
          m[q][k] = s * pk + c * qk;
        }
        for (auto& row : turned) {
          const double kp = row[p], kq = row[q];
          row[p] = c * kp - s * kq;
          row[q] = s * kp + c * kq;
        }
      }
  }
}

} // namespace

void PlaneDistances::add(const Vec3d& normal, double distance) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) mMatrix[i][j] += normal[i] * normal[j];
    mRight[i] += normal[i] * distance;
  }
}

Vec3d PlaneDistances::minimum(double least) const {
  double m[3][3], v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i < 3; ++i) std::copy_n(mMatrix[i], 3, m[i]);
  diagonalise(m, v);
  const double best = std::max({m[0][0], m[1][1], m[2][2]});
  Vec3d offset{0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    if (!(m[k][k] > least * best)) continue;
    const double along = (v[0][k] * mRight[0] + v[1][k] * mRight[1] + v[2][k] * mRight[2]) / m[k][k];
    for (int i = 0; i < 3; ++i) offset[i] += along * v[i][k];
  }
  return offset;
}

} // namespace volcaustic
