#include "volume/voxelise.h"

#include "core/parallel.h"
#include "volcaustic/error.h"
#include "volume/brick_collector.h"
#include "volume/cap_winding.h"
#include "volume/coverage_rows.h"
#include "volume/winding.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <sstream>

namespace volcaustic {

namespace {

/// Larger coordinates are the mark of a broken file: 1e15 metres is a tenth of a light year.
constexpr double kAbsurdCoordinate = 1e15;

std::string placeOf(const Body& body) { return body.name.empty() ? "mesh" : body.name; }

Box checkedBounds(const Body& body) {
  if (!body.mesh || body.mesh->empty())
    throw Error(ErrorKind::Input, placeOf(body) + ": the mesh holds no triangle; check the file");
  const Mesh& mesh = *body.mesh;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (v >= mesh.positions.size())
        throw Error(ErrorKind::Input, placeOf(body) + ": triangle " + std::to_string(t) + " names vertex " +
                                          std::to_string(v) + " of " + std::to_string(mesh.positions.size()));
      for (int a = 0; a < 3; ++a) {
        const double c = mesh.positions[v][a];
        if (!(std::abs(c) <= kAbsurdCoordinate)) {
          std::ostringstream text;
          text << placeOf(body) << ": vertex " << v << " has coordinate " << c
               << ", not finite or beyond 1e15; check the file and its units";
          throw Error(ErrorKind::Input, text.str());
        }
        box.min[a] = std::min(box.min[a], c);
        box.max[a] = std::max(box.max[a], c);
      }
    }
  return box;
}

/// The triangles of a mesh and of the caps that close it, as one list on the lattice.
class Triangles {
public:
  Triangles(const Mesh& mesh, const LoopCaps& caps, const SubLattice& lattice, const RunContext& ctx)
      : mMesh(mesh), mCaps(caps), mPoints(mesh.positions.size() + caps.positions.size()) {
    const auto ofMesh = static_cast<std::int64_t>(mesh.positions.size());
    parallelFor(static_cast<std::int64_t>(mPoints.size()), 8192, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i)
        mPoints[i] = lattice.snap(i < ofMesh ? mesh.positions[i] : caps.positions[i - ofMesh]);
    });
  }
  [[nodiscard]] std::int64_t size() const {
    return static_cast<std::int64_t>(mMesh.triangles.size() + mCaps.triangles.size());
  }
  [[nodiscard]] FixedTriangle operator[](std::int64_t i) const {
    const auto ofMesh = static_cast<std::int64_t>(mMesh.triangles.size());
    const auto& t = i < ofMesh ? mMesh.triangles[i] : mCaps.triangles[i - ofMesh];
    const FixedPoint* points = mPoints.data() + (i < ofMesh ? 0 : mMesh.positions.size());
    return {points[t[0]], points[t[1]], points[t[2]]};
  }

private:
  const Mesh& mMesh;
  const LoopCaps& mCaps;
  std::vector<FixedPoint> mPoints;
};

/// Which triangles meet which column of bricks.
class ColumnBins {
public:
  ColumnBins(const Triangles& triangles, const SubLattice& lattice, const std::string& what, const RunContext& ctx)
      : mLattice(lattice)
      , mColumns{lattice.size[0] / lattice.brickSamples(), lattice.size[1] / lattice.brickSamples()} {
    // Every cell counts up first and then down to its start. Threads race for the order inside a column, and rows add
    // signs in any order to the same winding numbers.
    const auto cells = static_cast<std::size_t>(mColumns[0]) * mColumns[1];
    mStart.assign(cells + 1, 0);
    const auto forEachEntry = [&](auto&& visit) {
      parallelFor(triangles.size(), 4096, ctx, [&](std::int64_t begin, std::int64_t end, int) {
        for (std::int64_t i = begin; i < end; ++i) forEachColumn(triangles[i], [&](std::int64_t c) { visit(c, i); });
      });
    };
    forEachEntry(
        [&](std::int64_t c, std::int64_t) { std::atomic_ref(mStart[c]).fetch_add(1, std::memory_order_relaxed); });
    std::uint64_t sum = 0;
    for (std::uint64_t& cell : mStart) cell = sum += cell;
    ctx.requireMemory(sum * sizeof(std::uint32_t) + mStart.size() * sizeof(std::uint64_t), what);
    mTriangles.resize(sum);
    forEachEntry([&](std::int64_t c, std::int64_t i) {
      mTriangles[std::atomic_ref(mStart[c]).fetch_sub(1, std::memory_order_relaxed) - 1] =
          static_cast<std::uint32_t>(i);
    });
  }

