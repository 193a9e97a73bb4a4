#include "volume/sharpen_coverage.h"

#include "core/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace volcaustic {

namespace {

// Chosen by the table in docs/algorithms/surface.md.
constexpr float kGain = 6;         ///< how far a voxel is moved by what no plane explains in it
constexpr float kTolerance = .06f; ///< of coverage: what sampling at 4^3 sub-voxels leaves unexplained on a plane
constexpr float kLonely = .6f;     ///< the greatest coverage of a neighbourhood is raised to it: just a surface

/// The part of the unit cube beneath the plane a x + b y + c z = d, for a + b + c = 1, all above zero (Scardovelli &
/// Zaleski, Analytical relations connecting linear interfaces and volume fractions in rectangular grids, 2000).
double cubeBeneath(const std::array<double, 3>& normal, double d) {
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double depth = d, sign = 1;
    for (int a = 0; a < 3; ++a)
      if (corner >> a & 1) {
        depth -= normal[a];
        sign = -sign;
      }
    if (depth > 0) sum += sign * depth * depth * depth;
  }
  return std::clamp(sum / (6 * normal[0] * normal[1] * normal[2]), 0.0, 1.0);
}

/// The same plane seen by a block of 3^3 cubes, which it leaves `mean` of beneath it, and by the cube at its centre.
double centreBeneath(const std::array<double, 3>& normal, double mean) {
  double low = 0, high = 1;
  for (int i = 0; i < 40; ++i) {
    const double middle = .5 * (low + high);
    (cubeBeneath(normal, middle) < mean ? low : high) = middle;
  }
  return cubeBeneath(normal, std::clamp(.5 + 3 * (high - .5), 0.0, 1.0));
}

/// A leaf's voxels and those around it.
class LeafBlock {
public:
  static constexpr int kEdge = 10;

  template <class Leaf, class Accessor>
  void gather(const Leaf& leaf, const Accessor& tree) {
    const auto first = [](int side) { return side < 0 ? 0 : side == 0 ? 1 : kEdge - 1; };
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const openvdb::Coord origin = leaf.origin() + openvdb::Coord(8 * x, 8 * y, 8 * z);
          const auto* source = x || y || z ? tree.probeConstLeaf(origin) : &leaf;
          const float constant = source ? 0 : tree.getValue(origin);
          for (int i = first(x); i <= (x ? first(x) : 8); ++i)
            for (int j = first(y); j <= (y ? first(y) : 8); ++j)
              for (int k = first(z); k <= (z ? first(z) : 8); ++k)
                mValues[(i * kEdge + j) * kEdge + k] =
                    source ? source->getValue((((i - 1) & 7) << 6) + (((j - 1) & 7) << 3) + ((k - 1) & 7)) : constant;
        }
  }

  /// The value that replaces that of the leaf's voxel.
  [[nodiscard]] float sharpened(const PlaneCoverage& plane, int offset) const {
    const int x = offset >> 6, y = offset >> 3 & 7, z = offset & 7; // the corner of its 3^3 neighbours
    const float own = mValues[((x + 1) * kEdge + y + 1) * kEdge + z + 1];
    float sum = 0, greatest = 0;
    std::array<float, 3> slope{};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
          const float value = mValues[((x + i) * kEdge + y + j) * kEdge + z + k];
          sum += value;
          greatest = std::max(greatest, value);
          slope[0] += static_cast<float>(i - 1) * value;
          slope[1] += static_cast<float>(j - 1) * value;
          slope[2] += static_cast<float>(k - 1) * value;
        }
    const float unexplained = own - plane.centre(sum / 27, slope);
    float value = own + kGain * (unexplained - std::clamp(unexplained, -kTolerance, kTolerance));
    if (greatest < kLonely) value = std::max(value, own * (kLonely / greatest));
    return std::clamp(value, 0.0f, 1.0f);
  }

private:
  std::array<float, kEdge * kEdge * kEdge> mValues;
};

} // namespace

PlaneCoverage::PlaneCoverage() {
  for (int s = 0; s < kRatios; ++s)
    for (int m = 0; m < kRatios; ++m)
      for (int i = 0; i < kMeans; ++i) {
        // A component of zero would divide by zero, and one of a fiftieth gives the same to a hundredth.
        std::array<double, 3> normal{std::max(s / (kRatios - 1.0), .02), std::max(m / (kRatios - 1.0), .02), 1};
        const double length = normal[0] + normal[1] + normal[2];
        for (double& component : normal) component /= length;
        mCentre[s][m][i] = static_cast<float>(centreBeneath(normal, .5 * i / (kMeans - 1)));
      }
}

float PlaneCoverage::centre(float mean, const std::array<float, 3>& normal) const {
  std::array<float, 3> n{std::abs(normal[0]), std::abs(normal[1]), std::abs(normal[2])};
  std::sort(n.begin(), n.end());
  if (!(n[2] > 1e-6f)) return mean;
  const auto split = [](float place, int last) {
    const int cell = std::clamp(static_cast<int>(place), 0, last - 1);
    return std::pair(cell, place - static_cast<float>(cell));
  };
  const auto [s, fs] = split(n[0] / n[2] * (kRatios - 1), kRatios - 1);
  const auto [m, fm] = split(n[1] / n[2] * (kRatios - 1), kRatios - 1);
  const auto [i, fi] = split(std::min(mean, 1 - mean) * 2 * (kMeans - 1), kMeans - 1);
  const auto along = [i = i, fi = fi](const std::array<float, kMeans>& row) {
    return row[i] + fi * (row[i + 1] - row[i]);
  };
  const float low = along(mCentre[s][m]) * (1 - fm) + along(mCentre[s][m + 1]) * fm;
  const float high = along(mCentre[s + 1][m]) * (1 - fm) + along(mCentre[s + 1][m + 1]) * fm;
  const float part = low + fs * (high - low);
  return mean > .5f ? 1 - part : part;
}

openvdb::FloatGrid::Ptr sharpenedCoverage(const openvdb::FloatGrid& coverage, const RunContext& ctx) {
  static const PlaneCoverage plane;
  ctx.requireMemory(coverage.memUsage(), "sharpening the coverage");
  const openvdb::FloatGrid::Ptr result = coverage.deepCopy();
  std::vector<const openvdb::FloatTree::LeafNodeType*> from;
  std::vector<openvdb::FloatTree::LeafNodeType*> to;
  coverage.tree().getNodes(from);
  result->tree().getNodes(to);
  parallelFor(static_cast<std::int64_t>(from.size()), 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    const openvdb::FloatGrid::ConstAccessor tree = coverage.getConstAccessor();
    LeafBlock block;
    for (std::int64_t i = begin; i < end; ++i) {
      const float* values = from[i]->buffer().data();
      const auto partial = [](float value) { return value > 0 && value < 1; };
      if (std::none_of(values, values + from[i]->SIZE, partial)) continue;
      block.gather(*from[i], tree);
      for (unsigned v = 0; v < from[i]->SIZE; ++v)
        if (partial(values[v])) to[i]->setValueOnly(v, block.sharpened(plane, static_cast<int>(v)));
    }
  });
  return result;
}

} // namespace volcaustic
