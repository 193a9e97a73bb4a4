#include "volume/cap_offsets.h"

#include "core/parallel.h"
#include "core/simd_clones.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace volcaustic {

namespace {

/// A sample on a cap lies on the side where the rows put it: they take it to be a little further along x and less so
/// along y, and in z the crossing to be before it.
constexpr Vec3d kNudge{0x1p-24, 0x1p-32, 0x1p-18};
/// Below, looking for the few caps that are near takes longer than adding them up at every sample.
constexpr int kSmallestCube = 8;

/// Triangles or edges of the snapped caps, so that rows cross them exactly where the winding number jumps.
template <std::size_t N>
std::vector<std::array<Vec3d, N>>
snappedItems(const LoopCaps& caps, const std::vector<std::array<std::uint32_t, N>>& items, const SubLattice& lattice) {
  std::vector<std::array<Vec3d, N>> result;
  const auto snapped = [&](std::uint32_t v) {
    const auto p = lattice.snap(caps.positions[v]);
    return Vec3d{double(p.x) / double(kFixedOne), double(p.y) / double(kFixedOne), double(p.z) / double(kFixedOne)};
  };
  for (const auto& item : items) {
    auto& corners = result.emplace_back();
    std::transform(item.begin(), item.end(), corners.begin(), snapped);
  }
  return result;
}

Vec3i octantOf(const Vec3i& first, int half, int octant) {
  return {first[0] + (octant >> 2) * half, first[1] + (octant >> 1 & 1) * half, first[2] + (octant & 1) * half};
}

Vec3d centreOf(const Vec3i& first, int n) { return {first[0] + 0.5 * n, first[1] + 0.5 * n, first[2] + 0.5 * n}; }
double halfDiagonal(int n) { return 0.5 * n * std::numbers::sqrt3; } // samples are inside their sub-voxels

inline std::int16_t offsetOf(int whole) { return static_cast<std::int16_t>(-whole); }

/// offsetOf(roundedWinding()) of a row of samples.
VOLCAUSTIC_SIMD_CLONES void roundSamples(const double* winding, int n, std::int16_t* __restrict offsets) {
  for (int k = 0; k < n; ++k) offsets[k] = offsetOf(roundedWinding(winding[k]));
}
/// The same beyond whole jumps, from a branch that is a whole number off.
VOLCAUSTIC_SIMD_CLONES void roundJumping(const double* winding, int n, double branch, const std::int16_t* jumps,
                                         std::int16_t* __restrict offsets) {
  for (int k = 0; k < n; ++k) offsets[k] = offsetOf(roundedWinding(winding[k] + (branch + jumps[k])));
}

/// Whether (x, y) is left of the line from a to b, seen from +z. Exactly the opposite of b to a.
bool isLeft(const Vec3d& a, const Vec3d& b, double x, double y) {
  const bool turned = std::pair(b[0], b[1]) < std::pair(a[0], a[1]);
  const Vec3d &from = turned ? b : a, &to = turned ? a : b;
  return ((to[0] - from[0]) * (y - from[1]) - (to[1] - from[1]) * (x - from[0]) >= 0) != turned;
}

/// The offsets of one brick, cube by cube. Away from the boundary of the caps their winding number is smooth but for
/// whole jumps at the caps: there it is interpolated from few points, and the jumps are counted along the rows. Near
/// the boundary the cubes become smaller, down to where the few near caps are added up at every sample.
class BrickSampler {
public:
  BrickSampler(const CapWinding& winding, const SubLattice& lattice, const std::vector<CubeInterpolation>& levels,
               const Vec3i& first, std::vector<std::int16_t>& offsets)
      : mWinding(winding), mLattice(lattice), mLevels(levels), mFirst(first), mOffsets(offsets), mNear(levels.size()) {
    const int n = levels.back().size();
    for (int x = 0; x < n; ++x)
      for (int y = 0; y < n; ++y)
        for (int z = 0; z < n; ++z) mSmallestSamples.add(nudgedSample(x, y, z));
  }

  void run() {
    const CubeInterpolation& brick = mLevels[0];
    std::vector<CapWinding::Group> caps;
    mPoints.place(brick.farNodes(), {double(mFirst[0]), double(mFirst[1]), double(mFirst[2])});
    mWinding.addFar(CapWinding::kAll, centreOf(mFirst, brick.size()), halfDiagonal(brick.size()),
                    CubeInterpolation::kFarClearance * 0.5 * brick.size(), mPoints, caps);
    sampleCube(mFirst, 0, CubeInterpolation::fromFarNodes(mPoints), caps, 0, CapWinding::kAll);
  }

private:
  using Values = CubeInterpolation::Values;
  using Groups = std::span<const CapWinding::Group>;

