#include "volume/topology_refine.h"

#include <algorithm>
#include <unordered_map>

namespace volcaustic {

namespace {

std::uint64_t edgeKey(std::uint32_t a, std::uint32_t b) { return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b); }

class Refiner {
public:
  Refiner(const BlockGrid& grid, const std::vector<float>& level, double near, double longest,
          std::vector<Vec3d>& positions)
      : mLongest(longest), mRadius(grid.voxelSize() * BlockGrid::kSide * std::sqrt(3.0) / 2), mPositions(positions) {
    for (std::size_t b = 0; b < grid.blocks().size(); ++b) {
      const auto first = level.begin() + static_cast<std::ptrdiff_t>(b * BlockGrid::kNodes);
      if (*std::min_element(first, first + BlockGrid::kNodes) >= near) continue;
      Vec3d centre = grid.position(grid.blocks()[b]);
      for (double& x : centre) x += grid.voxelSize() * (BlockGrid::kSide - 1) / 2;
      mCentres.push_back(centre);
    }
  }

  void refine(RefinedTriangles& r) {
    while (markLongEdges(r)) divide(r);
  }

private:
  [[nodiscard]] double squaredLength(std::uint32_t a, std::uint32_t b) const {
    const Vec3d d = difference(mPositions[a], mPositions[b]);
    return dot(d, d);
  }
  [[nodiscard]] bool isNearChange(const TriangleCorners& t) const {
    return std::any_of(mCentres.begin(), mCentres.end(), [&](const Vec3d& p) {
      const Vec3d c = closestPointOfTriangle(p, mPositions[t[0]], mPositions[t[1]], mPositions[t[2]]);
      const Vec3d d = difference(p, c);
      return dot(d, d) <= mRadius * mRadius;
    });
  }

  bool markLongEdges(const RefinedTriangles& r) {
    mMiddle.clear();
    const double limit = mLongest * mLongest;
    for (const TriangleCorners& t : r.triangles) {
      std::array<double, 3> squared;
      for (int k = 0; k < 3; ++k) squared[k] = squaredLength(t[k], t[(k + 1) % 3]);
      const double most = *std::max_element(squared.begin(), squared.end());
      if (most <= limit || !isNearChange(t)) continue;
      for (int k = 0; k < 3; ++k) { // edges that are long beside the longest one, so that pieces do not grow thin
        constexpr double kAlike = 0.5;
        if (squared[k] <= limit || squared[k] < kAlike * most) continue;
        const Vec3d &a = mPositions[t[k]], &b = mPositions[t[(k + 1) % 3]];
        const auto [entry, isNew] =
            mMiddle.try_emplace(edgeKey(t[k], t[(k + 1) % 3]), static_cast<std::uint32_t>(mPositions.size()));
        if (isNew) mPositions.push_back({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2});
      }
    }
    return !mMiddle.empty();
  }

  void divide(RefinedTriangles& r) {
    const std::size_t count = r.triangles.size();
    for (std::size_t i = 0; i < count; ++i) {
      std::array<std::uint32_t, 3> middle;
      int divided = 0;
      for (int k = 0; k < 3; ++k) {
        const auto entry = mMiddle.find(edgeKey(r.triangles[i][k], r.triangles[i][(k + 1) % 3]));
        middle[k] = entry == mMiddle.end() ? kNone : entry->second;
        divided += middle[k] != kNone;
      }
      if (divided == 0) continue;
      mPieces.clear();
      dividePiece(r.triangles[i], middle, divided);
      r.triangles[i] = mPieces[0];
      r.whole[i] = false;
      for (std::size_t p = 1; p < mPieces.size(); ++p) {
        r.triangles.push_back(mPieces[p]);
        r.source.push_back(r.source[i]);
        r.whole.push_back(false);
      }
    }
  }

  void dividePiece(const TriangleCorners& t, const std::array<std::uint32_t, 3>& middle, int divided) {
    // Turned so that edge 0 is the one divided alone, or edge 2 the one left alone.
    int turn = 0;
    if (divided == 1)
      while (middle[turn] == kNone) ++turn;
    if (divided == 2)
      while (middle[(turn + 2) % 3] != kNone) ++turn;
    const auto [a, b, c] = TriangleCorners{t[turn], t[(turn + 1) % 3], t[(turn + 2) % 3]};
    const auto [ab, bc, ca] = TriangleCorners{middle[turn], middle[(turn + 1) % 3], middle[(turn + 2) % 3]};
    if (divided == 1) mPieces = {{a, ab, c}, {ab, b, c}};
    if (divided == 2) {
      mPieces = {{ab, b, bc}};
      if (squaredLength(a, bc) < squaredLength(ab, c))
        mPieces.insert(mPieces.end(), {{a, ab, bc}, {a, bc, c}});
      else
        mPieces.insert(mPieces.end(), {{a, ab, c}, {ab, bc, c}});
    }
    if (divided == 3) mPieces = {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}};
  }

  static constexpr std::uint32_t kNone = 0xffffffffu;

  double mLongest, mRadius;
  std::vector<Vec3d>& mPositions;
  std::vector<Vec3d> mCentres;
  std::unordered_map<std::uint64_t, std::uint32_t> mMiddle;
  std::vector<TriangleCorners> mPieces;
};

} // namespace

RefinedTriangles refinedNear(const WeldedSurface& surface, const std::vector<std::uint32_t>& faces,
                             const BlockGrid& grid, const std::vector<float>& level, double near, double longest,
                             std::vector<Vec3d>& positions) {
  RefinedTriangles r;
  for (const std::uint32_t f : faces) r.triangles.push_back(surface.triangles[f]);
  r.source = faces;
  r.whole.assign(faces.size(), true);
  Refiner(grid, level, near, longest, positions).refine(r);
  return r;
}

} // namespace volcaustic
