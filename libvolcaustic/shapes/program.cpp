#include "shapes/program.h"

#include "core/simd_clones.h"
#include "shapes/tables.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volcaustic {

namespace {

// Two surfaces within k of each other join smoothly: the maximum of a and b and k h^3/6 more, where
// h = max(0, 1 - |a - b|/k). Twice continuously differentiable, and it grows with both a and b.

inline double smoothMaximum(double a, double b, double k) {
  const double h = std::max(0.0, 1 - std::abs(a - b) / k);
  return std::max(a, b) + k / 6 * (h * h * h);
}

VOLCAUSTIC_SIMD_CLONES void smoothMaxima(double k, double sign, int count, double* a, const double* b) {
  for (int i = 0; i < count; ++i) a[i] = sign * smoothMaximum(sign * a[i], sign * b[i], k);
}
VOLCAUSTIC_SIMD_CLONES void maxima(int count, double* a, const double* b) {
  for (int i = 0; i < count; ++i) a[i] = a[i] >= b[i] ? a[i] : b[i];
}
VOLCAUSTIC_SIMD_CLONES void minima(int count, double* a, const double* b) {
  for (int i = 0; i < count; ++i) a[i] = a[i] <= b[i] ? a[i] : b[i];
}
VOLCAUSTIC_SIMD_CLONES void sums(int count, double* a, const double* b) {
  for (int i = 0; i < count; ++i) a[i] += b[i];
}
VOLCAUSTIC_SIMD_CLONES void addToAll(double constant, int count, double* a) {
  for (int i = 0; i < count; ++i) a[i] += constant;
}
VOLCAUSTIC_SIMD_CLONES void negate(int count, double* a) {
  for (int i = 0; i < count; ++i) a[i] = -a[i];
}

/// How much of the second gradient there is in a joined one, from the values before they were joined.
VOLCAUSTIC_SIMD_CLONES void shares(double k, double sign, int count, const double* a, const double* b, double* share) {
  for (int i = 0; i < count; ++i) {
    const double ahead = sign * (a[i] - b[i]);
    const double h = k > 0 ? std::max(0.0, 1 - std::abs(ahead) / k) : 0, half = .5 * h * h;
    share[i] = ahead >= 0 ? half : 1 - half;
  }
}
VOLCAUSTIC_SIMD_CLONES void mix(const double* share, int count, double* a, const double* b) {
  for (int i = 0; i < count; ++i) a[i] = share[i] == 0 ? a[i] : share[i] == 1 ? b[i] : a[i] + share[i] * (b[i] - a[i]);
}
void chooseParts(const double* share, int count, std::uint32_t* a, const std::uint32_t* b) {
  for (int i = 0; i < count; ++i) a[i] = share[i] <= .5 ? a[i] : b[i];
}

Interval smoothMaximum(const Interval& a, const Interval& b, double k) {
  const Interval m{smoothMaximum(a.low, b.low, k), smoothMaximum(a.high, b.high, k)};
  return widened(m, 4e-16 * (magnitude(a) + magnitude(b) + k));
}

constexpr int kStackRows = 4; // value and gradient

} // namespace

double* ShapeScratch::numbers(std::size_t depth) {
  const std::size_t needed = depth * kStackRows * kShapeBatch;
  if (mNumbers.size() < needed) mNumbers.resize(needed);
  return mNumbers.data();
}
std::uint32_t* ShapeScratch::parts(std::size_t depth) {
  if (mParts.size() < depth * kShapeBatch) mParts.resize(depth * kShapeBatch);
  return mParts.data();
}

/// One run of a program over a batch, with what is asked for beside the values.
class ShapeRun {
public:
  enum class Wanted { Values, Gradients, Parts };

  ShapeRun(const ShapeProgram& program, const ShapePoints& points, ShapeScratch& scratch, Wanted wanted)
      : mProgram(program)
      , mPoints(points)
      , mNumbers(scratch.numbers(program.mDepth))
      , mParts(wanted == Wanted::Parts ? scratch.parts(program.mDepth) : nullptr)
      , mGradients(wanted == Wanted::Gradients) {
    for (const ShapeProgram::Instruction& at : program.mCode) step(at);
  }

  [[nodiscard]] const double* row(std::size_t level, int which) const {
    return mNumbers + (level * kStackRows + which) * kShapeBatch;
  }
  [[nodiscard]] const std::uint32_t* parts() const { return mParts; }

private:
  using Op = ShapeProgram::Op;

