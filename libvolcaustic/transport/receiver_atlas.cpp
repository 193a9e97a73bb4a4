#include "transport/receiver_atlas.h"

#include "volcaustic/error.h"
#include "volcaustic/receivers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

namespace volcaustic {

namespace {

using kernels::cross;
using kernels::dot;
using kernels::Double3;
using kernels::length;

constexpr std::int32_t kBorder = 1; // texels around a chart
constexpr double kSteepest = 0.6;   // cosine between the normals of a triangle and of its chart
constexpr std::int32_t kNone = -1;

Double3 toDouble3(const Vec3d& v) { return {v[0], v[1], v[2]}; }

/// A number for each vertex; the same for those at the same place.
std::vector<std::uint32_t> weld(const Mesh& mesh) {
  std::vector<std::uint32_t> order(mesh.positions.size()), welded(order.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return mesh.positions[a] != mesh.positions[b] ? mesh.positions[a] < mesh.positions[b] : a < b;
  });
  for (std::size_t i = 0; i < order.size(); ++i)
    welded[order[i]] =
        i > 0 && mesh.positions[order[i]] == mesh.positions[order[i - 1]] ? welded[order[i - 1]] : order[i];
  return welded;
}

/// Of each triangle the first one that is the same, itself for most; one that faces the other way is another.
std::vector<std::int32_t> firstOfSame(const Mesh& mesh, const std::vector<std::uint32_t>& welded) {
  struct Corners {
    std::array<std::uint32_t, 3> of;
    std::int32_t triangle;
  };
  std::vector<Corners> all;
  all.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    std::array<std::uint32_t, 3> of{welded[a], welded[b], welded[c]};
    std::rotate(of.begin(), std::min_element(of.begin(), of.end()), of.end());
    all.push_back({of, static_cast<std::int32_t>(all.size())});
  }
  std::sort(all.begin(), all.end(),
            [](const Corners& a, const Corners& b) { return a.of != b.of ? a.of < b.of : a.triangle < b.triangle; });
  std::vector<std::int32_t> first(all.size());
  for (std::size_t i = 0; i < all.size(); ++i)
    first[all[i].triangle] = i > 0 && all[i].of == all[i - 1].of ? first[all[i - 1].triangle] : all[i].triangle;
  return first;
}

/// Neighbours over edges; an edge of many triangles links each to the one before.
class Neighbours {
public:
  Neighbours(const Mesh& mesh, const std::vector<std::uint32_t>& welded)
      : mOf(mesh.triangles.size(), {kNone, kNone, kNone, kNone, kNone, kNone}) {
    struct Edge {
      std::uint64_t corners;
      std::int32_t triangle, side;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int side = 0; side < 3; ++side) {
        const auto [a, b] = std::minmax({welded[mesh.triangles[t][side]], welded[mesh.triangles[t][(side + 1) % 3]]});
        edges.push_back({std::uint64_t{a} << 32 | b, static_cast<std::int32_t>(t), side});
      }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
      return a.corners != b.corners ? a.corners < b.corners : a.triangle < b.triangle;
    });
    for (std::size_t i = 1; i < edges.size(); ++i) {
      if (edges[i].corners != edges[i - 1].corners) continue;
      mOf[edges[i].triangle][2 * edges[i].side] = edges[i - 1].triangle;
      mOf[edges[i - 1].triangle][2 * edges[i - 1].side + 1] = edges[i].triangle;
    }
  }
  [[nodiscard]] const std::array<std::int32_t, 6>& of(std::int32_t triangle) const { return mOf[triangle]; }

private:
  std::vector<std::array<std::int32_t, 6>> mOf;
};

/// The plane that a chart is projected onto: u to the right, v upwards, seen from the front.
struct ChartPlane {
  Double3 u, v, normal;

