#include "polygonise/cell_size.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

namespace volcaustic {

namespace {

// Sizes are whole powers of 2^(1/8), or of 2^(1/128) where triangles are counted: bounds that change a little leave
// them as they are, and with them the blocks that a shape has in common with the one before.
constexpr int kSteps = 8, kFineSteps = 128;

double sizeOf(int step, int stepsAnOctave) { return std::exp2(-static_cast<double>(step) / stepsAnOctave); }
/// The step of the largest size that is not above `size`.
int stepOf(double size, int stepsAnOctave) {
  return static_cast<int>(std::ceil(-std::log2(size) * stepsAnOctave - 1e-9));
}

/// Looks for cells that give nearly as many triangles as allowed.
class BudgetSearch {
public:
  BudgetSearch(PolygoniseJob& job, std::uint64_t budget) : mJob(job), mBudget(static_cast<double>(budget)) {}

  /// \param finest cells to take at all; 0 for any. \return the size of cells
  double run(double finest) {
    const int first = stepOf(mJob.longestSide() / kCoarsest, kFineSteps);
    const int last = finest > 0 ? std::max(first, stepOf(finest, kFineSteps) - 1) : kUnlimited;
    int step = std::clamp(pilot(first), first, last);
    for (int look = 0; look < kLooks && !isEnough(); ++look) {
      if (!latticeHolds(mJob.bounds, sizeOf(step, kFineSteps))) break;
      const double octaves = this->look(step);
      int change = static_cast<int>(std::floor(octaves * kFineSteps));
      if (change == 0) change = octaves >= 0 ? 1 : -1;
      step = std::clamp(step + change, first, last);
      if (mFits && mTooFine <= step) {
        if (mTooFine - *mFits <= 1) break;
        step = (*mFits + mTooFine) / 2;
      } else if (mFits == step) {
        break;
      }
    }
    lookBeyond(last);
    return sizeOf(mBest.value_or(first), kFineSteps);
  }

private:
  static constexpr double kCoarsest = 2; // cells along the longest side
  static constexpr int kPilot = 24;
  static constexpr int kLooks = 12, kLooksBeyond = 8;
  static constexpr int kUnlimited = 1 << 24;
  static constexpr double kEnough = .985;

  [[nodiscard]] bool isEnough() const { return mBest && mBestCount >= kEnough * mBudget; }

  /// Counts go by the square of the size. \return octaves of it to the budget, if that held exactly
  double look(int step) {
    const auto count = static_cast<double>(countTriangles(mJob, sizeOf(step, kFineSteps)));
    if (count > mBudget) {
      mTooFine = std::min(mTooFine, step);
    } else if (count > 0) {
      mFits = std::max(mFits.value_or(step), step);
      if (count > mBestCount) {
        mBest = step;
        mBestCount = count;
      }
    }
    return .5 * std::log2(mBudget / std::max(1.0, count));
  }

  /// Flat faces along the lattice make counts go up and down: finer cells may fit again.
  void lookBeyond(int last) {
    if (!mBest || mTooFine == kUnlimited) return;
    const int from = mTooFine;
    for (int step = from + 1; step <= std::min(from + kLooksBeyond, last) && !isEnough(); ++step) look(step);
  }

  /// Where the budget would be reached if counts went by the square of the size from coarse cells on.
  int pilot(int first) {
    int step = stepOf(mJob.longestSide() / kPilot, kFineSteps);
    for (int again = 0; again < 3; ++again) {
      const auto count = static_cast<double>(countTriangles(mJob, sizeOf(step, kFineSteps)));
      const double octaves = .5 * std::log2(mBudget / std::max(1.0, count));
      // Never farther than half way from what is known: a pilot is to be cheap.
      if (octaves <= 1.5) return std::max(first, step + static_cast<int>(std::floor(octaves * kFineSteps)));
      step += static_cast<int>(std::floor((octaves - 1) * kFineSteps));
    }
    return step;
  }