  [[nodiscard]] std::int64_t size() const { return std::int64_t{mColumns[0]} * mColumns[1]; }
  [[nodiscard]] std::array<int, 2> coord(std::int64_t column) const {
    return {static_cast<int>(column / mColumns[1]), static_cast<int>(column % mColumns[1])};
  }
  [[nodiscard]] std::span<const std::uint32_t> triangles(std::int64_t column) const {
    return {mTriangles.data() + mStart[column], mTriangles.data() + mStart[column + 1]};
  }

private:
  template <class Visit>
  void forEachColumn(const FixedTriangle& triangle, Visit&& visit) const {
    const RowRect all = rowsMet(triangle, mLattice);
    if (all.empty()) return;
    const int n = mLattice.brickSamples(), shift = kBrickLog2 + mLattice.log2;
    const bool single = all.x0 >> shift == all.x1 >> shift && all.y0 >> shift == all.y1 >> shift;
    for (int x = all.x0 >> shift; x <= all.x1 >> shift; ++x)
      for (int y = all.y0 >> shift; y <= all.y1 >> shift; ++y) {
        const RowRect rect{std::max(all.x0, x * n), std::max(all.y0, y * n), std::min(all.x1, x * n + n - 1),
                           std::min(all.y1, y * n + n - 1)};
        if (single || mayMeet(triangle, rect)) visit(std::int64_t{x} * mColumns[1] + y);
      }
  }

  SubLattice mLattice;
  std::array<int, 2> mColumns;
  std::vector<std::uint64_t> mStart;
  std::vector<std::uint32_t> mTriangles;
};

/// Turns the triangles of one column of bricks at a time into coverage. One for each thread: it owns the buffers.
class ColumnVoxeliser {
public:
  ColumnVoxeliser(const Triangles& triangles, const ColumnBins& bins, const CapOffsets* offsets,
                  const SubLattice& lattice)
      : mTriangles(triangles)
      , mBins(bins)
      , mOffsets(offsets)
      , mLattice(lattice)
      , mRows(lattice.brickSamples() * lattice.brickSamples())
      , mWinding(mRows)
      , mBits(mRows)
      , mRowStart(mRows + 1)
      , mBrickStart(lattice.size[2] / lattice.brickSamples() + 1) {}

  void run(std::int64_t column, BrickGrid<float>& grid, BrickCollector<float>& mixed, int slot) {
    const auto [x, y] = mBins.coord(column);
    mCrossings.clear();
    for (const std::uint32_t t : mBins.triangles(column)) appendCrossings(mTriangles[t], x, y, mLattice, mCrossings);
    if (mCrossings.empty() && !mOffsets) return;
    sortByBrick();
    std::fill(mWinding.begin(), mWinding.end(), 0);
    mWindingRows = 0;
    for (int z = 0; z + 1 < static_cast<int>(mBrickStart.size()); ++z) {
      const std::span crossings(mSorted.data() + mBrickStart[z], mBrickStart[z + 1] - mBrickStart[z]);
      const std::int64_t brick = grid.brickIndex({x, y, z});
      const std::int16_t offset = mOffsets ? mOffsets->ofBrick(brick) : std::int16_t{0};
      if (crossings.empty() && offset == 0 && (mWindingRows == 0 || mWindingRows == mRows)) {
        if (mWindingRows) grid.setConstant(brick, 1.0f);
        continue;
      }
      if (offset == CapOffsets::kVaries) mOffsets->ofSamples({x, y, z}, mSampleOffsets);
      runRows(crossings, offset);
      storeBrick(brick, grid, mixed, slot);
    }
  }

private:
  void sortByBrick() {
    std::fill(mBrickStart.begin(), mBrickStart.end(), 0);
    for (const Crossing c : mCrossings) ++mBrickStart[crossingBrick(c)];
    std::uint32_t sum = 0;
    for (std::uint32_t& start : mBrickStart) start = sum += start;
    mSorted.resize(mCrossings.size());
    for (const Crossing c : mCrossings) mSorted[--mBrickStart[crossingBrick(c)]] = c;
  }