  explicit ChartPlane(const Double3& n) : normal(n) {
    const Double3 size{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
    const Double3 up = size.y <= size.z && size.y <= size.x ? Double3(0, 1, 0)
                       : size.z <= size.x                   ? Double3(0, 0, 1)
                                                            : Double3(1, 0, 0);
    u = kernels::normalize(cross(up, n));
    v = cross(n, u);
  }
  [[nodiscard]] Double3 project(const Vec3d& p) const {
    const Double3 q = toDouble3(p);
    return {dot(q, u), dot(q, v), dot(q, normal)};
  }
};

struct Chart {
  ChartPlane plane;
  double u0 = std::numeric_limits<double>::max(), v0 = u0, u1 = -u0, v1 = -u0;
};

/// A surface in charts.
struct ChartedSurface {
  std::vector<Chart> charts;
  std::vector<std::int32_t> chartOf; ///< of each triangle; kNone for one without area, or that was there before
};

/// Cuts a surface into charts, one after another, each grown from its first triangle.
class ChartGrower {
public:
  ChartGrower(const Mesh& mesh, const std::vector<std::uint32_t>& welded, const std::vector<std::int32_t>& first,
              int resolution)
      : mMesh(mesh), mNeighbours(mesh, welded), mChartOf(mesh.triangles.size(), kNone) {
    double area = 0;
    for (std::size_t t = 0; t < mChartOf.size(); ++t) {
      mPlanes.push_back(first[t] == static_cast<std::int32_t>(t) ? planeOf(mesh, t) : TrianglePlane{});
      area += mPlanes.back().area;
    }
    mCell = std::sqrt(area) / std::min(resolution, 512);
  }

  ChartedSurface run(const RunContext& ctx) {
    for (std::int32_t t = 0; t < static_cast<std::int32_t>(mPlanes.size()); ++t) {
      if (mChartOf[t] != kNone || !(mPlanes[t].area > 0)) continue;
      ctx.throwIfCancelled();
      grow(t);
    }
    return {std::move(mCharts), std::move(mChartOf)};
  }

private:
  void grow(std::int32_t seed) {
    mCharts.push_back({ChartPlane(mPlanes[seed].normal)});
    std::vector<std::int32_t> front{seed};
    take(seed);
    for (std::size_t i = 0; i < front.size(); ++i)
      for (const std::int32_t t : mNeighbours.of(front[i])) {
        if (t == kNone || mChartOf[t] != kNone || !(mPlanes[t].area > 0)) continue;
        if (dot(mPlanes[t].normal, mCharts.back().plane.normal) < kSteepest || !take(t)) continue;
        front.push_back(t);
      }
  }

  /// Adds the triangle to the last chart, unless another of its layers is there already: a spiral ramp comes to lie
  /// over itself.
  bool take(std::int32_t triangle) {
    Chart& chart = mCharts.back();
    std::array<Double3, 3> p;
    for (int i = 0; i < 3; ++i) p[i] = chart.plane.project(mMesh.positions[mMesh.triangles[triangle][i]]);
    if (!occupy(p)) return false;
    for (const Double3& q : p) {
      chart.u0 = std::min(chart.u0, q.x);
      chart.v0 = std::min(chart.v0, q.y);
      chart.u1 = std::max(chart.u1, q.x);
      chart.v1 = std::max(chart.v1, q.y);
    }
    mChartOf[triangle] = static_cast<std::int32_t>(mCharts.size() - 1);
    return true;
  }

