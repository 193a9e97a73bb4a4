#include "volume/sharpen_coverage.h"

#include "core/parallel.h"
#include "core/simd_clones.h"
#include "volume/iso_surface.h"

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
  for (int i = 0; i < 30; ++i) {
    const double middle = .5 * (low + high);
    (cubeBeneath(normal, middle) < mean ? low : high) = middle;
  }
  return cubeBeneath(normal, std::clamp(.5 + 3 * (high - .5), 0.0, 1.0));
}

[[gnu::always_inline]] inline void sum3(const float* in, int step, int count, float* out) {
  for (int i = 0; i < count; ++i) out[i] = in[i] + in[i + step] + in[i + 2 * step];
}
[[gnu::always_inline]] inline void difference3(const float* in, int step, int count, float* out) {
  for (int i = 0; i < count; ++i) out[i] = in[i + 2 * step] - in[i];
}
[[gnu::always_inline]] inline void greatest3(const float* in, int step, int count, float* out) {
  for (int i = 0; i < count; ++i) out[i] = std::max(std::max(in[i], in[i + step]), in[i + 2 * step]);
}

/// What the 3^3 voxels around each voxel of a leaf sum up to, taken along one axis after the other.
class LeafBlock {
public:
  template <class Leaf, class Accessor>
  void gather(const Leaf& leaf, const Accessor& tree) {
    std::array<std::array<float, 8>, 27> constants;
    std::array<Source, 27> sources;
    for (int i = 0; i < 27; ++i) {
      const openvdb::Coord origin = leaf.origin().offsetBy(8 * (i / 9 - 1), 8 * (i / 3 % 3 - 1), 8 * (i % 3 - 1));
      const auto* source = i == 13 ? &leaf : tree.probeConstLeaf(origin);
      if (!source) constants[i].fill(tree.getValue(origin));
      sources[i] = source ? Source{source->buffer().data(), 8} : Source{constants[i].data(), 0};
    }
    float* out = mValues.data();
    for (int x = -1; x < 9; ++x)
      for (int y = -1; y < 9; ++y, out += kEdge) {
        const Source* source = &sources[((x + 8) >> 3) * 9 + ((y + 8) >> 3) * 3];
        const int row = (x & 7) * 8 + (y & 7);
        out[0] = source[0].row(row)[7];
        std::copy_n(source[1].row(row), 8, out + 1);
        out[9] = source[2].row(row)[0];
      }
    sumUp();
  }

  /// The value that replaces that of the leaf's voxel.
  [[nodiscard]] float sharpened(const PlaneCoverage& plane, int offset) const {
    const int x = offset >> 6, y = offset >> 3 & 7, z = offset & 7;
    const float own = mValues[((x + 1) * kEdge + y + 1) * kEdge + z + 1];
    const float unexplained =
        own - plane.centre(mSum[offset] / 27, {mSlopeX[offset], mSlopeY[offset], mSlopeZ[offset]});
    float value = own + kGain * (unexplained - std::clamp(unexplained, -kTolerance, kTolerance));
    if (const float greatest = mGreatest[offset]; greatest < kLonely)
      value = std::max(value, own * (kLonely / greatest));
    return clearOf(.5f, std::clamp(value, 0.0f, 1.0f), 1);
  }

private:
  static constexpr int kEdge = 10, kVoxels = 512;
  /// Where a neighbour's rows lie: its voxels, or one row of its constant for all.
  struct Source {
    const float* rows;
    int stride;
    [[nodiscard]] const float* row(int i) const { return rows + stride * i; }
  };

  VOLCAUSTIC_SIMD_CLONES void sumUp() {
    constexpr int kRows = kEdge * kEdge, kPlane = 64;
    std::array<float, kRows * 8> sumZ, slopeZ, greatestZ;
    for (int row = 0; row < kRows; ++row) {
      sum3(&mValues[row * kEdge], 1, 8, &sumZ[row * 8]);
      difference3(&mValues[row * kEdge], 1, 8, &slopeZ[row * 8]);
      greatest3(&mValues[row * kEdge], 1, 8, &greatestZ[row * 8]);
    }
    std::array<float, kEdge * kPlane> sumYz, slopeY, slopeZy, greatestYz;
    for (int x = 0; x < kEdge; ++x) {
      sum3(&sumZ[x * kEdge * 8], 8, kPlane, &sumYz[x * kPlane]);
      difference3(&sumZ[x * kEdge * 8], 8, kPlane, &slopeY[x * kPlane]);
      sum3(&slopeZ[x * kEdge * 8], 8, kPlane, &slopeZy[x * kPlane]);
      greatest3(&greatestZ[x * kEdge * 8], 8, kPlane, &greatestYz[x * kPlane]);
    }
    sum3(sumYz.data(), kPlane, kVoxels, mSum.data());
    difference3(sumYz.data(), kPlane, kVoxels, mSlopeX.data());
    sum3(slopeY.data(), kPlane, kVoxels, mSlopeY.data());
    sum3(slopeZy.data(), kPlane, kVoxels, mSlopeZ.data());
    greatest3(greatestYz.data(), kPlane, kVoxels, mGreatest.data());
  }

  std::array<float, kEdge * kEdge * kEdge> mValues;
  std::array<float, kVoxels> mSum, mSlopeX, mSlopeY, mSlopeZ, mGreatest;
};

} // namespace

PlaneCoverage::PlaneCoverage() {
  for (int s = 0; s < kRatios; ++s)
    for (int m = s; m < kRatios; ++m)
      for (int i = 0; i < kMeans; ++i) {
        // A component of zero would divide by zero, and one of a fiftieth gives the same to a hundredth.
        std::array<double, 3> normal{std::max(s / (kRatios - 1.0), .02), std::max(m / (kRatios - 1.0), .02), 1};
        const double length = normal[0] + normal[1] + normal[2];
        for (double& component : normal) component /= length;
        mCentre[s][m][i] = static_cast<float>(centreBeneath(normal, .5 * i / (kMeans - 1)));
        mCentre[m][s][i] = mCentre[s][m][i];
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
