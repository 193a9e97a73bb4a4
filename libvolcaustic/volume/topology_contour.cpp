#include "volume/topology_contour.h"

#include "core/parallel.h"
#include "mesh/vector.h"

#include <map>
#include <numeric>

namespace volcaustic {

namespace {

constexpr int kEdges = 12;

/// Edge e of a cell goes from corner `low[e]` along axis e / 4.
constexpr std::array<int, kEdges> kLow{0, 2, 4, 6, 0, 1, 4, 5, 0, 1, 2, 3};

int edgeBetween(int a, int b) {
  const int low = std::min(a, b), axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
  for (int e = 4 * axis; e < 4 * axis + 4; ++e)
    if (kLow[e] == low) return e;
  return 0;
}

/// For each choice of corners that are inside: the sheet that each edge belongs to.
struct Sheets {
  std::array<std::int8_t, kEdges> ofEdge;
  int count = 0;
};

/// The corners of the face across `axis` at `side`, around it.
std::array<int, 4> faceCorners(int axis, int side) {
  const int u = 1 << ((axis + 1) % 3), v = 1 << ((axis + 2) % 3), base = side << axis;
  return {base, base | u, base | u | v, base | v};
}

Sheets sheetsOf(int inside) {
  std::array<int, kEdges> parent;
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int e) {
    while (parent[e] != e) e = parent[e];
    return e;
  };
  const auto isInside = [&](int corner) { return (inside >> corner & 1) != 0; };
  for (int face = 0; face < 6; ++face) {
    const std::array<int, 4> c = faceCorners(face / 2, face % 2);
    std::array<int, 4> crossed{};
    int crossings = 0;
    for (int k = 0; k < 4; ++k)
      if (isInside(c[k]) != isInside(c[(k + 1) % 4])) crossed[crossings++] = edgeBetween(c[k], c[(k + 1) % 4]);
    if (crossings == 2) parent[root(crossed[0])] = root(crossed[1]);
    if (crossings == 4) // corners inside are cut off each by itself, which both cells at the face agree on
      for (int k = 0; k < 4; ++k)
        if (isInside(c[k])) parent[root(edgeBetween(c[(k + 3) % 4], c[k]))] = root(edgeBetween(c[k], c[(k + 1) % 4]));
  }
  Sheets sheets;
  sheets.ofEdge.fill(-1);
  for (int e = 0; e < kEdges; ++e) {
    if (isInside(kLow[e]) == isInside(kLow[e] | 1 << e / 4)) continue;
    int other = 0;
    while (other < e && (sheets.ofEdge[other] < 0 || root(other) != root(e))) ++other;
    sheets.ofEdge[e] = static_cast<std::int8_t>(other < e ? sheets.ofEdge[other] : sheets.count++);
  }
  return sheets;
}

const std::array<Sheets, 256>& sheetTable() {
  static const std::array<Sheets, 256> table = [] {
    std::array<Sheets, 256> t;
    for (int inside = 0; inside < 256; ++inside) t[static_cast<std::size_t>(inside)] = sheetsOf(inside);
    return t;
  }();
  return table;
}

class Contourer {
public:
  Contourer(const BlockGrid& grid, const std::vector<float>& values, const RunContext& ctx)
      : mGrid(grid), mValues(values), mCtx(ctx), mFirst(grid.nodeCount(), kUnused), mInside(grid.nodeCount(), 0) {}

  Contour run(const std::function<bool(const std::array<std::int64_t, 8>&)>& wanted) {
    placeVertices(wanted);
    for (std::size_t node = 0; node < mFirst.size(); ++node)
      for (int axis = 0; axis < 3; ++axis) addQuad(node, axis);
    return std::move(mContour);
  }

private:
  static constexpr std::uint32_t kUnused = 0xffffffffu;

  [[nodiscard]] bool isInside(std::int64_t node) const { return mValues[static_cast<std::size_t>(node)] < 0; }

