#include "volume/column_bins.h"

#include "core/parallel.h"
#include "core/simd_clones.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

using Corners = LatticeTriangles::Corners;

/// Triangles whose rectangles are found side by side, and the columns of bricks that these meet.
struct RectangleBlock {
  static constexpr int kSize = 64;

  double corners[3][3][kSize]; ///< of each corner, x, y and z
  double volumes[kSize];       ///< six times that under each triangle
  /// Columns, counted along x and y. Of triangles that meet none, firstX is greater than lastX.
  std::int32_t firstX[kSize], lastX[kSize], firstY[kSize], lastY[kSize];

  void load(const double* points, const Corners* triangles, int count) {
    for (int i = 0; i < count; ++i)
      for (int c = 0; c < 3; ++c) {
        const double* const p = points + 3 * std::size_t(triangles[i][c]);
        for (int axis = 0; axis < 3; ++axis) corners[c][axis][i] = p[axis];
      }
    for (auto& corner : corners) // something to compute with
      for (auto& axis : corner) std::fill(axis + count, axis + kSize, 0.0);
  }
};

/// The columns along one axis: kernels::rowRange in doubles, which round nothing that is near the lattice.
inline void columnsAlong(const double* __restrict a, const double* __restrict b, const double* __restrict c,
                         std::int32_t inset, std::int32_t rows, int shift, std::int32_t* __restrict firsts,
                         std::int32_t* __restrict lasts) {
  constexpr double kUnit = 1 / kFixedOne;
  const double start = inset, size = rows;
  for (int i = 0; i < RectangleBlock::kSize; ++i) {
    const double low = std::min(std::min(a[i], b[i]), c[i]), high = std::max(std::max(a[i], b[i]), c[i]);
    const double first = std::min(std::max(std::ceil((low + start) * kUnit) - 1, 0.0), size),
                 last = std::min(std::max(std::floor((high - start) * kUnit), -1.0), size - 1);
    const auto firstRow = static_cast<std::int32_t>(first), lastRow = static_cast<std::int32_t>(last);
    firsts[i] = firstRow >> shift;
    lasts[i] = firstRow <= lastRow ? lastRow >> shift : -1;
  }
}

VOLCAUSTIC_SIMD_CLONES void findRectangles(RectangleBlock& block, const SubLattice& lattice) {
  const auto& [a, b, c] = block.corners;
  const std::int32_t inset = kernels::stagger(0, lattice.log2), shift = kBrickLog2 + lattice.log2;
  columnsAlong(a[0], b[0], c[0], inset, lattice.size[0], shift, block.firstX, block.lastX);
  columnsAlong(a[1], b[1], c[1], inset, lattice.size[1], shift, block.firstY, block.lastY);
  const double farEnd = lattice.size[2] * kFixedOne; // beyond it no row is crossed
  for (int i = 0; i < RectangleBlock::kSize; ++i) {
    const bool met = std::min(std::min(a[2][i], b[2][i]), c[2][i]) <= farEnd;
    block.lastX[i] = met & (block.firstY[i] <= block.lastY[i]) ? block.lastX[i] : -1;
  }
  for (int i = 0; i < RectangleBlock::kSize; ++i)
    block.volumes[i] = (a[2][i] + b[2][i] + c[2][i]) *
                       ((b[0][i] - a[0][i]) * (c[1][i] - a[1][i]) - (b[1][i] - a[1][i]) * (c[0][i] - a[0][i]));
}

template <class N>
kernels::RowTriangle<N> triangleOf(const std::array<const double*, 3>& corners) {
  const auto corner = [](const double* p) { return kernels::Vec3<N>(N(p[0]), N(p[1]), N(p[2])); };
  return {corner(corners[0]), corner(corners[1]), corner(corners[2])};
}

} // namespace

struct ColumnBins::Span {
  std::int32_t firstX, lastX, firstY, lastY;
};

ColumnBins::ColumnBins(const LatticeTriangles& triangles, const SubLattice& lattice, const std::string& what,
                       const RunContext& ctx)
    : mTriangles(triangles)
    , mLattice(lattice)
    , mColumns{lattice.size[0] / lattice.brickSamples(), lattice.size[1] / lattice.brickSamples()} {
  const auto count = static_cast<std::int64_t>(triangles.corners().size()), columns = size();
  const std::int64_t parts = std::clamp<std::int64_t>(count / 4096, 1, 2 * threadCount(ctx));
  ctx.requireMemory(static_cast<std::uint64_t>(parts * columns) * sizeof(std::uint32_t) +
                        static_cast<std::uint64_t>(columns) * sizeof(std::uint64_t),
                    what);
  std::vector<Part> part(static_cast<std::size_t>(parts));
  parallelFor(parts, 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t p = begin; p < end; ++p) find(count * p / parts, count * (p + 1) / parts, part[p]);
  });
  for (const Part& p : part) mVolume += p.volume;
  sort(part, what, ctx);
}

