#include "polygonise/measure.h"

#include "core/xxhash64.h"
#include "polygonise/points.h"

#include <algorithm>

namespace volcaustic {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

Vec3d centroid(const QuadMesh& mesh, const Triangle& t) {
  const Vec3d& a = mesh.positions[t[0]];
  const Vec3d b = difference(mesh.positions[t[1]], a), c = difference(mesh.positions[t[2]], a);
  return along(a, along(b, c, 1), 1.0 / 3);
}

/// Looks for the greatest distance in two steps: a value divided by the slope nearby tells all distances to first
/// order, and the greatest of them are then measured along the way to the surface.
class DeviationSearch {
public:
  explicit DeviationSearch(PointEvaluator& evaluator) : mEvaluator(evaluator) {}

  void add(const Vec3d& p, double slope) {
    mPoints.add(p);
    mSlopes.push_back(slope > 0 ? slope : 1);
  }

  double run() {
    mEvaluator.values(mPoints, mValues);
    std::vector<std::size_t> order(mPoints.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      order[i] = i;
      mValues[i] = std::isfinite(mValues[i]) ? std::abs(mValues[i]) / mSlopes[i] : 0;
    }
    const std::size_t count = std::min(order.size(), kMeasured);
    std::partial_sort(
        order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
        [&](std::size_t a, std::size_t b) { return mValues[a] != mValues[b] ? mValues[a] > mValues[b] : a < b; });
    order.resize(count);
    return measure(order);
  }

private:
  static constexpr std::size_t kMeasured = 6;
  static constexpr int kSteps = 4;

  /// The greatest distance from the points to where Newton's steps along the gradient end. Where they do not come to
  /// the surface, what the first order tells stands.
  double measure(const std::vector<std::size_t>& chosen) {
    PointArrays at;
    for (const std::size_t i : chosen) at.add(mPoints.at(i));
    std::vector<double> first;
    ValueArrays values;
    for (int step = 0; step < kSteps; ++step) {
      mEvaluator.gradients(at, values);
      if (step == 0) first = values.value;
      PointArrays next;
      for (std::size_t k = 0; k < chosen.size(); ++k) {
        const Tangent tangent = values.tangent(k);
        next.add(along(at.at(k), tangent.normal, -tangent.distance));
      }
      at = std::move(next);
    }
    double greatest = 0;
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      const bool reached = std::abs(values.value[k]) <= kReached * std::abs(first[k]);
      greatest = std::max(greatest, reached ? length(difference(at.at(k), mPoints.at(chosen[k]))) : mValues[chosen[k]]);
    }
    return greatest;
  }
  static constexpr double kReached = .05;

  PointEvaluator& mEvaluator;
  PointArrays mPoints;
  std::vector<double> mSlopes, mValues; // the latter become distances, to first order
};

/// Samples in the middle of each triangle and edge; an edge between two faces by the face that runs along it upwards.
double deviationOf(const QuadMesh& mesh, std::size_t block, const Triangle* triangles, PointEvaluator& evaluator) {
  DeviationSearch search(evaluator);
  const std::size_t first = mesh.firstQuad(block);
  for (std::size_t q = first; q < mesh.firstQuad(block + 1); ++q) {
    const double slope = mesh.crossing(block, q).slope;
    const Triangle *t = triangles + 2 * (q - first), *u = t + 1;
    search.add(centroid(mesh, *t), slope);
    search.add(centroid(mesh, *u), slope);
    const auto& d = mesh.positions;
    search.add(between(d[(*u)[0]], d[(*t)[2]]), slope); // the ends of the diagonal
    const Quad& quad = mesh.quad(q);
    for (int k = 0; k < 4; ++k)
      if (quad[k] < quad[(k + 1) % 4]) search.add(between(d[quad[k]], d[quad[(k + 1) % 4]]), slope);
  }
  return search.run();
}

/// Of what a block's measure depends on beside its program.
std::uint64_t measureKey(const QuadMesh& mesh, std::size_t block, std::uint64_t partsKey) {
  XxHash64 hash;
  hash.add(&partsKey, sizeof partsKey);
  for (std::size_t q = mesh.firstQuad(block); q < mesh.firstQuad(block + 1); ++q) {
    const Quad& quad = mesh.quad(q);
    for (int k = 0; k < 4; ++k) {
      const auto runsUp = static_cast<unsigned char>(quad[k] < quad[(k + 1) % 4]);
      hash.add(&mesh.positions[quad[k]], sizeof(Vec3d));
      hash.add(&runsUp, 1);
    }
  }
  return hash.digest() | 1;
}

} // namespace

std::uint64_t triangulateBlock(const QuadMesh& mesh, std::size_t block, std::uint64_t partsKey, ShapeScratch& scratch,
                               std::array<std::uint32_t, 3>* out, BlockMeasure& measure) {
  const std::size_t first = mesh.firstQuad(block), count = mesh.firstQuad(block + 1) - first;
  for (std::size_t q = 0; q < count; ++q) {
    const auto both = mesh.triangles(mesh.quad(first + q), mesh.crossing(block, first + q));
    out[2 * q] = both[0];
    out[2 * q + 1] = both[1];
  }
  const std::uint64_t key = measureKey(mesh, block, partsKey);
  if (count == 0 || measure.key == key) return 0;
  PointEvaluator evaluator(mesh.block(block).program, scratch);
  measure.key = key;
  measure.deviation = deviationOf(mesh, block, out, evaluator);
  measure.parts.clear();
  if (partsKey != 0) {
    PointArrays middles;
    for (std::size_t t = 0; t < 2 * count; ++t) middles.add(centroid(mesh, out[t]));
    evaluator.parts(middles, measure.parts);
  }
  return evaluator.count();
}

} // namespace volcaustic