  /// Notes how high the surface is over the cells whose middles the triangle covers (its own middle's, where there are
  /// none); false where it has been somewhere else.
  bool occupy(const std::array<Double3, 3>& p) {
    const double most = 4 * mCell; // what the steepest surface changes over a cell and its corners
    struct Cell {
      std::uint64_t key;
      double height;
    };
    std::vector<Cell> cells;
    const auto note = [&](double u, double v, double height) {
      const auto column = static_cast<std::int64_t>(std::floor(u / mCell)),
                 row = static_cast<std::int64_t>(std::floor(v / mCell));
      const std::uint64_t key =
          static_cast<std::uint64_t>(column) * 0x9e3779b97f4a7c15ull + static_cast<std::uint64_t>(row);
      const auto known = mOccupied.find(key);
      if (known != mOccupied.end() && known->second.chart == mCharts.size() &&
          std::abs(known->second.height - height) > most)
        return false;
      cells.push_back({key, height});
      return true;
    };
    const Double3 a = p[1] - p[0], b = p[2] - p[0];
    const double det = a.x * b.y - a.y * b.x;
    const auto [u0, u1] = std::minmax({p[0].x, p[1].x, p[2].x});
    const auto [v0, v1] = std::minmax({p[0].y, p[1].y, p[2].y});
    // Of a needle, whose box has far more cells than itself, the middle has to do.
    const double boxCells = ((u1 - u0) / mCell + 1) * ((v1 - v0) / mCell + 1);
    const double last = boxCells < 64 + 16 * std::abs(det) / (mCell * mCell) ? v1 : v0;
    for (double v = (std::floor(v0 / mCell) + 0.5) * mCell; v < last; v += mCell)
      for (double u = (std::floor(u0 / mCell) + 0.5) * mCell; u < u1; u += mCell) {
        const double s = ((u - p[0].x) * b.y - (v - p[0].y) * b.x) / det,
                     t = (a.x * (v - p[0].y) - a.y * (u - p[0].x)) / det;
        if (s < 0 || t < 0 || s + t > 1) continue;
        if (!note(u, v, p[0].z + s * a.z + t * b.z)) return false;
      }
    const Double3 middle = (p[0] + p[1] + p[2]) * (1 / 3.0);
    if (cells.empty() && !note(middle.x, middle.y, middle.z)) return false;
    for (const Cell& c : cells) mOccupied[c.key] = {mCharts.size(), c.height};
    return true;
  }

  struct Height {
    std::size_t chart; ///< number of charts when it was noted
    double height;
  };
  const Mesh& mMesh;
  std::vector<TrianglePlane> mPlanes;
  Neighbours mNeighbours;
  std::vector<Chart> mCharts;
  std::vector<std::int32_t> mChartOf;
  double mCell; ///< world
  std::unordered_map<std::uint64_t, Height> mOccupied;
};

/// Packs rectangles on shelves, the highest first.
class Shelves {
public:
  explicit Shelves(const std::vector<Chart>& charts) : mCharts(charts), mOrder(charts.size()) {
    std::iota(mOrder.begin(), mOrder.end(), 0u);
    std::stable_sort(mOrder.begin(), mOrder.end(), [&](std::size_t a, std::size_t b) {
      return charts[a].v1 - charts[a].v0 > charts[b].v1 - charts[b].v0;
    });
  }

  /// With `scale` texels to a unit of length: whether there is room. `places` receives the rectangles, borders
  /// included.
  bool pack(double scale, std::int32_t edge, std::vector<TexelRange>* places) const {
    std::int32_t column = 0, row = 0, height = 0;
    for (const std::size_t i : mOrder) {
      const Chart& c = mCharts[i];
      const double width = (c.u1 - c.u0) * scale, tall = (c.v1 - c.v0) * scale;
      if (width > edge || tall > edge) return false;
      const auto texels = [](double size) {
        return std::max(1, static_cast<std::int32_t>(std::ceil(size))) + 2 * kBorder;
      };
      const TexelRange r{column + texels(width) > edge ? 0 : column, row, texels(width), texels(tall)};
      if (r.columns > edge) return false;
      if (r.column == 0) { // a new shelf
        row += height;
        height = r.rows;
      }
      if (row + r.rows > edge) return false;
      if (places) (*places)[i] = {r.column, row, r.columns, r.rows};
      column = r.column + r.columns;
    }
    return true;
  }

  /// The largest scale that there is room for, to a thousandth; there is room for 0.
  [[nodiscard]] double largestScale(std::int32_t edge) const {
    double high = std::numeric_limits<double>::max();
    for (const Chart& c : mCharts) high = std::min(high, edge / std::max(c.u1 - c.u0, c.v1 - c.v0));
    double low = high;
    while (low > high * 1e-9 && !pack(low, edge, nullptr)) low /= 2;
    if (!(low > high * 1e-9)) return 0;
    for (high = std::min(high, 2 * low); high - low > 1e-3 * high;) {
      const double middle = 0.5 * (low + high);
      (pack(middle, edge, nullptr) ? low : high) = middle;
    }
    return low;
  }

private:
  const std::vector<Chart>& mCharts;
  std::vector<std::size_t> mOrder;
};

} // namespace