  PolygoniseJob& mJob;
  const double mBudget;
  std::optional<int> mBest, mFits; // of most triangles, and finest of those that are not too many
  double mBestCount = 0;
  int mTooFine = kUnlimited;
};

/// Refines until triangles are as near to the surface as asked for.
class ToleranceSearch {
public:
  ToleranceSearch(PolygoniseJob& job, const PolygoniseOptions& options) : mJob(job), mOptions(options) {}

  PolygoniseResult run(double cellSize) {
    PolygoniseResult result = polygoniseAt(mJob, cellSize);
    double order = 2; // that distances go by, in the size of cells
    for (int run = 1; run < kMostRuns && !isReached(result); ++run) {
      const double deviation = result.report.deviation, size = result.report.cellSize;
      const double shrink = std::clamp(std::pow(kAim * mOptions.tolerance / deviation, 1 / order), kMostShrink, 1.0);
      const int step = std::max(stepOf(size * shrink, kSteps), stepOf(size, kSteps) + 1);
      const double next = sizeOf(step, kSteps);
      if (!canAfford(result, next)) break;
      result = polygoniseAt(mJob, next);
      if (result.report.deviation > 0)
        order = std::clamp(std::log(deviation / result.report.deviation) / std::log(size / next), .5, 2.5);
    }
    return result;
  }

  /// Between samples it may be a little farther than at them.
  [[nodiscard]] bool isReached(const PolygoniseResult& result) const {
    return mOptions.tolerance == 0 || kBetweenSamples * result.report.deviation <= mOptions.tolerance;
  }

private:
  static constexpr int kMostRuns = 8;
  static constexpr double kAim = .8, kMostShrink = .125, kBetweenSamples = 1.1;

  [[nodiscard]] bool canAfford(const PolygoniseResult& result, double next) const {
    const double growth = std::pow(result.report.cellSize / next, 2);
    const double triangles = growth * static_cast<double>(result.mesh.triangles.size());
    // A triangle with its share of blocks and vertices.
    constexpr double kBytes = 200;
    return latticeHolds(mJob.bounds, next) &&
           kBytes * triangles < static_cast<double>(mJob.ctx.effectiveMemoryLimit()) &&
           (mOptions.triangles == 0 || triangles < 1.1 * mOptions.triangles);
  }

  PolygoniseJob& mJob;
  const PolygoniseOptions& mOptions;
};

/// Cells along the longest side to begin with: those that were asked for, or for a tolerance alone some that show what
/// the shape is like.
int firstResolution(const PolygoniseOptions& options) {
  constexpr int kUsual = 128, kForTolerance = 32;
  if (options.resolution > 0) return options.resolution;
  return options.tolerance > 0 ? kForTolerance : kUsual;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

} // namespace

PolygoniseResult polygoniseAsAsked(PolygoniseJob& job, const PolygoniseOptions& options) {
  const bool onlyBudget =
      options.triangles > 0 && options.resolution == 0 && options.cellSize == 0 && options.tolerance == 0;
  ToleranceSearch search(job, options);
  PolygoniseResult result;
  if (!onlyBudget) {
    const double size = options.cellSize > 0
                            ? options.cellSize
                            : sizeOf(stepOf(job.longestSide() / firstResolution(options), kSteps), kSteps);
    result = search.run(size);
  }
  const auto budget = static_cast<std::uint64_t>(options.triangles);
  if (onlyBudget || (budget > 0 && result.mesh.triangles.size() > budget)) {
    const double size = BudgetSearch(job, budget).run(result.report.cellSize);
    result = polygoniseAt(job, size);
    if (result.mesh.triangles.size() > budget)
      job.ctx.warn("polygonise: the shape takes more than " + std::to_string(budget) +
                   " triangles: " + std::to_string(result.mesh.triangles.size()));
  }
  if (!search.isReached(result))
    job.ctx.warn("polygonise: triangles are up to " + number(result.report.deviation) + " from the surface, not " +
                 number(options.tolerance));
  return result;
}

} // namespace volcaustic
