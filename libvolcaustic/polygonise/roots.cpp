#include "polygonise/roots.h"

#include <algorithm>

namespace volcaustic {

namespace {

/// Regula falsi after Anderson & Bjoerck (1973), with a halving wherever three steps did not halve the bracket. All
/// searches take their steps together.
class Search {
public:
  Search(const Bracket& bracket, double accuracy)
      : mValueLow(bracket.valueFrom)
      , mValueHigh(bracket.valueTo)
      , mEnough(accuracy * std::abs(bracket.valueTo - bracket.valueFrom))
      , mShort(accuracy) {}

  /// Where to look next.
  double next() {
    const bool slow = mSteps > 0 && mSteps % 3 == 0 && mHigh - mLow > .5 * mWidth;
    if (mSteps % 3 == 0) mWidth = mHigh - mLow;
    ++mSteps;
    double share = mValueLow / (mValueLow - mValueHigh);
    if (slow || !(share > 0 && share < 1)) share = .5;
    return mPlace = mLow + share * (mHigh - mLow);
  }

  /// \return whether the root is found well enough
  bool take(double value) {
    if (std::abs(value) <= mEnough && std::isfinite(value)) return true;
    const bool isLowSide = (value >= 0) == (mValueLow >= 0);
    double& same = isLowSide ? mValueLow : mValueHigh;
    double& other = isLowSide ? mValueHigh : mValueLow;
    if (mLast == (isLowSide ? 1 : 2)) {
      const double rest = 1 - value / same;
      other *= rest > 0 ? rest : .5;
    }
    same = value;
    (isLowSide ? mLow : mHigh) = mPlace;
    mLast = isLowSide ? 1 : 2;
    return mHigh - mLow <= mShort || mSteps >= kMostSteps;
  }
  [[nodiscard]] double place() const { return mPlace; }

private:
  static constexpr int kMostSteps = 100;

  double mLow = 0, mHigh = 1, mPlace = .5;
  double mValueLow, mValueHigh; // the one that stays is made smaller than it is
  double mEnough, mShort, mWidth = 1;
  int mSteps = 0, mLast = 0;
};

} // namespace

void findRoots(PointEvaluator& evaluator, const std::vector<Bracket>& brackets, double accuracy,
               std::vector<double>& places) {
  std::vector<Search> searches;
  std::vector<std::size_t> open;
  for (const Bracket& bracket : brackets) {
    open.push_back(searches.size());
    searches.emplace_back(bracket, accuracy);
  }
  PointArrays points;
  std::vector<double> values;
  while (!open.empty()) {
    points.clear();
    for (const std::size_t i : open) {
      Vec3d p = brackets[i].from;
      p[brackets[i].axis] += searches[i].next() * brackets[i].length;
      points.add(p);
    }
    evaluator.values(points, values);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < open.size(); ++k)
      if (!searches[open[k]].take(values[k])) open[kept++] = open[k];
    open.resize(kept);
  }
  places.clear();
  for (const Search& search : searches) places.push_back(search.place());
}

} // namespace volcaustic