  /// Where the surface passes the edge from node n along `axis`.
  [[nodiscard]] Vec3d crossing(const Vec3i& n, int axis) const {
    Vec3i next = n;
    ++next[axis];
    const double a = mValues[static_cast<std::size_t>(mGrid.node(n[0], n[1], n[2]))],
                 b = mValues[static_cast<std::size_t>(mGrid.node(next[0], next[1], next[2]))];
    Vec3d p = mGrid.position(n);
    p[axis] += mGrid.voxelSize() * std::clamp(a / (a - b), 1 / 64.0, 63 / 64.0);
    return p;
  }

  void placeVertices(const std::function<bool(const std::array<std::int64_t, 8>&)>& wanted) {
    parallelFor(static_cast<std::int64_t>(mFirst.size()), BlockGrid::kNodes, mCtx,
                [&](std::int64_t begin, std::int64_t end, int) {
                  for (std::int64_t node = begin; node < end; ++node) classify(static_cast<std::size_t>(node), wanted);
                });
    for (std::size_t node = 0; node < mFirst.size(); ++node) {
      if (mFirst[node] == kUnused) continue;
      mFirst[node] = static_cast<std::uint32_t>(mContour.positions.size());
      const Vec3i n = mGrid.coordinates(node);
      const Sheets& sheets = sheetTable()[mInside[node]];
      for (int sheet = 0; sheet < sheets.count; ++sheet) {
        Vec3d sum{0, 0, 0};
        int count = 0;
        for (int e = 0; e < kEdges; ++e) {
          if (sheets.ofEdge[e] != sheet) continue;
          const Vec3d p = crossing({n[0] + (kLow[e] & 1), n[1] + (kLow[e] >> 1 & 1), n[2] + (kLow[e] >> 2)}, e / 4);
          for (int k = 0; k < 3; ++k) sum[k] += p[k];
          ++count;
        }
        mContour.positions.push_back({sum[0] / count, sum[1] / count, sum[2] / count});
        mContour.cells.push_back(n);
      }
    }
    mCellVertices = static_cast<std::uint32_t>(mContour.positions.size());
  }

  void classify(std::size_t node, const std::function<bool(const std::array<std::int64_t, 8>&)>& wanted) {
    const Vec3i n = mGrid.coordinates(node);
    std::array<std::int64_t, 8> corners;
    if (!mGrid.cell(n[0], n[1], n[2], corners)) return;
    int inside = 0;
    for (int c = 0; c < 8; ++c) inside |= isInside(corners[c]) << c;
    if (inside == 0 || inside == 255 || !wanted(corners)) return;
    mInside[node] = static_cast<std::uint8_t>(inside);
    mFirst[node] = 0;
  }

  /// The faces around the edge from a node along `axis`, if the surface passes it and all four cells are wanted.
  void addQuad(std::size_t node, int axis) {
    const Vec3i n = mGrid.coordinates(node);
    Vec3i next = n;
    ++next[axis];
    const std::int64_t other = mGrid.node(next[0], next[1], next[2]);
    if (other == BlockGrid::kNone) return;
    const bool outwards = isInside(static_cast<std::int64_t>(node));
    if (outwards == isInside(other)) return;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    constexpr std::array<std::array<int, 2>, 4> kAround{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}}; // back along u and v
    mPolygon.clear();
    for (int k = 0; k < 4; ++k) {
      const int from = outwards ? k : 3 - k, to = outwards ? (k + 1) % 4 : (6 - k) % 4;
      Vec3i cell = n;
      cell[u] -= kAround[from][0];
      cell[v] -= kAround[from][1];
      const std::int64_t at = mGrid.node(cell[0], cell[1], cell[2]);
      if (at == BlockGrid::kNone || mFirst[static_cast<std::size_t>(at)] == kUnused) return;
      const int corner = (kAround[from][0] << u) | (kAround[from][1] << v);
      const Sheets& sheets = sheetTable()[mInside[static_cast<std::size_t>(at)]];
      mPolygon.push_back(mFirst[static_cast<std::size_t>(at)] +
                         static_cast<std::uint32_t>(sheets.ofEdge[edgeBetween(corner, corner | 1 << axis)]));
      // The face between this cell and the next one holds the edge, and goes along the axis that both share.
      const int shared = kAround[from][0] == kAround[to][0] ? u : v;
      addFaceVertex(n, axis, shared, kAround[from][shared == u ? 0 : 1] == 1, cell);
    }
    addPolygon();
  }

