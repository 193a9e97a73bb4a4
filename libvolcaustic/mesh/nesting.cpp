#include "mesh/nesting.h"

#include "mesh/vector.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace volcaustic {

namespace {

bool contains(const Box& box, const Vec3d& p) {
  for (int a = 0; a < 3; ++a)
    if (p[a] < box.min[a] || p[a] > box.max[a]) return false;
  return true;
}

/// The probes' points, binned by x and y.
class PointGrid {
public:
  explicit PointGrid(std::span<const NestingProbe> probes) {
    for (const NestingProbe& probe : probes)
      for (const Vec3d& p : probe.points) mPoints.push_back({p, probe.shell});
    mLow = mHigh = {mPoints.front().p[0], mPoints.front().p[1]};
    for (const Point& point : mPoints)
      for (int a = 0; a < 2; ++a) {
        mLow[a] = std::min(mLow[a], point.p[a]);
        mHigh[a] = std::max(mHigh[a], point.p[a]);
      }
    mSide = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(mPoints.size()))), 1, 4096);
    mBegin.assign(static_cast<std::size_t>(mSide) * mSide + 1, 0);
    for (const Point& point : mPoints) ++mBegin[cell(point.p) + 1];
    for (std::size_t i = 1; i < mBegin.size(); ++i) mBegin[i] += mBegin[i - 1];
    mOrder.resize(mPoints.size());
    std::vector<std::uint32_t> next(mBegin.begin(), mBegin.end() - 1);
    for (std::uint32_t i = 0; i < mPoints.size(); ++i) mOrder[next[cell(mPoints[i].p)]++] = i;
  }

  struct Point {
    Vec3d p;
    std::uint32_t shell;
  };
  [[nodiscard]] const Point& operator[](std::uint32_t i) const { return mPoints[i]; }

  /// Calls visit(point number) for the points in the cells that a box meets. Returns what that cost: columns of cells,
  /// and points.
  template <class Visit>
  std::uint64_t forEachNear(const Box& box, Visit visit) const {
    for (int a = 0; a < 2; ++a)
      if (box.max[a] < mLow[a] || box.min[a] > mHigh[a]) return 0;
    const int x0 = along(0, box.min[0]), x1 = along(0, box.max[0]), y0 = along(1, box.min[1]),
              y1 = along(1, box.max[1]);
    std::uint64_t cost = 0;
    for (int x = x0; x <= x1; ++x) { // cells of one column follow each other
      const std::size_t column = static_cast<std::size_t>(x) * mSide;
      const std::uint32_t begin = mBegin[column + y0], end = mBegin[column + y1 + 1];
      for (std::uint32_t i = begin; i < end; ++i) visit(mOrder[i]);
      cost += 1 + end - begin;
    }
    return cost;
  }

private:
  [[nodiscard]] int along(int axis, double x) const {
    const double width = mHigh[axis] - mLow[axis];
    return width > 0 ? static_cast<int>(std::clamp((x - mLow[axis]) / width, 0.0, 1.0) * (mSide - 1)) : 0;
  }
  [[nodiscard]] std::size_t cell(const Vec3d& p) const {
    return static_cast<std::size_t>(along(0, p[0])) * mSide + along(1, p[1]);
  }

  std::vector<Point> mPoints;
  std::array<double, 2> mLow{}, mHigh{};
  int mSide = 1;
  std::vector<std::uint32_t> mBegin, mOrder;
};

/// How often the edge from u to v, seen along z, passes p on the side of larger x: +1 upwards in y, -1 downwards. Both
/// faces of an edge get the same number from the same arithmetic, so a closed surface neither leaks nor counts twice.
int passes(const Vec3d& u, const Vec3d& v, const Vec3d& p) {
  if ((u[1] <= p[1]) == (v[1] <= p[1])) return 0;
  const bool upwards = u[1] <= p[1];
  const Vec3d &low = upwards ? u : v, &high = upwards ? v : u;
  const double side = (high[0] - low[0]) * (p[1] - low[1]) - (high[1] - low[1]) * (p[0] - low[0]);
  return side > 0 ? (upwards ? 1 : -1) : 0;
}

/// What a triangle adds to the winding number of p by crossing the ray from p along z: +1 where the ray leaves.
int crossing(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& p) {
  const int turn = passes(a, b, p) + passes(b, c, p) + passes(c, a, p);
  if (turn == 0) return 0;
  const Vec3d normal = cross(difference(b, a), difference(c, a));
  return dot(normal, difference(p, a)) * turn < 0 ? turn : 0;
}

Box boundsOf(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.min[k] = std::min({a[k], b[k], c[k]});
    box.max[k] = std::max({a[k], b[k], c[k]});
  }
  return box;
}

struct Crossing {
  std::uint32_t point, shell;
  int sign;
};

/// From crossings to enclosures: per point and shell the winding number; a shell encloses where none is zero at the
/// points of a probe.
std::vector<Enclosure> enclosuresOf(std::vector<Crossing>& crossings, std::span<const NestingProbe> probes) {
  const auto probeOf = [](const Crossing& c) { return c.point / NestingProbe::kPoints; };
  std::sort(crossings.begin(), crossings.end(), [&](const Crossing& a, const Crossing& b) {
    return std::tuple(probeOf(a), a.shell, a.point) < std::tuple(probeOf(b), b.shell, b.point);
  });
  std::vector<Enclosure> enclosures;
  for (std::size_t i = 0; i < crossings.size();) {
    const std::size_t probe = probeOf(crossings[i]);
    const std::uint32_t outer = crossings[i].shell;
    std::array<int, NestingProbe::kPoints> winding{};
    for (; i < crossings.size() && probeOf(crossings[i]) == probe && crossings[i].shell == outer; ++i)
      winding[crossings[i].point % NestingProbe::kPoints] += crossings[i].sign;
    if (std::find(winding.begin(), winding.end(), 0) == winding.end())
      enclosures.push_back({probes[probe].shell, outer, winding[0]});
  }
  return enclosures;
}

} // namespace

bool findEnclosures(const Mesh& mesh, const FaceShells& faces, std::span<const MeshShell> shells,
                    std::span<const std::uint8_t> isClosed, std::span<const NestingProbe> probes,
                    const NestingLimits& limits, std::vector<Enclosure>& enclosures, const RunContext& ctx) {
  const PointGrid grid(probes);
  std::vector<Crossing> crossings;
  std::uint64_t tests = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (i % 65536 == 0) ctx.throwIfCancelled();
    const std::uint32_t shell = faces.shellOf[i];
    if (shell == FaceShells::kNone || !isClosed[shell]) continue;
    const auto& [ia, ib, ic] = mesh.triangles[i];
    const Vec3d &a = mesh.positions[ia], &b = mesh.positions[ib], &c = mesh.positions[ic];
    tests += grid.forEachNear(boundsOf(a, b, c), [&](std::uint32_t point) {
      const auto& [p, own] = grid[point];
      if (own == shell || !contains(shells[shell].bounds, p)) return;
      if (const int sign = crossing(a, b, c, p)) crossings.push_back({point, shell, sign});
    });
    if (tests > limits.pointTests || crossings.size() > limits.crossings) return false;
  }
  enclosures = enclosuresOf(crossings, probes);
  return true;
}

} // namespace volcaustic