  /// `far` are the values, at the cube's nodes, of all caps but `caps`, and `gradient` bounds what all edges but
  /// `edges` contribute to the gradient.
  void sampleCube(const Vec3i& first, std::size_t level, Values far, Groups caps, double gradient, Groups edges) {
    const int n = mLevels[level].size();
    const Vec3d centre = centreOf(first, n);
    const double radius = halfDiagonal(n), clearance = CubeInterpolation::kClearance * 0.5 * n;
    auto& [nearCaps, nearEdges] = mNear[level];
    placeAtNodes(first, level);
    mWinding.addFar(caps, centre, radius, clearance, mPoints, nearCaps);
    mPoints.addSumsTo(far.data());
    mWinding.addFarEdges(edges, centre, radius, clearance, gradient, nearEdges);

    const double change = radius * (gradient + mWinding.nearGradient(nearEdges, centre, radius));
    if (const auto whole = wholeIn(centre, radius, far, nearCaps, change)) return fill(first, n, offsetOf(*whole));
    if (nearEdges.empty() && (change < kUnambiguous || allSpan(nearCaps, centre, clearance)))
      return sampleSmooth(first, level, far);
    if (level + 1 == mLevels.size()) return sampleSingly(first, level, far);
    for (int octant = 0; octant < 8; ++octant)
      sampleCube(octantOf(first, n / 2, octant), level + 1, CubeInterpolation::atOctant(far, octant), nearCaps,
                 gradient, nearEdges);
  }

  /// What the cube's winding numbers round to, where it is one number: they change from the centre by no more than
  /// `change`, nor by more than those of far and of near caps do.
  [[nodiscard]] std::optional<int> wholeIn(const Vec3d& centre, double radius, const Values& far, Groups near,
                                           double change) {
    if (isCrossed(near, centre, radius)) return std::nullopt;
    const double nearChange = mWinding.nearChange(near, centre, radius);
    if (change >= 0.5 && nearChange >= 0.5) return std::nullopt;
    mCentre.clear();
    mCentre.add(centre);
    mWinding.addNear(near, mCentre);
    if (const auto whole = oneWhole(far[CubeInterpolation::kMiddle] + mCentre.sum(0), change)) return whole;
    const auto [middle, farChange] = CubeInterpolation::range(far);
    return oneWhole(middle + mCentre.sum(0), farChange + nearChange);
  }

  [[nodiscard]] bool isCrossed(Groups caps, const Vec3d& centre, double radius) const {
    return std::any_of(caps.begin(), caps.end(), [&](CapWinding::Group g) {
      return distanceToTriangle(centre, mWinding.cap(g).corners) <= radius;
    });
  }

  /// Whether no cap ends within `clearance`: what is near of each is its plane, and the winding number jumps across
  /// that by the cap's weight.
  [[nodiscard]] bool allSpan(Groups caps, const Vec3d& centre, double clearance) const {
    return std::all_of(caps.begin(), caps.end(),
                       [&](CapWinding::Group g) { return distanceToRim(centre, mWinding.cap(g).corners) > clearance; });
  }

  void placeAtNodes(const Vec3i& first, std::size_t level) {
    mPoints.place(mLevels[level].nodes(), {double(first[0]), double(first[1]), double(first[2])});
  }

  /// Near caps at every sample.
  void sampleSingly(const Vec3i& first, std::size_t level, const Values& far) {
    const int n = mLevels[level].size();
    mPoints.place(mSmallestSamples, {double(first[0]), double(first[1]), double(first[2])});
    mWinding.addNear(mNear[level].caps, mPoints);
    mLevels[level].atSamples(far, mSmooth);
    mPoints.addSumsTo(mSmooth.data());
    for (int row = 0; row < n * n; ++row)
      roundSamples(mSmooth.data() + static_cast<std::ptrdiff_t>(row) * n, n, rowOf(first, n, row));
  }

  /// All caps by interpolation of the branch on which the cube's centre is.
  void sampleSmooth(const Vec3i& first, std::size_t level, const Values& far) {
    const int n = mLevels[level].size();
    const Values nearOnly = nearOnBranch(first, level, far);
    Values all;
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = far[i] + nearOnly[i];
    const bool crossed = countJumps(first, level);
    if (!crossed)
      if (const auto [middle, change] = CubeInterpolation::range(all); const auto whole = oneWhole(middle, change))
        return fill(first, n, offsetOf(*whole));
    mLevels[level].atSamples(all, mSmooth);
    if (!crossed) {
      for (int row = 0; row < n * n; ++row)
        roundSamples(mSmooth.data() + static_cast<std::ptrdiff_t>(row) * n, n, rowOf(first, n, row));
      return;
    }
    placeOnRows(first, n);
    mWinding.addNear(mNear[level].caps, mPoints);
    mLevels[level].atSamples(nearOnly, mSmoothNear);
    for (int row = 0; row < n * n; ++row) {
      const std::int16_t* const jumps = mJumps.data() + static_cast<std::ptrdiff_t>(row) * (n + 1);
      const int reference = mReference[row];
      const double branch = std::round(mPoints.sum(row) - mSmoothNear[row * n + reference]) - jumps[reference];
      roundJumping(mSmooth.data() + static_cast<std::ptrdiff_t>(row) * n, n, branch, jumps, rowOf(first, n, row));
    }
  }

