#include "polygonise/vertex.h"

#include "polygonise/quadric_error.h"

#include <algorithm>

namespace volcaustic {

namespace {

/// Cosine of the angle between normals of a patch above which it has no edge worth keeping: rounding one of eleven
/// degrees costs a twentieth of a cell.
constexpr double kFlat = .98;
/// Share of planes' weight that a direction needs: edges of more than ten degrees.
constexpr double kLeastWeight = .008;
/// Samples come that much nearer to the supposed edge in each round.
constexpr double kCloser = .25;
constexpr int kRounds = 3;
/// Angles between normals that stay, of what they were, when samples come closer: at an edge all, at a curve `kCloser`.
constexpr double kStays = .6;
/// In cells: how far an edge may be from the surface, and how near to its border a vertex may come. That keeps vertices
/// of neighbouring cells apart.
constexpr double kOnSurface = .02, kBorder = 1e-7;
/// The same along the surface: vertices come no nearer to the border unless the surface itself does.
constexpr double kMargin = .15;
/// In cells, that vertices may be moved off the surface by to keep to their cell.
constexpr double kSlack = .001;
/// In cells: within that of the border an edge or corner may be seen from the neighbouring cell as well.
constexpr double kShared = .02;

/// A patch whose normals differ: perhaps around an edge or a corner.
struct Feature {
  std::size_t patch;
  std::vector<Vec3d> offsets; // of samples from the place supposed
  Vec3d mean, place;
  Vec3d byRoots;    // where the planes through the roots alone meet: sees no corner of a cell next to it
  double angle = 0; // greatest between normals
};

double greatestAngle(std::span<const Tangent> tangents) {
  double least = 1;
  for (std::size_t i = 0; i < tangents.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (tangents[i].slope > 0 && tangents[j].slope > 0)
        least = std::min(least, dot(tangents[i].normal, tangents[j].normal));
  return std::acos(std::max(-1.0, least));
}

class Placer {
public:
  Placer(PointEvaluator& evaluator, double cellSize, std::span<const Root> roots, std::span<const int> patchRoots,
         std::vector<PatchVertex>& patches)
      : mEvaluator(evaluator), mCellSize(cellSize), mRoots(roots), mPatchRoots(patchRoots), mPatches(patches) {}

  void run() {
    for (std::size_t i = 0; i < mPatches.size(); ++i) {
      mPatches[i].position = mean(mPatches[i]);
      if (!isFlat(mPatches[i])) addFeature(i);
    }
    std::vector<bool> placed(mPatches.size(), false);
    for (int round = 0; round < kRounds && !mFeatures.empty(); ++round) approach(round);
    settle(placed);
    moveOntoSurface(placed);
  }

private:
  [[nodiscard]] const Root& root(const PatchVertex& patch, std::size_t i) const {
    return mRoots[mPatchRoots[patch.firstRoot + i]];
  }
  [[nodiscard]] Vec3d mean(const PatchVertex& patch) const {
    // From the cell's corner, so that roundings are those of the cell's size.
    Vec3d sum{0, 0, 0};
    for (std::size_t i = 0; i < patch.rootCount; ++i)
      sum = along(sum, difference(root(patch, i).position, patch.cell), 1);
    return inCell(patch, along(patch.cell, sum, 1.0 / static_cast<double>(patch.rootCount)));
  }
  [[nodiscard]] bool isFlat(const PatchVertex& patch) const {
    for (std::size_t i = 0; i < patch.rootCount; ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const Tangent &a = root(patch, i).tangent, &b = root(patch, j).tangent;
        if (a.slope > 0 && b.slope > 0 && dot(a.normal, b.normal) < kFlat) return false;
      }
    return true;
  }

  /// The nearest point in the cell, or in the cell and what is `around` it, in cells.
  [[nodiscard]] Vec3d inCell(const PatchVertex& patch, const Vec3d& p, double around = -kBorder) const {
    Vec3d q;
    for (int a = 0; a < 3; ++a)
      q[a] = std::clamp(p[a], patch.cell[a] - around * mCellSize, patch.cell[a] + (1 + around) * mCellSize);
    return q;
  }

  /// Samples are the roots and points between neighbouring ones: a corner's third face may cross no edge of the cell.
  void addFeature(std::size_t i) {
    const PatchVertex& patch = mPatches[i];
    Feature feature{i, {}, patch.position, patch.position, patch.position};
    for (std::size_t k = 0; k < patch.rootCount; ++k) {
      const Vec3d &p = root(patch, k).position, &q = root(patch, (k + 1) % patch.rootCount).position;
      feature.offsets.push_back(difference(p, patch.position));
      feature.offsets.push_back(difference(between(p, q), patch.position));
    }
    mFeatures.push_back(std::move(feature));
  }

  /// Moves all places supposed to where the planes through nearby samples meet, and samples after them. Drops patches
  /// whose normals come to agree: they are curved.
  void approach(int round) {
    const double scale = std::pow(kCloser, round);
    mPoints.clear();
    for (const Feature& feature : mFeatures) {
      for (const Vec3d& offset : feature.offsets) mPoints.add(along(feature.place, offset, scale));
      mPoints.add(feature.place);
    }
    mEvaluator.gradients(mPoints, mValues);
    std::size_t first = 0, kept = 0;
    for (Feature& feature : mFeatures) {
      const std::size_t count = feature.offsets.size() + 1;
      if (meet(feature, first, count, round)) {
        if (&mFeatures[kept] != &feature) mFeatures[kept] = std::move(feature);
        ++kept;
      }
      first += count;
    }
    mFeatures.resize(kept);
  }

  bool meet(Feature& feature, std::size_t first, std::size_t count, int round) {
    mTangents.clear();
    PlaneDistances planes, rootPlanes;
    for (std::size_t i = first; i < first + count; ++i) {
      const Tangent tangent = mValues.tangent(i);
      mTangents.push_back(tangent);
      if (!(tangent.slope > 0)) continue;
      const double distance = dot(tangent.normal, difference(mPoints.at(i), feature.mean)) - tangent.distance;
      planes.add(tangent.normal, distance);
      if ((i - first) % 2 == 0 && i + 1 < first + count) rootPlanes.add(tangent.normal, distance);
    }
    const double angle = greatestAngle(mTangents);
    if (round > 0 && angle < kStays * feature.angle) return false;
    feature.angle = angle;
    const PatchVertex& patch = mPatches[feature.patch];
    const Vec3d place = inCell(patch, along(feature.mean, planes.minimum(kLeastWeight), 1), 1);
    if (round == 0) {
      feature.byRoots = inCell(patch, along(feature.mean, rootPlanes.minimum(kLeastWeight), 1));
      for (Vec3d& offset : feature.offsets) offset = along(difference(feature.mean, place), offset, 1);
    }
    feature.place = place;
    return true;
  }

  /// Takes the places that turned out to lie on the surface: at once where they are well within the cell. Others may be
  /// those of several cells, and are left to who knows them all.
  void settle(std::vector<bool>& placed) {
    mPoints.clear();
    for (const Feature& feature : mFeatures) {
      mPoints.add(feature.place);
      mPoints.add(feature.byRoots);
    }
    mEvaluator.values(mPoints, mStepValues);
    for (std::size_t i = 0; i < mFeatures.size(); ++i) {
      const Feature& feature = mFeatures[i];
      PatchVertex& patch = mPatches[feature.patch];
      // Where solids touch, several patches have their edges in one place: a hair apart they stay a manifold.
      const auto apart = [&](const Vec3d& p) { return along(p, difference(feature.mean, p), kBorder); };
      const auto isOnSurface = [&](std::size_t k) { return std::abs(mStepValues[k]) < kOnSurface * mCellSize; };
      const Vec3d place = apart(feature.place), byRoots = inCell(patch, apart(feature.byRoots));
      if (isOnSurface(2 * i) && inCell(patch, place, -kShared) == place) {
        patch.position = place;
        placed[feature.patch] = true;
        continue;
      }
      patch.strays = isOnSurface(2 * i) || isOnSurface(2 * i + 1);
      patch.outside = isOnSurface(2 * i) ? place : byRoots;
      patch.within = isOnSurface(2 * i + 1) ? byRoots : inCell(patch, place);
    }
  }

  /// All others, if only for the time being: from the mean of the roots along the gradient, well within the cell where
  /// the way leads to a point of it.
  void moveOntoSurface(const std::vector<bool>& placed) {
    mMoved.clear();
    for (std::size_t i = 0; i < mPatches.size(); ++i)
      if (!placed[i]) mMoved.push_back(i);
    step(-kMargin);
    if (!mMoved.empty()) step(-kBorder);
  }

  /// Moves vertices in two steps, and leaves in the list those that came to the border.
  void step(double around) {
    mPoints.clear();
    for (const std::size_t i : mMoved) mPoints.add(inCell(mPatches[i], mPatches[i].position, around));
    mEvaluator.gradients(mPoints, mValues);
    mTangents.clear();
    mSteps.clear();
    for (std::size_t k = 0; k < mMoved.size(); ++k) {
      mTangents.push_back(mValues.tangent(k));
      mSteps.add(inCell(mPatches[mMoved[k]], along(mPoints.at(k), mTangents[k].normal, -mTangents[k].distance)));
    }
    mEvaluator.values(mSteps, mStepValues);
    std::size_t left = 0;
    for (std::size_t k = 0; k < mMoved.size(); ++k) {
      const Tangent& tangent = mTangents[k];
      PatchVertex& patch = mPatches[mMoved[k]];
      const bool nearer = std::abs(mStepValues[k]) < std::abs(mValues.value[k]) && tangent.slope > 0;
      const Vec3d end = nearer ? along(mSteps.at(k), tangent.normal, -mStepValues[k] / tangent.slope) : mPoints.at(k);
      if (around < -kBorder && (!nearer || length(difference(inCell(patch, end), end)) > kSlack * mCellSize))
        mMoved[left++] = mMoved[k];
      else
        patch.position = inCell(patch, end);
    }
    mMoved.resize(left);
  }

  PointEvaluator& mEvaluator;
  const double mCellSize;
  std::span<const Root> mRoots;
  std::span<const int> mPatchRoots;
  std::vector<PatchVertex>& mPatches;

  std::vector<Feature> mFeatures;
  PointArrays mPoints, mSteps;
  ValueArrays mValues;
  std::vector<Tangent> mTangents;
  std::vector<double> mStepValues;
  std::vector<std::size_t> mMoved; // patches
};

} // namespace

void placeVertices(PointEvaluator& evaluator, double cellSize, std::span<const Root> roots,
                   std::span<const int> patchRoots, std::vector<PatchVertex>& patches) {
  Placer(evaluator, cellSize, roots, patchRoots, patches).run();
}

} // namespace volcaustic