TrianglePlane planeOf(const Mesh& mesh, std::size_t triangle) {
  const auto& [i, j, k] = mesh.triangles[triangle];
  const Double3 a = toDouble3(mesh.positions[i]), b = toDouble3(mesh.positions[j]) - a,
                c = toDouble3(mesh.positions[k]) - a, d = c - b, n = cross(b, c);
  const double twice = length(n), longest = std::max({dot(b, b), dot(c, c), dot(d, d)});
  if (!(twice > 1e-9 * longest)) return {};
  return {n * (1 / twice), 0.5 * twice};
}

ReceiverAtlas rectangleAtlas(const Mesh& rectangle, int resolution) {
  const Double3 lowerLeft = toDouble3(rectangle.positions[0]);
  const double width = length(toDouble3(rectangle.positions[1]) - lowerLeft),
               height = length(toDouble3(rectangle.positions[3]) - lowerLeft), longer = std::max(width, height);
  const auto texels = [&](double side) {
    return std::clamp(static_cast<std::int32_t>(std::lround(resolution * side / longer)), 1, resolution);
  };
  ReceiverAtlas atlas;
  atlas.columns = texels(width);
  atlas.rows = texels(height);
  const double c = atlas.columns, r = atlas.rows;
  atlas.charts = {{0, 0, atlas.columns, atlas.rows}};
  atlas.chartOf = {0, 0};
  atlas.texels = {MapTriangle{{{0, r}, {c, r}, {c, 0}}}, MapTriangle{{{0, r}, {c, 0}, {0, 0}}}};
  return atlas;
}

namespace {

/// The smallest edge of an atlas, from `resolution` on, that has room for all charts.
std::int32_t atlasEdge(const Shelves& shelves, std::size_t charts, int resolution, const std::string& place,
                       const RunContext& ctx) {
  const std::string pieces = place + ": its " + std::to_string(charts) + " separate pieces of surface ";
  std::int32_t edge = resolution;
  while (!shelves.pack(0, edge, nullptr)) {
    if (edge >= kMostReceiverTexels)
      throw Error(ErrorKind::Input, pieces + "do not fit a light map of " + std::to_string(edge) +
                                        " texels along a side; use a simpler mesh");
    edge = std::min(edge + edge / 4 + 1, kMostReceiverTexels);
  }
  if (edge > resolution)
    ctx.warn(pieces + "need a light map of " + std::to_string(edge) + " texels along a side instead of " +
             std::to_string(resolution));
  return edge;
}

} // namespace

ReceiverAtlas meshAtlas(const Mesh& mesh, int resolution, const std::string& place, const RunContext& ctx) {
  const std::vector<std::uint32_t> welded = weld(mesh);
  const std::vector<std::int32_t> first = firstOfSame(mesh, welded);
  ChartedSurface surface = ChartGrower(mesh, welded, first, resolution).run(ctx);
  const Shelves shelves(surface.charts);
  ReceiverAtlas atlas;
  atlas.columns = atlas.rows = atlasEdge(shelves, surface.charts.size(), resolution, place, ctx);
  atlas.charts.resize(surface.charts.size());
  const double scale = shelves.largestScale(atlas.columns);
  shelves.pack(scale, atlas.columns, &atlas.charts);
  atlas.chartOf = std::move(surface.chartOf);
  atlas.texels.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < atlas.texels.size(); ++t) {
    const std::int32_t number = atlas.chartOf[first[t]];
    if (number == kNone) continue;
    const Chart& chart = surface.charts[number];
    const TexelRange& at = atlas.charts[number];
    for (int i = 0; i < 3; ++i) {
      const Double3 p = chart.plane.project(mesh.positions[mesh.triangles[t][i]]);
      atlas.texels[t][i] = {at.column + kBorder + (p.x - chart.u0) * scale,
                            at.row + kBorder + (chart.v1 - p.y) * scale};
    }
  }
  return atlas;
}

} // namespace volcaustic