  /// Near caps at the cube's nodes, less the jumps on the way from its centre. A cap that spans the cube jumps from one
  /// sign to the other; how often others do is known where the sum of all changes by less than one half.
  Values nearOnBranch(const Vec3i& first, std::size_t level, const Values& far) {
    const double clearance = CubeInterpolation::kClearance * 0.5 * mLevels[level].size();
    const Vec3d centre = centreOf(first, mLevels[level].size());
    Values sum{};
    bool spans = true;
    for (const CapWinding::Group g : mNear[level].caps) {
      mPoints.resetSums();
      mWinding.addNear({&g, 1}, mPoints);
      Values one{};
      mPoints.addSumsTo(one.data());
      if (distanceToRim(centre, mWinding.cap(g).corners) > clearance) {
        const bool positive = one[CubeInterpolation::kMiddle] > 0;
        const double jump = std::abs(mWinding.cap(g).weight) * (positive ? 1 : -1);
        for (double& w : one) w += (w > 0) == positive ? 0 : jump;
      } else {
        spans = false;
      }
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += one[i];
    }
    if (spans) return sum;
    const double atCentre = far[CubeInterpolation::kMiddle] + sum[CubeInterpolation::kMiddle];
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] -= std::round(far[i] + sum[i] - atCentre);
    return sum;
  }

  /// For every row of a cube the jump between its start and each sample. False where no cap crosses the cube.
  bool countJumps(const Vec3i& first, std::size_t level) {
    const int n = mLevels[level].size();
    const Vec3d centre = centreOf(first, n);
    bool any = false;
    for (const CapWinding::Group g : mNear[level].caps) {
      const WeightedTriangle& cap = mWinding.cap(g);
      if (distanceToTriangle(centre, cap.corners) > halfDiagonal(n)) continue;
      if (!any) mJumps.assign(static_cast<std::size_t>(n) * n * (n + 1), 0);
      any = true;
      addJumps(cap, first, n);
    }
    if (!any) return false;
    mReference.resize(static_cast<std::size_t>(n) * n);
    for (int row = 0; row < n * n; ++row) {
      std::int16_t* const jumps = mJumps.data() + static_cast<std::ptrdiff_t>(row) * (n + 1);
      int start = 0, longest = 0;
      for (int k = 1; k <= n; ++k) {
        const bool ends = jumps[k] != 0 || k == n;
        if (ends && k - start > longest) {
          longest = k - start;
          mReference[row] = start + longest / 2; // as far from caps as may be
        }
        if (ends) start = k;
        jumps[k] = static_cast<std::int16_t>(jumps[k] + jumps[k - 1]);
      }
    }
    return true;
  }