  /// Crossings of one brick by row; mRowStart tells the rows apart.
  void sortByRow(std::span<const Crossing> crossings) {
    std::fill(mRowStart.begin(), mRowStart.end(), 0);
    for (const Crossing c : crossings) ++mRowStart[crossingRow(c)];
    std::uint32_t sum = 0;
    for (std::uint32_t& start : mRowStart) start = sum += start;
    mByRow.resize(crossings.size());
    for (const Crossing c : crossings) mByRow[--mRowStart[crossingRow(c)]] = c;
  }

  void runRows(std::span<const Crossing> crossings, std::int16_t offset) {
    sortByRow(crossings);
    const int n = mLattice.brickSamples();
    mWindingRows = 0;
    for (int row = 0; row < mRows; ++row) {
      const std::span ofRow(mByRow.data() + mRowStart[row], mRowStart[row + 1] - mRowStart[row]);
      if (ofRow.size() > 1) std::sort(ofRow.begin(), ofRow.end()); // by sample, all else being equal
      mBits[row] = offset == CapOffsets::kVaries
                       ? insideBits(ofRow, std::span(mSampleOffsets).subspan(static_cast<std::size_t>(row) * n, n),
                                    mWinding[row])
                       : insideBits(ofRow, offset, n, mWinding[row]);
      mWindingRows += mWinding[row] != 0;
    }
  }

  void storeBrick(std::int64_t brick, BrickGrid<float>& grid, BrickCollector<float>& mixed, int slot) {
    countSamples(mBits, mLattice.log2, mCounts);
    const float fraction = 1.0f / static_cast<float>(1 << (3 * mLattice.log2));
    const std::uint16_t first = mCounts[0];
    if (std::all_of(mCounts.begin(), mCounts.end(), [first](std::uint16_t c) { return c == first; })) {
      if (first) grid.setConstant(brick, fraction * first);
      return;
    }
    std::transform(mCounts.begin(), mCounts.end(), mixed.add(slot, brick).begin(),
                   [fraction](std::uint16_t c) { return fraction * c; });
  }

  const Triangles& mTriangles;
  const ColumnBins& mBins;
  const CapOffsets* mOffsets;
  SubLattice mLattice;
  int mRows;
  int mWindingRows = 0; // rows whose winding number is not zero at the end of the brick
  std::vector<int> mWinding;
  std::vector<std::uint64_t> mBits;
  std::vector<std::uint32_t> mRowStart, mBrickStart;
  std::vector<Crossing> mCrossings, mSorted, mByRow;
  std::vector<std::int16_t> mSampleOffsets;
  std::array<std::uint16_t, kBrickVoxels> mCounts{};
};

void reportOpenMesh(const Body& body, FillRule fill, const RunContext& ctx) {
  if (fill == FillRule::Winding) return;
  const MeshReport report = checkMesh(*body.mesh, ctx);
  const std::string counts = std::to_string(report.openEdges) + " open, " + std::to_string(report.inconsistentEdges) +
                             " inconsistently wound and " + std::to_string(report.nonManifoldEdges) +
                             " non-manifold edges";
  if (fill == FillRule::Exact)
    throw Error(ErrorKind::Input, placeOf(body) + ": the mesh is not closed (" + counts +
                                      "), which the exact fill needs; repair it or use the fill 'winding' or 'auto'");
  ctx.warn(placeOf(body) + ": the mesh is not closed (" + counts +
           "); inside is told from outside by the generalised winding number");
}

/// Bricks of the domain that a box in world space meets, grown by `margin` voxels; empty when first > last somewhere.
struct BrickRange {
  Vec3i first, last;
  [[nodiscard]] bool empty() const { return first[0] > last[0] || first[1] > last[1] || first[2] > last[2]; }
};
BrickRange bricksMet(const Box& box, double margin, const Domain& domain) {
  BrickRange range{};
  for (int a = 0; a < 3; ++a) {
    const double bricks = (domain.dims[a] + 7) / 8;
    const auto brickAt = [&](double p) {
      return std::floor((p - domain.minCorner[a]) / domain.voxelSize / kBrickSize);
    };
    const double grow = margin / kBrickSize;
    range.first[a] = static_cast<int>(std::clamp(brickAt(box.min[a]) - std::ceil(grow), 0.0, bricks));
    range.last[a] = static_cast<int>(std::clamp(brickAt(box.max[a]) + std::ceil(grow), -1.0, bricks - 1));
  }
  return range;
}

