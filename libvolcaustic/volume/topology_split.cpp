// Necks: where an opening of the solid (an erosion by half the neck's thickness, then as much growth) takes away what
// held two parts of it together.
#include "volume/topology_contour.h"
#include "volume/topology_rules.h"

#include "core/parallel.h"

#include <numeric>

namespace volcaustic {

namespace {

constexpr std::array<Vec3i, 6> kBeside{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
constexpr std::uint32_t kNone = 0xffffffffu;
/// Voxels between a body and where it would touch the next one.
constexpr double kApart = 1.5;

/// Pieces that the opening takes away, as numbers at the nodes of a level set.
struct Pieces {
  std::vector<std::uint32_t> of; ///< kNone where the node is in no piece
  std::uint32_t count = 0;
};

Pieces piecesOf(const BlockGrid& grid, const std::vector<std::uint8_t>& taken) {
  Pieces pieces{std::vector<std::uint32_t>(taken.size(), kNone), 0};
  std::vector<std::size_t> stack;
  for (std::size_t start = 0; start < taken.size(); ++start) {
    if (!taken[start] || pieces.of[start] != kNone) continue;
    pieces.of[start] = pieces.count;
    stack.push_back(start);
    while (!stack.empty()) {
      const Vec3i at = grid.coordinates(stack.back());
      stack.pop_back();
      for (const Vec3i& d : kBeside) {
        const std::int64_t beside = grid.node(at[0] + d[0], at[1] + d[1], at[2] + d[2]);
        if (beside == BlockGrid::kNone) continue;
        const auto n = static_cast<std::size_t>(beside);
        if (!taken[n] || pieces.of[n] != kNone) continue;
        pieces.of[n] = pieces.count;
        stack.push_back(n);
      }
    }
    ++pieces.count;
  }
  return pieces;
}

/// The nodes inside a part but in no piece, as runs of columns, and which of them hang together.
class Remainder {
public:
  /// `core` marks nodes too deep for crumbs, `columns` are those of the part.
  Remainder(const WindingColumns& columns, const BlockGrid& grid, const Pieces& pieces,
            const std::vector<std::uint8_t>& core)
      : mColumns(columns), mFirstRun{0} {
    for (int j = columns.first()[1]; j < columns.first()[1] + columns.size()[1]; ++j)
      for (int i = columns.first()[0]; i < columns.first()[0] + columns.size()[0]; ++i) {
        addColumn(i, j, grid, pieces, core);
        mFirstRun.push_back(static_cast<std::uint32_t>(mRuns.size()));
      }
    join();
  }

  /// The body that a node belongs to; kNone for crumbs and outside.
  std::uint32_t bodyAt(const Vec3i& n) {
    const auto& [first, size] = std::pair(mColumns.first(), mColumns.size());
    const int i = n[0] - first[0], j = n[1] - first[1];
    if (i < 0 || j < 0 || i >= size[0] || j >= size[1]) return kNone;
    const std::size_t column = static_cast<std::size_t>(j) * size[0] + i;
    for (std::uint32_t r = mFirstRun[column]; r < mFirstRun[column + 1]; ++r)
      if (mRuns[r].low <= n[2] && n[2] <= mRuns[r].high) {
        const std::uint32_t body = find(r);
        return mRuns[body].isBody ? body : kNone;
      }
    return kNone;
  }

private:
  struct Run {
    int low, high;
    std::uint32_t parent;
    bool isBody; ///< holds a deep node, or one far from anything thin
  };

  void addColumn(int i, int j, const BlockGrid& grid, const Pieces& pieces, const std::vector<std::uint8_t>& core) {
    int winding = 0;
    float from = 0;
    for (const WindingColumns::Crossing& c : mColumns.column(i, j)) {
      const bool wasInside = winding > 0;
      winding += c.turn;
      if (!wasInside && winding > 0) from = c.z;
      if (!wasInside || winding > 0) continue;
      bool open = false;
      for (int k = static_cast<int>(std::floor(from)) + 1; static_cast<float>(k) <= c.z; ++k) {
        const std::int64_t node = grid.node(i, j, k);
        const bool known = node != BlockGrid::kNone;
        if (known && pieces.of[static_cast<std::size_t>(node)] != kNone) {
          open = false;
          continue;
        }
        if (!open) mRuns.push_back({k, k, static_cast<std::uint32_t>(mRuns.size()), false});
        open = true;
        mRuns.back().high = k;
        mRuns.back().isBody |= !known || core[static_cast<std::size_t>(node)];
      }
    }
  }

  void join() {
    const std::array<int, 2> size = mColumns.size();
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        const std::size_t column = static_cast<std::size_t>(j) * size[0] + i;
        if (i + 1 < size[0]) joinColumns(column, column + 1);
        if (j + 1 < size[1]) joinColumns(column, column + static_cast<std::size_t>(size[0]));
      }
  }
  void joinColumns(std::size_t a, std::size_t b) {
    for (std::uint32_t p = mFirstRun[a], q = mFirstRun[b]; p < mFirstRun[a + 1] && q < mFirstRun[b + 1];) {
      if (mRuns[p].low <= mRuns[q].high && mRuns[q].low <= mRuns[p].high) {
        const std::uint32_t low = std::min(find(p), find(q)), high = std::max(find(p), find(q));
        mRuns[low].isBody |= mRuns[high].isBody;
        mRuns[high].parent = low;
      }
      mRuns[p].high < mRuns[q].high ? ++p : ++q;
    }
  }
  std::uint32_t find(std::uint32_t r) {
    for (; mRuns[r].parent != r; r = mRuns[r].parent) mRuns[r].parent = mRuns[mRuns[r].parent].parent;
    return r;
  }

  const WindingColumns& mColumns;
  std::vector<std::uint32_t> mFirstRun; ///< of each column
  std::vector<Run> mRuns;
};

/// Marks the nodes of the pieces that lie between two bodies.
std::vector<std::uint8_t> necksOf(const BlockGrid& grid, const Pieces& pieces, Remainder& remainder) {
  std::vector<std::uint32_t> body(pieces.count, kNone);
  std::vector<bool> isNeck(pieces.count, false);
  for (std::size_t n = 0; n < pieces.of.size(); ++n) {
    const std::uint32_t piece = pieces.of[n];
    if (piece == kNone || isNeck[piece]) continue;
    const Vec3i at = grid.coordinates(n);
    for (const Vec3i& d : kBeside) {
      const std::uint32_t beside = remainder.bodyAt({at[0] + d[0], at[1] + d[1], at[2] + d[2]});
      if (beside == kNone) continue;
      if (body[piece] == kNone) body[piece] = beside;
      isNeck[piece] = isNeck[piece] || body[piece] != beside;
    }
  }
  std::vector<std::uint8_t> marks(pieces.of.size(), 0);
  for (std::size_t n = 0; n < marks.size(); ++n) marks[n] = pieces.of[n] != kNone && isNeck[pieces.of[n]];
  return marks;
}

/// The contour of the eroded solid, and which core each of its triangles is of.
struct Cores {
  Contour contour;
  std::vector<std::uint32_t> coreOf;
};

/// Only what holds a deep node is a core; thin ends of the eroded solid fall into crumbs on a lattice.
Cores coresOf(const LevelSet& set, const std::vector<std::uint8_t>& deep, double radius, const RunContext& ctx) {
  std::vector<float> eroded = set.value;
  for (float& value : eroded) value += static_cast<float>(radius);
  Cores cores{contourOf(
                  set.grid, eroded, [](const std::array<std::int64_t, 8>&) { return true; }, ctx),
              {}};
  std::vector<std::uint8_t> inside(eroded.size());
  for (std::size_t n = 0; n < inside.size(); ++n) inside[n] = eroded[n] < 0;
  const Pieces pieces = piecesOf(set.grid, inside);
  std::vector<bool> isCore(pieces.count, false);
  for (std::size_t n = 0; n < deep.size(); ++n)
    if (deep[n]) isCore[pieces.of[n]] = true;
  for (const TriangleCorners& t : cores.contour.triangles) {
    const Vec3i& at = cores.contour.cells[t[0]];
    std::uint32_t core = kNone;
    for (int c = 0; c < 8 && core == kNone; ++c) {
      const std::int64_t node = set.grid.node(at[0] + (c & 1), at[1] + (c >> 1 & 1), at[2] + (c >> 2));
      if (node != BlockGrid::kNone) core = pieces.of[static_cast<std::size_t>(node)];
    }
    cores.coreOf.push_back(core != kNone && isCore[core] ? core : kNone);
  }
  return cores;
}

/// Distance from the opened solid near its surface; elsewhere from the solid. Where two cores have grown together again
/// each of them ends kApart from where both are equally near.
std::vector<float> openedDistance(const LevelSet& set, const Cores& cores, double radius, const RunContext& ctx) {
  const TriangleTree tree(cores.contour.positions, cores.contour.triangles);
  const double limit = 3 * radius, apart = kApart * set.grid.voxelSize(), outside = 2 * set.grid.voxelSize();
  std::vector<float> opened = set.value;
  parallelFor(
      static_cast<std::int64_t>(opened.size()), BlockGrid::kNodes, ctx, [&](std::int64_t begin, std::int64_t end, int) {
        std::uint32_t hint = ClosestPoint::kNone;
        for (std::int64_t i = begin; i < end; ++i) {
          float& value = opened[static_cast<std::size_t>(i)];
          if (value < -radius || value > outside) continue;
          const Vec3d p = set.grid.position(set.grid.coordinates(static_cast<std::size_t>(i)));
          const ClosestPoint c = tree.closest(p, limit, hint);
          value = static_cast<float>(std::min(c.distance, limit) - radius);
          if (!c.found()) continue;
          hint = c.triangle;
          const std::uint32_t core = cores.coreOf[c.triangle];
          if (core == kNone) continue;
          const ClosestPoint other =
              tree.closestIf(p, c.distance + 2 * apart, ClosestPoint::kNone, [&](std::uint32_t t, const Vec3d&) {
                return cores.coreOf[t] != kNone && cores.coreOf[t] != core;
              });
          if (!other.found()) continue;
          const double between = (c.distance - other.distance) / 2 + apart;
          value = std::max(value, static_cast<float>(between));
        }
      });
  return opened;
}

/// Takes the necks out of the level set, and marks where that moves the surface. Next to a neck the change fades.
void cutNecks(LevelSet& set, const std::vector<float>& opened, std::vector<std::uint8_t> necks, const RunContext& ctx) {
  constexpr double kFade = 3, kNear = 1.8, kTiny = 1e-3; // voxels
  const double h = set.grid.voxelSize();
  set.changed = std::move(necks);
  const std::vector<float> distance = distanceFromChange(set, 0, ctx);
  for (std::size_t n = 0; n < distance.size(); ++n) {
    const double weight = std::clamp(1 - distance[n] / (kFade * h), 0.0, 1.0), old = set.value[n];
    const double value = old + weight * (std::max<double>(old, opened[n]) - old);
    set.value[n] = static_cast<float>(value);
    set.changed[n] = value - old > kTiny * h && std::min(std::abs(old), std::abs(value)) < kNear * h;
  }
}

} // namespace

LevelSet splitAtNecks(const SurfaceParts& parts, const TopologyLengths& lengths, bool everywhere,
                      const RunContext& ctx) {
  const double h = lengths.voxelSize, radius = lengths.neck / 2;
  RegionMarker marker(parts, h, 2 * radius + (kMargin + 2 * kStrip) * h, ctx);
  if (everywhere) marker.markSurface(0);
  marker.markThin(0, radius);
  LevelSet set = measuredPart(marker.take(), parts, radius + 4 * h, ctx);
  std::vector<std::uint8_t> taken(set.value.size()), core(set.value.size());
  constexpr double kDeep = 1.5; // voxels below the surface of the eroded solid
  for (std::size_t n = 0; n < core.size(); ++n) core[n] = set.value[n] < -radius - kDeep * h;
  const Cores cores = coresOf(set, core, radius, ctx);
  if (cores.contour.triangles.empty()) return set;
  const std::vector<float> opened = openedDistance(set, cores, radius, ctx);
  constexpr double kTaken = 0.5; // voxels: more than the opening takes off where the solid is rounder than the ball
  for (std::size_t n = 0; n < taken.size(); ++n) taken[n] = set.value[n] < 0 && opened[n] > kTaken * h;
  const Pieces pieces = piecesOf(set.grid, taken);
  Remainder remainder(parts[0]->columns(), set.grid, pieces, core);
  cutNecks(set, opened, necksOf(set.grid, pieces, remainder), ctx);
  return set;
}

} // namespace volcaustic