  void addJumps(const WeightedTriangle& cap, const Vec3i& first, int n) {
    const auto& [a, b, c] = cap.corners;
    const Vec3d u{b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const double nx = u[1] * v[2] - u[2] * v[1], ny = u[2] * v[0] - u[0] * v[2], nz = u[0] * v[1] - u[1] * v[0];
    if (nz == 0) return;
    const auto jump =
        static_cast<std::int16_t>(nz > 0 ? -cap.weight : cap.weight); // up through a face that looks up: out
    const auto rowRange = [&](int axis) {
      const auto [low, high] = std::minmax({a[axis], b[axis], c[axis]});
      return std::pair(static_cast<int>(std::clamp(std::floor(low - first[axis]) - 1, 0.0, double(n))),
                       static_cast<int>(std::clamp(std::ceil(high - first[axis]) + 1, 0.0, double(n))));
    };
    const auto [i0, i1] = rowRange(0);
    const auto [j0, j1] = rowRange(1);
    for (int i = i0; i < i1; ++i)
      for (int j = j0; j < j1; ++j) {
        const Vec3d p = nudgedSample(first[0] + i, first[1] + j, first[2]);
        const bool left = isLeft(a, b, p[0], p[1]);
        if (left != isLeft(b, c, p[0], p[1]) || left != isLeft(c, a, p[0], p[1])) continue;
        const double crossing = a[2] - ((p[0] - a[0]) * nx + (p[1] - a[1]) * ny) / nz;
        const double before = std::clamp(std::ceil(crossing - p[2]), 0.0, double(n)); // samples
        mJumps[static_cast<std::size_t>(i * n + j) * (n + 1) + static_cast<std::size_t>(before)] += jump;
      }
  }

  void placeOnRows(const Vec3i& first, int n) {
    mPoints.clear();
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        mPoints.add(nudgedSample(first[0] + i, first[1] + j, first[2] + mReference[i * n + j]));
  }

  void fill(const Vec3i& first, int n, std::int16_t offset) {
    for (int row = 0; row < n * n; ++row) std::fill_n(rowOf(first, n, row), n, offset);
  }

  [[nodiscard]] Vec3d nudgedSample(int i, int j, int k) const {
    const Vec3d p = mLattice.sample(i, j, k);
    return {p[0] + kNudge[0], p[1] + kNudge[1], p[2] + kNudge[2]};
  }

  /// Where the brick keeps the offsets of a cube's row.
  [[nodiscard]] std::int16_t* rowOf(const Vec3i& first, int n, int row) const {
    const int all = mLevels[0].size(), x = first[0] - mFirst[0] + row / n, y = first[1] - mFirst[1] + row % n;
    return mOffsets.data() + (static_cast<std::ptrdiff_t>(x) * all + y) * all + (first[2] - mFirst[2]);
  }

  /// Winding numbers that differ by less are known to be on one branch.
  static constexpr double kUnambiguous = 0.45;

  const CapWinding& mWinding;
  const SubLattice& mLattice;
  const std::vector<CubeInterpolation>& mLevels;
  Vec3i mFirst;
  std::vector<std::int16_t>& mOffsets;
  struct Near {
    std::vector<CapWinding::Group> caps, edges;
  };
  std::vector<Near> mNear; // the present cube of each level
  PointSums mPoints, mCentre;
  PointSums mSmallestSamples; // of the smallest cubes, nudged, seen from their low corners
  std::vector<double> mSmooth, mSmoothNear;
  std::vector<std::int16_t> mJumps;
  std::vector<int> mReference;
};

} // namespace

CapOffsets::CapOffsets(const LoopCaps& caps, const SubLattice& lattice, const RunContext& ctx)
    : mLattice(lattice)
    , mWinding(snappedItems(caps, caps.triangles, lattice), snappedItems(caps, caps.edges, lattice)) {
  for (int n = lattice.brickSamples(); n >= std::max(kSmallestCube, 1 << lattice.log2); n /= 2)
    mLevels.emplace_back(n, lattice.log2);
  for (int a = 0; a < 3; ++a) mBricks[a] = lattice.size[a] / lattice.brickSamples();
  mTable.assign(static_cast<std::size_t>(mBricks[0]) * mBricks[1] * mBricks[2], 0);
  constexpr int kBlock = 8; // bricks along an edge of what one thread takes at a time
  Vec3i blocks{};
  for (int a = 0; a < 3; ++a) blocks[a] = (mBricks[a] + kBlock - 1) / kBlock;
  parallelFor(std::int64_t{blocks[0]} * blocks[1] * blocks[2], 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t b = begin; b < end; ++b) {
      const int z = static_cast<int>(b % blocks[2]), y = static_cast<int>(b / blocks[2] % blocks[1]);
      const int x = static_cast<int>(b / blocks[2] / blocks[1]);
      fillBricks({x * kBlock, y * kBlock, z * kBlock}, kBlock);
    }
  });
}

void CapOffsets::fillBricks(const Vec3i& first, int n) {
  for (int a = 0; a < 3; ++a)
    if (first[a] >= mBricks[a]) return;
  const int samples = mLattice.brickSamples();
  const Vec3d centre = centreOf({first[0] * samples, first[1] * samples, first[2] * samples}, n * samples);
  const std::optional<int> whole = mWinding.wholeWithin(centre, halfDiagonal(n * samples));
  if (!whole && n > 1) {
    for (int octant = 0; octant < 8; ++octant) fillBricks(octantOf(first, n / 2, octant), n / 2);
    return;
  }
  for (int x = first[0]; x < std::min(first[0] + n, mBricks[0]); ++x)
    for (int y = first[1]; y < std::min(first[1] + n, mBricks[1]); ++y)
      for (int z = first[2]; z < std::min(first[2] + n, mBricks[2]); ++z)
        mTable[(static_cast<std::size_t>(x) * mBricks[1] + y) * mBricks[2] + z] = whole ? offsetOf(*whole) : kVaries;
}

void CapOffsets::ofSamples(const Vec3i& brick, std::vector<std::int16_t>& offsets) const {
  const int n = mLattice.brickSamples();
  offsets.resize(static_cast<std::size_t>(n) * n * n);
  BrickSampler(mWinding, mLattice, mLevels, {brick[0] * n, brick[1] * n, brick[2] * n}, offsets).run();
}

} // namespace volcaustic