  double* row(std::size_t level, int which) { return mNumbers + (level * kStackRows + which) * kShapeBatch; }
  ShapeValues valuesAt(std::size_t level) {
    if (!mGradients) return {row(level, 0), {nullptr, nullptr, nullptr}};
    return {row(level, 0), {row(level, 1), row(level, 2), row(level, 3)}};
  }

  void step(const ShapeProgram::Instruction& at) {
    switch (at.op) {
    case Op::Function:
      mProgram.mTables->functions[at.index].evaluate->evaluate(mPoints, valuesAt(mLevel));
      push(at.part);
      return;
    case Op::Quadric:
      mProgram.mTables->quadrics[at.index].evaluate(mPoints, mProgram.deviationsOf(at), valuesAt(mLevel));
      push(at.part);
      return;
    case Op::Negate:
      for (int r = 0; r < rows(); ++r) negate(mPoints.count, row(mLevel - 1, r));
      return;
    case Op::AddConstant:
      addToAll(at.constant, mPoints.count, row(mLevel - 1, 0));
      return;
    default:
      --mLevel;
      join(at);
    }
  }
  void push(std::uint32_t part) {
    if (mParts) std::fill_n(mParts + mLevel * kShapeBatch, mPoints.count, part);
    ++mLevel;
  }
  [[nodiscard]] int rows() const { return mGradients ? kStackRows : 1; }

  /// The two topmost numbers.
  void join(const ShapeProgram::Instruction& at) {
    const int count = mPoints.count;
    double* a = row(mLevel - 1, 0);
    const double* b = row(mLevel, 0);
    if (at.op == Op::Add) {
      for (int r = 0; r < rows(); ++r) sums(count, row(mLevel - 1, r), row(mLevel, r));
      return;
    }
    const double sign = at.op == Op::Minimum || at.op == Op::SmoothMinimum ? -1 : 1;
    if (mGradients || mParts) {
      BatchNumbers share;
      shares(at.constant, sign, count, a, b, share.data());
      for (int r = 1; r < rows(); ++r) mix(share.data(), count, row(mLevel - 1, r), row(mLevel, r));
      if (mParts) chooseParts(share.data(), count, mParts + (mLevel - 1) * kShapeBatch, mParts + mLevel * kShapeBatch);
    }
    if (at.op == Op::Maximum)
      maxima(count, a, b);
    else if (at.op == Op::Minimum)
      minima(count, a, b);
    else
      smoothMaxima(at.constant, sign, count, a, b);
  }

  const ShapeProgram& mProgram;
  const ShapePoints& mPoints;
  double* mNumbers;
  std::uint32_t* mParts;
  const bool mGradients;
  std::size_t mLevel = 0;
};

std::span<const std::uint32_t> ShapeProgram::deviationsOf(const Instruction& at) const {
  return {mDeviations.data() + at.firstDeviation, at.deviations};
}

void ShapeProgram::values(const ShapePoints& points, double* values, ShapeScratch& scratch) const {
  if (empty()) {
    std::fill_n(values, points.count, -std::numeric_limits<double>::infinity());
    return;
  }
  const ShapeRun run(*this, points, scratch, ShapeRun::Wanted::Values);
  std::copy_n(run.row(0, 0), points.count, values);
}

void ShapeProgram::gradients(const ShapePoints& points, const ShapeValues& values, ShapeScratch& scratch) const {
  if (empty()) {
    std::fill_n(values.value, points.count, -std::numeric_limits<double>::infinity());
    for (double* g : values.gradient) std::fill_n(g, points.count, 0.0);
    return;
  }
  const ShapeRun run(*this, points, scratch, ShapeRun::Wanted::Gradients);
  std::copy_n(run.row(0, 0), points.count, values.value);
  for (int a = 0; a < 3; ++a) std::copy_n(run.row(0, a + 1), points.count, values.gradient[a]);
}

void ShapeProgram::parts(const ShapePoints& points, std::uint32_t* parts, ShapeScratch& scratch) const {
  if (empty()) {
    std::fill_n(parts, points.count, 0u);
    return;
  }
  const ShapeRun run(*this, points, scratch, ShapeRun::Wanted::Parts);
  std::copy_n(run.parts(), points.count, parts);
}

