#include "volume/cube_interpolation.h"

#include "core/simd_clones.h"

#include <cmath>
#include <numbers>

namespace volcaustic {

namespace {

constexpr int kNodes = CubeInterpolation::kNodes;
using Row = std::array<double, kNodes>;

/// Chebyshev points of [-1, 1].
template <int N>
std::array<double, N> chebyshevPoints() {
  std::array<double, N> points;
  for (int i = 0; i < N; ++i) points[i] = -std::cos(std::numbers::pi * (2 * i + 1) / (2 * N));
  points[N / 2] = 0;
  return points;
}
const Row kPoints = chebyshevPoints<kNodes>();

/// Lagrange's polynomials at t.
template <std::size_t N>
std::array<double, N> weightsAt(double t, const std::array<double, N>& points) {
  std::array<double, N> weights;
  for (std::size_t i = 0; i < N; ++i) {
    weights[i] = 1;
    for (std::size_t j = 0; j < N; ++j)
      if (j != i) weights[i] *= (t - points[j]) / (points[i] - points[j]);
  }
  return weights;
}

/// What the passes of an interpolation have in common: rows of nodes, added up with weights. Numbers of a row side by
/// side, in the order of the nodes whatever the instruction set.
template <int Count>
inline void weightedSum(const double* __restrict weights, const double* __restrict rows, double* __restrict out) {
  for (int i = 0; i < Count; ++i) out[i] = weights[0] * rows[i];
  for (int a = 1; a < kNodes; ++a)
    for (int i = 0; i < Count; ++i) out[i] += weights[a] * rows[a * Count + i];
}

/// Cube of n^3 samples from 5^3 values: weights across rows by [i][phase], along them by [phase][node][k].
VOLCAUSTIC_SIMD_CLONES void interpolate(const double* values, const double* across, const double* along, int n, int sub,
                                        double* __restrict out) {
  double planes[8][kNodes * kNodes]; // at a row's x, for each phase of j
  for (int i = 0; i < n; ++i) {
    for (int q = 0; q < sub; ++q) weightedSum<kNodes * kNodes>(across + (i * sub + q) * kNodes, values, planes[q]);
    const int p = i & (sub - 1);
    for (int j = 0; j < n; ++j, out += n) {
      const int q = j & (sub - 1);
      double row[kNodes];
      weightedSum<kNodes>(across + (j * sub + p) * kNodes, planes[q], row);
      const double* const weights = along + static_cast<std::ptrdiff_t>(p * sub + q) * kNodes * n;
      for (int k = 0; k < n; ++k) {
        double sum = row[0] * weights[k];
        for (int c = 1; c < kNodes; ++c) sum += row[c] * weights[c * n + k];
        out[k] = sum;
      }
    }
  }
}

using Matrix = std::array<Row, kNodes>;

/// A matrix [to][from] along each axis.
VOLCAUSTIC_SIMD_CLONES void transform(const double* values, const Matrix* const* along, double* __restrict out) {
  constexpr int kPlane = kNodes * kNodes;
  double alongX[kNodes * kPlane], alongY[kNodes * kPlane];
  for (int i = 0; i < kNodes; ++i) weightedSum<kPlane>((*along[0])[i].data(), values, alongX + i * kPlane);
  for (int x = 0; x < kNodes; ++x)
    for (int i = 0; i < kNodes; ++i)
      weightedSum<kNodes>((*along[1])[i].data(), alongX + x * kPlane, alongY + x * kPlane + i * kNodes);
  for (int i = 0; i < kNodes; ++i) {
    const Row& weights = (*along[2])[i];
    for (int row = 0; row < kPlane; ++row) {
      double sum = weights[0] * alongY[row * kNodes];
      for (int c = 1; c < kNodes; ++c) sum += weights[c] * alongY[row * kNodes + c];
      out[row * kNodes + i] = sum;
    }
  }
}

} // namespace

CubeInterpolation::CubeInterpolation(int n, int log2Sub) : mSize(n), mSub(1 << log2Sub) {
  for (int x = 0; x < kNodes; ++x)
    for (int y = 0; y < kNodes; ++y)
      for (int z = 0; z < kNodes; ++z) mNodes.add({node(x), node(y), node(z)});
  const auto points = chebyshevPoints<kFarNodes>();
  const auto at = [&](int i) { return 0.5 * n * (1 + points[i]); };
  for (int x = 0; x < kFarNodes; ++x)
    for (int y = 0; y < kFarNodes; ++y)
      for (int z = 0; z < kFarNodes; ++z) mFarNodes.add({at(x), at(y), at(z)});
  const auto weights = [n](double position) { return weightsAt(2 * position / n - 1, kPoints); };
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
  interpolate(values.data(), mAcross.data(), mAlong.data(), mSize, mSub, samples.data());
}

CubeInterpolation::Values CubeInterpolation::fromFarNodes(const PointSums& points) {
  static const auto kWeights = [] {
    std::array<std::array<double, kFarNodes>, kNodes> weights;
    for (int i = 0; i < kNodes; ++i) weights[i] = weightsAt(kPoints[i], chebyshevPoints<kFarNodes>());
    return weights;
  }();
  // One axis at a time; each pass leaves its axis last, so that after three they are in order again.
  std::array<double, kNodes * kNodes * kNodes> from, to;
  for (int i = 0; i < points.size(); ++i) from[i] = points.sum(i);
  int rests = kFarNodes * kFarNodes;
  for (int pass = 0; pass < 3; ++pass) {
    for (int rest = 0; rest < rests; ++rest)
      for (int i = 0; i < kNodes; ++i) {
        to[rest * kNodes + i] = 0;
        for (int a = 0; a < kFarNodes; ++a) to[rest * kNodes + i] += kWeights[i][a] * from[a * rests + rest];
      }
    from = to;
    rests = rests / kFarNodes * kNodes;
  }
  return from;
}

CubeInterpolation::Range CubeInterpolation::range(const Values& values) {
  static const Matrix kCoefficients = [] { // of Chebyshev's polynomials
    Matrix of;
    for (int k = 0; k < kNodes; ++k)
      for (int i = 0; i < kNodes; ++i) of[k][i] = (k ? 2.0 : 1.0) / kNodes * std::cos(k * std::acos(kPoints[i]));
    return of;
  }();
  const Matrix* const along[] = {&kCoefficients, &kCoefficients, &kCoefficients};
  Values coefficients;
  transform(values.data(), along, coefficients.data());
  double sum = 0;
  for (std::size_t i = 1; i < coefficients.size(); ++i) sum += std::abs(coefficients[i]);
  return {coefficients[0], sum};
}

CubeInterpolation::Values CubeInterpolation::atOctant(const Values& values, int octant) {
  static const auto kHalves = [] {
    std::array<Matrix, 2> halves;
    for (int i = 0; i < kNodes; ++i)
      for (int half = 0; half < 2; ++half) halves[half][i] = weightsAt(0.5 * (kPoints[i] + (half ? 1 : -1)), kPoints);
    return halves;
  }();
  const Matrix* const halves[] = {&kHalves[octant >> 2], &kHalves[octant >> 1 & 1], &kHalves[octant & 1]};
  Values result;
  transform(values.data(), halves, result.data());
  return result;
}

} // namespace volcaustic