SubLattice latticeOf(const BrickRange& range, const Domain& domain, int supersample) {
  SubLattice lattice;
  lattice.corner = domain.minCorner;
  lattice.scale = supersample / domain.voxelSize;
  while (1 << lattice.log2 < supersample) ++lattice.log2;
  for (int a = 0; a < 3; ++a) {
    lattice.first[a] = range.first[a] * lattice.brickSamples();
    lattice.size[a] = (range.last[a] - range.first[a] + 1) * lattice.brickSamples();
  }
  return lattice;
}

double areaInVoxels(const LoopCaps& caps, const Domain& domain) {
  double area = 0;
  for (const auto& t : caps.triangles) {
    const Vec3d &a = caps.positions[t[0]], &b = caps.positions[t[1]], &c = caps.positions[t[2]];
    const Vec3d u{b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    area += 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  }
  return area / (domain.voxelSize * domain.voxelSize);
}

void requireReach(const Body& body, const Box& box, const Domain& domain, int supersample) {
  const double h = domain.voxelSize / supersample;
  for (int a = 0; a < 3; ++a)
    if (std::max(std::abs(box.min[a] - domain.minCorner[a]), std::abs(box.max[a] - domain.minCorner[a])) / h >=
        kMaxSubVoxels)
      throw Error(ErrorKind::Input, placeOf(body) +
                                        ": the mesh reaches 2^40 sub-voxels and more from the domain; check "
                                        "its units, or take larger voxels");
}

/// Faces that come twice, once for each side, enclose nothing; nor does a body between the samples show.
void warnIfEmpty(const CoveragePatch& patch, const Body& body, const RunContext& ctx) {
  if (!patch.coverage.occupied().empty()) return;
  ctx.warn(placeOf(body) +
           ": no sample of the domain is inside the mesh; it is thinner than a sub-voxel, lies outside, or "
           "its faces cancel (each present once for each side)");
}

} // namespace

CoveragePatch voxeliseBody(const Body& body, const Domain& domain, int supersample, FillRule fill,
                           const RunContext& ctx) {
  const Box box = checkedBounds(body);
  requireReach(body, box, domain, supersample);
  const Mesh& mesh = *body.mesh;
  const std::vector<BoundaryEdge> chain = boundaryChain(mesh, ctx);
  if (!chain.empty()) reportOpenMesh(body, fill, ctx);
  const LoopCaps caps = capLoops(mesh, chain);

  // Outside its box a closed mesh winds around nothing; at a distance d caps of area A do by less than A / (4 pi d^2).
  const double margin = chain.empty() ? 0 : std::sqrt(areaInVoxels(caps, domain) / 6.28) + 1;
  const BrickRange range = bricksMet(box, margin, domain);
  CoveragePatch patch;
  if (range.empty()) return patch;
  patch.firstBrick = range.first;
  const SubLattice lattice = latticeOf(range, domain, supersample);
  const Vec3i dims{lattice.size[0] / supersample, lattice.size[1] / supersample, lattice.size[2] / supersample};
  const std::string what = placeOf(body) + ": voxelising at this resolution";
  ctx.requireMemory(std::uint64_t(dims[0]) * dims[1] * dims[2] / kBrickVoxels * 10, what);
  patch.coverage = BrickGrid<float>(dims, 0.0f);

  const Triangles triangles(mesh, caps, lattice, ctx);
  const ColumnBins bins(triangles, lattice, what, ctx);
  std::unique_ptr<const CapOffsets> offsets;
  if (!chain.empty()) offsets = std::make_unique<CapOffsets>(caps, lattice, ctx);
  BrickCollector<float> mixed(ctx);
  std::vector<std::unique_ptr<ColumnVoxeliser>> voxelisers(threadCount(ctx));
  parallelFor(
      bins.size(), 1, ctx,
      [&](std::int64_t begin, std::int64_t end, int slot) {
        auto& voxeliser = voxelisers[slot];
        if (!voxeliser) voxeliser = std::make_unique<ColumnVoxeliser>(triangles, bins, offsets.get(), lattice);
        for (std::int64_t column = begin; column < end; ++column) voxeliser->run(column, patch.coverage, mixed, slot);
      },
      "voxelise");
  mixed.moveInto(patch.coverage, what, ctx);
  warnIfEmpty(patch, body, ctx);
  return patch;
}

} // namespace volcaustic