  /// A face that the surface passes twice would join the same two vertices twice where both sheets are one in either
  /// cell, so each pass has a vertex of its own.
  void addFaceVertex(const Vec3i& n, int axis, int shared, bool back, const Vec3i& cell) {
    const auto at = [&](int alongAxis, int alongShared) {
      Vec3i m = n;
      m[axis] += alongAxis;
      m[shared] += back ? -alongShared : alongShared;
      return m;
    };
    const auto inside = [&](const Vec3i& m) { return isInside(mGrid.node(m[0], m[1], m[2])); };
    const bool first = inside(at(0, 0));
    if (inside(at(1, 0)) == first || inside(at(0, 1)) == first || inside(at(1, 1)) != first) return;
    // The corner inside is one end of this edge; the pass cuts it off from its other neighbour on the face, too.
    const int end = first ? 0 : 1;
    const Vec3i corner = at(end, 0);
    const bool upAxis = end == 0, upShared = !back;
    const int low = std::min(axis, shared), high = std::max(axis, shared);
    const std::array<std::int64_t, 5> pass{mGrid.node(corner[0], corner[1], corner[2]), low, high,
                                           low == axis ? upAxis : upShared, low == axis ? upShared : upAxis};
    const auto [entry, isNew] = mFaceVertices.try_emplace(pass, static_cast<std::uint32_t>(mContour.positions.size()));
    if (isNew) {
      Vec3i across = corner;
      if (!upShared) --across[shared];
      const Vec3d p = crossing(at(0, 0), axis), q = crossing(across, shared);
      mContour.positions.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2});
      mContour.cells.push_back(cell);
    }
    mPolygon.push_back(entry->second);
  }

  void addPolygon() {
    const auto squaredLength = [&](std::size_t i, std::size_t j) {
      const Vec3d d = difference(mContour.positions[mPolygon[i]], mContour.positions[mPolygon[j]]);
      return dot(d, d);
    };
    const std::size_t n = mPolygon.size();
    std::size_t apex = 0;
    if (n == 4)
      apex = squaredLength(0, 2) <= squaredLength(1, 3) ? 0 : 1;
    else // from a vertex on a face, which no other quadrangle has a diagonal to
      while (mPolygon[apex] < mCellVertices) ++apex;
    for (std::size_t k = 1; k + 1 < n; ++k)
      mContour.triangles.push_back({mPolygon[apex], mPolygon[(apex + k) % n], mPolygon[(apex + k + 1) % n]});
  }

  const BlockGrid& mGrid;
  const std::vector<float>& mValues;
  const RunContext& mCtx;
  std::vector<std::uint32_t> mFirst; ///< vertex of each cell's first sheet
  std::vector<std::uint8_t> mInside; ///< corners of each cell
  std::uint32_t mCellVertices = 0;
  std::map<std::array<std::int64_t, 5>, std::uint32_t> mFaceVertices;
  std::vector<std::uint32_t> mPolygon;
  Contour mContour;
};

} // namespace

Contour contourOf(const BlockGrid& grid, const std::vector<float>& values,
                  const std::function<bool(const std::array<std::int64_t, 8>&)>& wanted, const RunContext& ctx) {
  return Contourer(grid, values, ctx).run(wanted);
}

} // namespace volcaustic