/// Bounds of every instruction.
void ShapeProgram::computeBounds(const Box& box, std::vector<Interval>& bounds) const {
  bounds.resize(mCode.size());
  for (std::size_t i = 0; i < mCode.size(); ++i) {
    const Instruction& at = mCode[i];
    const Interval last = i > 0 ? bounds[i - 1] : Interval{};
    const auto first = [&] { return bounds[firstOf(i)]; };
    Interval& b = bounds[i];
    switch (at.op) {
    case Op::Function:
      b = mTables->functions[at.index].evaluate->bound(box);
      break;
    case Op::Quadric:
      b = mTables->quadrics[at.index].bound(box, deviationsOf(at));
      break;
    case Op::Maximum:
      b = {std::max(first().low, last.low), std::max(first().high, last.high)};
      break;
    case Op::Minimum:
      b = {std::min(first().low, last.low), std::min(first().high, last.high)};
      break;
    case Op::SmoothMaximum:
      b = smoothMaximum(first(), last, at.constant);
      break;
    case Op::SmoothMinimum:
      b = -smoothMaximum(-first(), -last, at.constant);
      break;
    case Op::Add:
      b = widened(first() + last, 4e-16 * (magnitude(first()) + magnitude(last)));
      break;
    case Op::AddConstant:
      b = widened({last.low + at.constant, last.high + at.constant}, 4e-16 * (magnitude(last) + std::abs(at.constant)));
      break;
    case Op::Negate:
      b = -last;
      break;
    }
  }
}

Interval ShapeProgram::bound(const Box& box, ShapeScratch& scratch) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (empty()) return {-kInfinity, -kInfinity};
  computeBounds(box, scratch.bounds);
  return scratch.bounds.back();
}

Interval ShapeProgram::prune(const Box& box, ShapeProgram& pruned, ShapeScratch& scratch) const {
  const Interval whole = bound(box, scratch);
  pruned.mCode.clear();
  pruned.mDeviations.clear();
  pruned.mTables = mTables;
  if (!empty()) pruned.keep(mCode.size() - 1, *this, box, scratch.bounds);
  pruned.finish();
  return whole;
}

/// Takes over instruction `i` of another program and what it works on, without what cannot matter in the box.
void ShapeProgram::keep(std::size_t i, const ShapeProgram& from, const Box& box, const std::vector<Interval>& bounds) {
  const std::size_t begin = mCode.size();
  Instruction at = from.mCode[i];
  if (at.op == Op::Function) {
    mCode.push_back(at);
    return;
  }
  if (at.op == Op::Quadric) {
    const PlacedQuadric& quadric = mTables->quadrics[at.index];
    const auto first = static_cast<std::uint32_t>(mDeviations.size());
    for (const std::uint32_t d : from.deviationsOf(at))
      if (!quadric.vanishes(d, box)) mDeviations.push_back(d);
    at.firstDeviation = first;
    at.deviations = static_cast<std::uint32_t>(mDeviations.size()) - first;
    mCode.push_back(at);
    return;
  }
  if (at.op == Op::Negate || at.op == Op::AddConstant) {
    keep(i - 1, from, box, bounds);
  } else {
    const std::size_t a = from.firstOf(i), b = i - 1;
    if (at.op != Op::Add) {
      // The greater of two, by more than the width in which they blend, is the maximum itself.
      const bool least = at.op == Op::Minimum || at.op == Op::SmoothMinimum;
      const Interval first = least ? -bounds[a] : bounds[a], second = least ? -bounds[b] : bounds[b];
      if (first.low - second.high > at.constant) return keep(a, from, box, bounds);
      if (second.low - first.high > at.constant) return keep(b, from, box, bounds);
    }
    keep(a, from, box, bounds);
    keep(b, from, box, bounds);
  }
  at.size = static_cast<std::uint32_t>(mCode.size() - begin + 1);
  mCode.push_back(at);
}

void ShapeProgram::finish() {
  std::uint32_t level = 0;
  mDepth = 0;
  for (const Instruction& at : mCode) {
    if (at.op == Op::Function || at.op == Op::Quadric)
      mDepth = std::max(mDepth, ++level);
    else if (at.op != Op::Negate && at.op != Op::AddConstant)
      --level;
  }
}

std::uint64_t ShapeProgram::hash() const {
  Hash hash;
  for (const Instruction& at : mCode) {
    hash.value(at.op).value(at.constant);
    if (at.op == Op::Function)
      hash.value(mTables->functions[at.index].hash).text(mTables->partNames[at.part]);
    else if (at.op == Op::Quadric) {
      mTables->quadrics[at.index].addTo(hash, deviationsOf(at));
      hash.text(mTables->partNames[at.part]);
    }
  }
  return hash.digest();
}

const std::vector<std::string>& ShapeProgram::partNames() const { return mTables->partNames; }

} // namespace volcaustic
