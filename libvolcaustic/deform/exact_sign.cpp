#include "deform/exact_sign.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace volcaustic {

namespace {

// Exact numbers as sums of doubles that do not overlap, in ascending order of size (expansions: Dekker 1971, Priest
// 1991, Shewchuk 1997). Sums and products of them are exact; the sign is that of the last term.

/// a + b = sum + error, exactly.
struct TwoTerms {
  double error, sum;
};
TwoTerms exactSum(double a, double b) {
  const double sum = a + b, bPart = sum - a, aPart = sum - bPart;
  return {(a - aPart) + (b - bPart), sum};
}
TwoTerms exactProduct(double a, double b) {
  const auto split = [](double x) {
    const double scaled = 134217729 * x, high = scaled - (scaled - x);
    return TwoTerms{x - high, high};
  };
  const double product = a * b;
  const TwoTerms x = split(a), y = split(b);
  return {x.error * y.error - (((product - x.sum * y.sum) - x.error * y.sum) - x.sum * y.error), product};
}

template <std::size_t N>
struct Expansion {
  std::array<double, N> terms; // none is zero
  std::size_t count = 0;

  void append(double term) {
    if (term != 0) terms[count++] = term;
  }
  [[nodiscard]] int sign() const { return count == 0 ? 0 : terms[count - 1] > 0 ? 1 : -1; }
};

Expansion<2> exactDifference(double a, double b) {
  const TwoTerms difference = exactSum(a, -b);
  Expansion<2> e;
  e.append(difference.error);
  e.append(difference.sum);
  return e;
}

/// Adds `term` to an expansion that has room for one more.
template <std::size_t N>
void grow(Expansion<N>& e, double term) {
  const std::size_t count = e.count;
  e.count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const TwoTerms t = exactSum(term, e.terms[i]);
    e.append(t.error);
    term = t.sum;
  }
  e.append(term);
}

template <std::size_t N, std::size_t M>
Expansion<N + M> operator+(const Expansion<N>& a, const Expansion<M>& b) {
  Expansion<N + M> sum;
  for (std::size_t i = 0; i < a.count; ++i) sum.append(a.terms[i]);
  for (std::size_t i = 0; i < b.count; ++i) grow(sum, b.terms[i]);
  return sum;
}

template <std::size_t N>
Expansion<N> operator-(Expansion<N> e) {
  for (std::size_t i = 0; i < e.count; ++i) e.terms[i] = -e.terms[i];
  return e;
}

template <std::size_t N, std::size_t M>
Expansion<2 * N * M> operator*(const Expansion<N>& a, const Expansion<M>& b) {
  Expansion<2 * N * M> product;
  for (std::size_t i = 0; i < a.count; ++i)
    for (std::size_t j = 0; j < b.count; ++j) {
      const TwoTerms t = exactProduct(a.terms[i], b.terms[j]);
      grow(product, t.error);
      grow(product, t.sum);
    }
  return product;
}

int exactTurn(const Vec3d& a, const Vec3d& b, const Vec3d& c, std::size_t u, std::size_t v) {
  const auto left = exactDifference(a[u], c[u]) * exactDifference(b[v], c[v]);
  const auto right = exactDifference(a[v], c[v]) * exactDifference(b[u], c[u]);
  return (left + -right).sign();
}

int exactOrientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const auto minor = [&](const Vec3d& p, const Vec3d& q) {
    return exactDifference(p[0], d[0]) * exactDifference(q[1], d[1]) +
           -(exactDifference(p[1], d[1]) * exactDifference(q[0], d[0]));
  };
  const auto first = minor(b, c) * exactDifference(a[2], d[2]), second = minor(c, a) * exactDifference(b[2], d[2]),
             third = minor(a, b) * exactDifference(c[2], d[2]);
  return (first + second + third).sign();
}

int signOf(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

constexpr double kUnitRoundoff = 1.1102230246251565e-16;

} // namespace

int turn(const Vec3d& a, const Vec3d& b, const Vec3d& c, int u, int v) {
  const auto i = static_cast<std::size_t>(u), j = static_cast<std::size_t>(v);
  const double left = (a[i] - c[i]) * (b[j] - c[j]), right = (a[j] - c[j]) * (b[i] - c[i]);
  // Shewchuk's bound of the rounding error of this formula.
  constexpr double kBound = (3 + 16 * kUnitRoundoff) * kUnitRoundoff;
  const double det = left - right;
  if (std::abs(det) > kBound * (std::abs(left) + std::abs(right))) return signOf(det);
  return exactTurn(a, b, c, i, j);
}

int orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const double adx = a[0] - d[0], ady = a[1] - d[1], adz = a[2] - d[2], bdx = b[0] - d[0], bdy = b[1] - d[1],
               bdz = b[2] - d[2], cdx = c[0] - d[0], cdy = c[1] - d[1], cdz = c[2] - d[2];
  const double bc = bdx * cdy, cb = cdx * bdy, ca = cdx * ady, ac = adx * cdy, ab = adx * bdy, ba = bdx * ady;
  const double det = adz * (bc - cb) + bdz * (ca - ac) + cdz * (ab - ba);
  const double size = (std::abs(bc) + std::abs(cb)) * std::abs(adz) + (std::abs(ca) + std::abs(ac)) * std::abs(bdz) +
                      (std::abs(ab) + std::abs(ba)) * std::abs(cdz);
  // Shewchuk's bound of the rounding error of this formula.
  constexpr double kBound = (7 + 56 * kUnitRoundoff) * kUnitRoundoff;
  if (std::abs(det) > kBound * size) return signOf(det);
  return exactOrientation(a, b, c, d);
}

} // namespace volcaustic
