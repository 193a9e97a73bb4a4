#include "volume/cube_interpolation.h"

#include "core/simd_clones.h"

#include <cmath>
#include <numbers>

namespace volcaustic {

namespace {

constexpr int kNodes = CubeInterpolation::kNodes;
using Row = std::array<double, kNodes>;

/// Chebyshev points of [-1, 1].
const Row kPoints = [] {
  Row points;
  for (int i = 0; i < kNodes; ++i) points[i] = -std::cos(std::numbers::pi * (2 * i + 1) / (2 * kNodes));
  points[kNodes / 2] = 0;
  return points;
}();

/// Lagrange's polynomials at t.
Row weightsAt(double t) {
  Row weights;
  for (int i = 0; i < kNodes; ++i) {
    weights[i] = 1;
    for (int j = 0; j < kNodes; ++j)
      if (j != i) weights[i] *= (t - kPoints[j]) / (kPoints[i] - kPoints[j]);
  }
  return weights;
}

VOLCAUSTIC_SIMD_CLONES void combine(const double* __restrict weights, const Row& values, int n,
                                    double* __restrict out) {
  for (int k = 0; k < n; ++k) {
    double sum = 0;
    for (int c = 0; c < kNodes; ++c) sum += values[c] * weights[c * n + k];
    out[k] = sum;
  }
}

} // namespace

CubeInterpolation::CubeInterpolation(int n, int log2Sub) : mSize(n), mSub(1 << log2Sub) {
  const auto weights = [n](double position) { return weightsAt(2 * position / n - 1); };
  for (int i = 0; i < n; ++i)
    for (int phase = 0; phase < mSub; ++phase) {
      const Row row = weights(i + (phase + 0.5) / mSub);
      mAcross.insert(mAcross.end(), row.begin(), row.end());
    }
  const int phases = mSub * mSub;
  mAlong.resize(static_cast<std::size_t>(phases) * kNodes * n);
  for (int phase = 0; phase < phases; ++phase)
    for (int k = 0; k < n; ++k) {
      const Row row = weights(k + (phase + 0.5) / phases);
      for (int c = 0; c < kNodes; ++c) mAlong[(static_cast<std::size_t>(phase) * kNodes + c) * n + k] = row[c];
    }
}

double CubeInterpolation::node(int i) const { return 0.5 * mSize * (1 + kPoints[i]); }

void CubeInterpolation::atSamples(const Values& values, std::vector<double>& samples) const {
  samples.resize(static_cast<std::size_t>(mSize) * mSize * mSize);
  std::array<std::array<double, kNodes * kNodes>, 8> planes; // at a row's x, for each phase of j
  double* out = samples.data();
  for (int i = 0; i < mSize; ++i) {
    for (int q = 0; q < mSub; ++q) {
      const double* const across = mAcross.data() + static_cast<std::ptrdiff_t>(i * mSub + q) * kNodes;
      for (int bc = 0; bc < kNodes * kNodes; ++bc) {
        planes[q][bc] = 0;
        for (int a = 0; a < kNodes; ++a) planes[q][bc] += across[a] * values[a * kNodes * kNodes + bc];
      }
    }
    const int p = i & (mSub - 1);
    for (int j = 0; j < mSize; ++j, out += mSize) {
      const int q = j & (mSub - 1);
      const double* const across = mAcross.data() + static_cast<std::ptrdiff_t>(j * mSub + p) * kNodes;
      Row row{};
      for (int b = 0; b < kNodes; ++b)
        for (int c = 0; c < kNodes; ++c) row[c] += across[b] * planes[q][b * kNodes + c];
      combine(mAlong.data() + static_cast<std::ptrdiff_t>(p * mSub + q) * kNodes * mSize, row, mSize, out);
    }
  }
}

CubeInterpolation::Values CubeInterpolation::atOctant(const Values& values, int octant) {
  static const auto kHalves = [] {
    std::array<std::array<Row, kNodes>, 2> halves;
    for (int i = 0; i < kNodes; ++i)
      for (int half = 0; half < 2; ++half) halves[half][i] = weightsAt(0.5 * (kPoints[i] + (half ? 1 : -1)));
    return halves;
  }();
  // One axis at a time; each pass leaves its axis last, so that after three they are in order again.
  Values from = values, to;
  for (int pass = 0; pass < 3; ++pass) {
    const auto& weights = kHalves[octant >> (2 - pass) & 1];
    for (int rest = 0; rest < kNodes * kNodes; ++rest)
      for (int i = 0; i < kNodes; ++i) {
        double sum = 0;
        for (int a = 0; a < kNodes; ++a) sum += weights[i][a] * from[a * kNodes * kNodes + rest];
        to[rest * kNodes + i] = sum;
      }
    from = to;
  }
  return from;
}

} // namespace volcaustic