void ColumnBins::find(std::int64_t begin, std::int64_t end, Part& part) const {
  part.counts.assign(static_cast<std::size_t>(size()), 0);
  part.entries.reserve(static_cast<std::size_t>(end - begin) * 3 / 2);
  RectangleBlock block;
  std::array<Entry, RectangleBlock::kSize> found;
  for (std::int64_t first = begin; first < end; first += RectangleBlock::kSize) {
    const auto count = static_cast<int>(std::min<std::int64_t>(RectangleBlock::kSize, end - first));
    block.load(mTriangles.points(), mTriangles.corners().data() + first, count);
    findRectangles(block, mLattice);
    int size = 0;
    for (int i = 0; i < count; ++i) {
      part.volume += block.volumes[i];
      const Span span{block.firstX[i], block.lastX[i], block.firstY[i], block.lastY[i]};
      const bool met = span.firstX <= span.lastX;
      if (met && (span.firstX != span.lastX || span.firstY != span.lastY)) {
        addSpread(first + i, span, part);
        continue;
      }
      // Whether small triangles meet rows at all cannot be foreseen: those that do not are written over.
      const auto column = static_cast<std::uint32_t>(span.firstX * mColumns[1] + span.firstY);
      found[size] = {column, static_cast<std::uint32_t>(first + i)};
      size += met;
    }
    for (int i = 0; i < size; ++i) ++part.counts[found[i].column];
    part.entries.insert(part.entries.end(), found.begin(), found.begin() + size);
  }
}

/// A triangle that meets more columns than one.
void ColumnBins::addSpread(std::int64_t triangle, const Span& span, Part& part) const {
  const auto visitIf = [&](auto&& meets) {
    for (int i = span.firstX; i <= span.lastX; ++i)
      for (int j = span.firstY; j <= span.lastY; ++j) {
        if (!meets(i, j)) continue;
        const auto column = static_cast<std::uint32_t>(i * mColumns[1] + j);
        part.entries.push_back({column, static_cast<std::uint32_t>(triangle)});
        ++part.counts[column];
      }
  };
  // In one line of columns it meets all of them.
  if (span.firstX == span.lastX || span.firstY == span.lastY) return visitIf([](int, int) { return true; });
  const Corners& t = mTriangles.corners()[triangle];
  std::array<const double*, 3> corners;
  for (int c = 0; c < 3; ++c) corners[c] = mTriangles.points() + 3 * std::size_t(t[c]);
  const auto extent = [&](int axis) {
    const auto [low, high] = std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
    return high - low;
  };
  const int shift = kBrickLog2 + mLattice.log2;
  const auto visitMet = [&](auto number) {
    using N = decltype(number);
    const auto exact = triangleOf<N>(corners);
    if (exact.flat()) return;
    const auto at = [shift](int column) { return N(column << shift) * N(1 << kernels::kFixedBits); };
    visitIf([&](int i, int j) { return exact.mayCross(at(i), at(j), at(i + 1), at(j + 1)); });
  };
  if (std::max(extent(0), extent(1)) < kernels::kExactInInt64 / 2)
    visitMet(std::int64_t{});
  else
    visitMet(__int128{});
}

void ColumnBins::sort(std::vector<Part>& parts, const std::string& what, const RunContext& ctx) {
  const std::int64_t columns = size();
  mStart.assign(static_cast<std::size_t>(columns) + 1, 0);
  std::uint64_t sum = 0;
  for (std::int64_t c = 0; c < columns; ++c) {
    mStart[c] = sum;
    for (Part& p : parts) {
      const std::uint32_t entries = p.counts[c];
      p.counts[c] = static_cast<std::uint32_t>(sum - mStart[c]);
      sum += entries;
    }
  }
  mStart[columns] = sum;
  ctx.requireMemory(2 * sum * sizeof(Entry), what);
  mIds.resize(sum);
  parallelFor(static_cast<std::int64_t>(parts.size()), 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t p = begin; p < end; ++p)
      for (const Entry& e : parts[p].entries) mIds[mStart[e.column] + parts[p].counts[e.column]++] = e.triangle;
  });
}

RowsTask ColumnBins::task(std::int64_t column) const {
  const auto [x, y] = coord(column);
  const int n = mLattice.brickSamples();
  const kernels::RowRect rows{x * n, y * n, x * n + n - 1, y * n + n - 1};
  return {mTriangles.points(),
          mTriangles.corners().data(),
          mIds.data() + mStart[column],
          static_cast<std::int64_t>(mStart[column + 1] - mStart[column]),
          kernels::RowColumn{rows.x0, rows.y0, mLattice.log2, mLattice.size[2]},
          rows,
          facesInwards()};
}

LatticeTriangles::LatticeTriangles(const Mesh& mesh, const LoopCaps& caps, const SubLattice& lattice,
                                   const RunContext& ctx)
    : mPoints(3 * (mesh.positions.size() + caps.positions.size())) {
  static_assert(sizeof(Vec3d) == 3 * sizeof(double));
  const auto snapAll = [&](const std::vector<Vec3d>& positions, double* out) {
    parallelFor(static_cast<std::int64_t>(positions.size()), 8192, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      lattice.snap(positions[begin].data(), end - begin, out + 3 * begin);
    });
  };
  snapAll(mesh.positions, mPoints.data());
  snapAll(caps.positions, mPoints.data() + 3 * mesh.positions.size());
  mCorners = mesh.triangles;
  if (caps.triangles.empty()) return;
  mJoined.assign(mesh.triangles.begin(), mesh.triangles.end());
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Corners& t : caps.triangles) mJoined.push_back({t[0] + first, t[1] + first, t[2] + first});
  mCorners = mJoined;
}

} // namespace volcaustic
