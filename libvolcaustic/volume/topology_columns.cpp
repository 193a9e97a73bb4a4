#include "volume/topology_columns.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace volcaustic {

namespace {

using Point = std::array<double, 2>;

/// On which side of the edge from a to b the column lies, twice the area of their triangle: the same number with the
/// other sign for the edge from b to a, so that exactly one of two neighbours counts a column on their edge.
struct Side {
  double area;
  int sign; ///< never 0 but for an edge along z: a column on the edge stands a hair to the right of and above it
};

Side sideOf(std::uint32_t ia, const Point& a, std::uint32_t ib, const Point& b, double x, double y) {
  if (ib < ia) {
    const Side other = sideOf(ib, b, ia, a, x, y);
    return {-other.area, -other.sign};
  }
  const double dx = b[0] - a[0], dy = b[1] - a[1];
  const double area = dx * (y - a[1]) - dy * (x - a[0]);
  const double decides = area != 0 ? area : dy != 0 ? -dy : dx;
  return {area, decides > 0 ? 1 : decides < 0 ? -1 : 0};
}

} // namespace

template <class Visit>
void WindingColumns::forCrossings(std::span<const Vec3d> positions, std::span<const TriangleCorners> triangles,
                                  double voxelSize, Visit visit) const {
  for (const TriangleCorners& t : triangles) {
    std::array<Point, 3> p;
    std::array<double, 3> z;
    for (int k = 0; k < 3; ++k) {
      p[k] = {positions[t[k]][0] / voxelSize, positions[t[k]][1] / voxelSize};
      z[k] = positions[t[k]][2] / voxelSize;
    }
    const auto lowest = [&](int axis) {
      return static_cast<int>(std::floor(std::min({p[0][axis], p[1][axis], p[2][axis]})));
    };
    const auto highest = [&](int axis) {
      return static_cast<int>(std::ceil(std::max({p[0][axis], p[1][axis], p[2][axis]})));
    };
    for (int j = lowest(1); j <= highest(1); ++j)
      for (int i = lowest(0); i <= highest(0); ++i) {
        const Side s0 = sideOf(t[1], p[1], t[2], p[2], i, j), s1 = sideOf(t[2], p[2], t[0], p[0], i, j),
                   s2 = sideOf(t[0], p[0], t[1], p[1], i, j);
        if (s0.sign == 0 || s0.sign != s1.sign || s0.sign != s2.sign) continue;
        const double area = s0.area + s1.area + s2.area;
        const double height = area != 0 ? (s0.area * z[0] + s1.area * z[1] + s2.area * z[2]) / area : z[0];
        visit(i, j, Crossing{static_cast<float>(height), -s0.sign});
      }
  }
}

WindingColumns::WindingColumns(std::span<const Vec3d> positions, std::span<const TriangleCorners> triangles,
                               double voxelSize, const RunContext& ctx) {
  std::array<double, 2> low, high;
  low.fill(std::numeric_limits<double>::max());
  high.fill(std::numeric_limits<double>::lowest());
  for (const TriangleCorners& t : triangles)
    for (const std::uint32_t v : t)
      for (int axis = 0; axis < 2; ++axis) {
        low[axis] = std::min(low[axis], positions[v][axis] / voxelSize);
        high[axis] = std::max(high[axis], positions[v][axis] / voxelSize);
      }
  for (int axis = 0; axis < 2; ++axis) {
    mFirst[axis] = static_cast<int>(std::floor(low[axis]));
    mSize[axis] = static_cast<int>(std::ceil(high[axis])) - mFirst[axis] + 1;
  }
  const std::size_t columns = static_cast<std::size_t>(mSize[0]) * mSize[1];
  ctx.requireMemory(columns * (sizeof(std::uint32_t) + 2 * sizeof(Crossing)), "the columns of the level set");
  const auto slot = [&](int i, int j) {
    return static_cast<std::size_t>(j - mFirst[1]) * mSize[0] + static_cast<std::size_t>(i - mFirst[0]);
  };
  mBegin.assign(columns + 1, 0);
  forCrossings(positions, triangles, voxelSize, [&](int i, int j, const Crossing&) { ++mBegin[slot(i, j) + 1]; });
  std::partial_sum(mBegin.begin(), mBegin.end(), mBegin.begin());
  mCrossings.resize(mBegin.back());
  std::vector<std::uint32_t> end(mBegin.begin(), mBegin.end() - 1);
  forCrossings(positions, triangles, voxelSize,
               [&](int i, int j, const Crossing& c) { mCrossings[end[slot(i, j)]++] = c; });
  for (std::size_t c = 0; c < columns; ++c)
    std::sort(mCrossings.begin() + mBegin[c], mCrossings.begin() + mBegin[c + 1],
              [](const Crossing& a, const Crossing& b) { return a.z != b.z ? a.z < b.z : a.turn > b.turn; });
}

std::span<const WindingColumns::Crossing> WindingColumns::column(int i, int j) const {
  if (i < mFirst[0] || j < mFirst[1] || i >= mFirst[0] + mSize[0] || j >= mFirst[1] + mSize[1]) return {};
  const std::size_t slot = static_cast<std::size_t>(j - mFirst[1]) * mSize[0] + static_cast<std::size_t>(i - mFirst[0]);
  return std::span(mCrossings).subspan(mBegin[slot], mBegin[slot + 1] - mBegin[slot]);
}

int WindingColumns::at(int i, int j, int k) const {
  int winding = 0;
  for (const Crossing& c : column(i, j)) {
    if (c.z >= static_cast<float>(k)) break;
    winding += c.turn;
  }
  return winding;
}

} // namespace volcaustic
