#include "shapes/waves.h"

#include "core/simd_clones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace volcaustic {

namespace {

/// What can be divided by where the gradient has no direction.
constexpr double kTiny = 1e-300;

/// Of the series of sin(x), odd powers from the first: the one after them adds less than 1e-17 up to a quarter turn.
constexpr auto kSeries = [] {
  std::array<double, 11> series{1};
  for (int i = 1; i < 11; ++i) series[i] = -series[i - 1] / (2 * i * (2 * i + 1));
  return series;
}();

/// sin(2 pi t) for |t| <= 1/4. Not the C library's, which rounds otherwise on other processors.
[[gnu::always_inline]] inline double sineOfTurn(double t) {
  const double x = 2 * std::numbers::pi * t, square = x * x;
  double sum = kSeries[10];
  for (int i = 9; i >= 0; --i) sum = sum * square + kSeries[i];
  return sum * x;
}

/// cos(2 pi t).
[[gnu::always_inline]] inline double cosineOfTurns(double t) {
  return sineOfTurn(.25 - std::abs(t - std::floor(t + .5)));
}

/// sin(2 pi t).
[[gnu::always_inline]] inline double sineOfTurns(double t) {
  const double part = t - std::floor(t + .5), size = std::abs(part);
  return sineOfTurn(std::copysign(std::min(size, .5 - size), part));
}

VOLCAUSTIC_SIMD_CLONES void planeTurns(const Vec3d perTurn, double phase, const ShapePoints p,
                                       double* __restrict turns) {
  for (int i = 0; i < p.count; ++i) turns[i] = p.x[i] * perTurn[0] + p.y[i] * perTurn[1] + p.z[i] * perTurn[2] - phase;
}
VOLCAUSTIC_SIMD_CLONES void ringTurns(double perLength, double phase, const ShapePoints p, double* __restrict turns) {
  for (int i = 0; i < p.count; ++i) turns[i] = std::sqrt(p.x[i] * p.x[i] + p.y[i] * p.y[i]) * perLength - phase;
}
VOLCAUSTIC_SIMD_CLONES void cosines(double amplitude, const double* turns, int count, double* __restrict value) {
  for (int i = 0; i < count; ++i) value[i] = amplitude * cosineOfTurns(turns[i]);
}
/// The gradient along the direction that the waves take.
VOLCAUSTIC_SIMD_CLONES void slopes(double greatest, const double* turns, int count, double* __restrict slope) {
  for (int i = 0; i < count; ++i) slope[i] = -greatest * sineOfTurns(turns[i]);
}
VOLCAUSTIC_SIMD_CLONES void ringDirections(const ShapePoints p, double* __restrict x, double* __restrict y) {
  for (int i = 0; i < p.count; ++i) {
    const double k = 1 / (std::sqrt(p.x[i] * p.x[i] + p.y[i] * p.y[i]) + kTiny);
    x[i] = k * p.x[i];
    y[i] = k * p.y[i];
  }
}
VOLCAUSTIC_SIMD_CLONES void scale(const double* by, int count, double* __restrict values) {
  for (int i = 0; i < count; ++i) values[i] *= by[i];
}

class WaveFunction final : public ShapeFunction {
public:
  explicit WaveFunction(const shapes::WaveDisplacement& s)
      : mAmplitude(s.amplitude)
      , mPerLength(1 / s.wavelength)
      , mPhase(s.phase - std::floor(s.phase))
      , mRadial(s.radial) {
    const double length = std::hypot(s.direction[0], s.direction[1], s.direction[2]);
    for (int a = 0; a < 3 && !mRadial; ++a) {
      mDirection[a] = s.direction[a] / length;
      mPerTurn[a] = mDirection[a] * mPerLength;
    }
  }

  void evaluate(const ShapePoints& p, const ShapeValues& v) const override {
    BatchNumbers turns;
    if (mRadial)
      ringTurns(mPerLength, mPhase, p, turns.data());
    else
      planeTurns(mPerTurn, mPhase, p, turns.data());
    cosines(mAmplitude, turns.data(), p.count, v.value);
    if (!v.wantsGradient()) return;
    for (int a = 0; a < 3; ++a) std::fill_n(v.gradient[a], p.count, mDirection[a]);
    if (mRadial) ringDirections(p, v.gradient[0], v.gradient[1]);
    BatchNumbers slope;
    slopes(2 * std::numbers::pi * mAmplitude * mPerLength, turns.data(), p.count, slope.data());
    for (double* g : v.gradient) scale(slope.data(), p.count, g);
  }

  [[nodiscard]] Interval bound(const Box& box) const override {
    const Interval turns = turnsOver(box);
    if (!(turns.high - turns.low < 1)) return {-mAmplitude * (1 + kRoundingSlack), mAmplitude * (1 + kRoundingSlack)};
    const double one = cosineOfTurns(turns.low), other = cosineOfTurns(turns.high);
    const auto holds = [&](double t) { return std::floor(turns.high - t) + t >= turns.low; }; // t and whole turns more
    const Interval cosine{holds(.5) ? -1 : std::min(one, other), holds(0) ? 1 : std::max(one, other)};
    return {mAmplitude * (cosine.low - kRoundingSlack), mAmplitude * (cosine.high + kRoundingSlack)};
  }

private:
  [[nodiscard]] Interval turnsOver(const Box& box) const {
    double least = 0, greatest = 0, size = mPhase;
    for (int a = 0; a < 3; ++a) {
      const double reach = std::max(std::abs(box.min[a]), std::abs(box.max[a]));
      if (!mRadial) {
        const Interval along = Interval{mPerTurn[a], mPerTurn[a]} * Interval{box.min[a], box.max[a]};
        least += along.low;
        greatest += along.high;
        size += std::abs(mPerTurn[a]) * reach;
      } else if (a < 2) {
        least = std::hypot(least, std::max({0.0, box.min[a], -box.max[a]}) * mPerLength);
        greatest = std::hypot(greatest, reach * mPerLength);
      }
    }
    return widened({least - mPhase, greatest - mPhase}, kRoundingSlack * (size + greatest));
  }

  double mAmplitude, mPerLength, mPhase;
  bool mRadial;
  Vec3d mDirection{}, mPerTurn{};
};

} // namespace

std::unique_ptr<ShapeFunction> makeWaves(const shapes::WaveDisplacement& waves) {
  return std::make_unique<WaveFunction>(waves);
}

} // namespace volcaustic
