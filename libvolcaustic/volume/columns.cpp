#include "volume/columns.h"

#include "backends/lanes.h"
#include "backends/row_pages.h"
#include "core/parallel.h"
#include "volume/brick_collector.h"

#include <algorithm>
#include <memory>
#include <type_traits>
#include <utility>

namespace volcaustic {

namespace {

/// Which triangles meet which column of bricks.
class ColumnBins {
public:
  ColumnBins(const LatticeTriangles& triangles, const SubLattice& lattice, const std::string& what,
             const RunContext& ctx)
      : mTriangles(triangles)
      , mLattice(lattice)
      , mColumns{lattice.size[0] / lattice.brickSamples(), lattice.size[1] / lattice.brickSamples()} {
    // Each part of the triangles is sorted on its own and knows where its entries of a column go.
    const auto count = static_cast<std::int64_t>(triangles.corners().size()), columns = size();
    const std::int64_t parts = std::clamp<std::int64_t>(count / 4096, 1, 2 * threadCount(ctx));
    ctx.requireMemory(static_cast<std::uint64_t>(parts * columns) * sizeof(std::uint32_t) +
                          static_cast<std::uint64_t>(columns) * sizeof(std::uint64_t),
                      what);
    std::vector<Part> part(static_cast<std::size_t>(parts));
    parallelFor(parts, 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t p = begin; p < end; ++p) part[p].find(*this, count * p / parts, count * (p + 1) / parts);
    });
    for (const Part& p : part) mVolume += p.volume;
    mStart.assign(static_cast<std::size_t>(columns) + 1, 0);
    std::uint64_t sum = 0;
    for (std::int64_t c = 0; c < columns; ++c) {
      mStart[c] = sum;
      for (Part& p : part) {
        const std::uint32_t entries = p.counts[c];
        p.counts[c] = static_cast<std::uint32_t>(sum - mStart[c]);
        sum += entries;
      }
    }
    mStart[columns] = sum;
    ctx.requireMemory(2 * sum * sizeof(Entry), what);
    mIds.resize(sum);
    parallelFor(parts, 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t p = begin; p < end; ++p)
        for (const Entry& e : part[p].entries) mIds[mStart[e.column] + part[p].counts[e.column]++] = e.triangle;
    });
  }

  [[nodiscard]] std::int64_t size() const { return std::int64_t{mColumns[0]} * mColumns[1]; }
  [[nodiscard]] std::array<int, 2> coord(std::int64_t column) const {
    return {static_cast<int>(column / mColumns[1]), static_cast<int>(column % mColumns[1])};
  }
  /// Whether winding numbers are -1 inside rather than 1, as they are of a mesh that is inside out: lanes are at their
  /// best with 0 and 1.
  [[nodiscard]] bool facesInwards() const { return mVolume < 0; }
  /// The task of a column's triangles.
  [[nodiscard]] RowsTask task(std::int64_t column) const {
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

private:
  struct Entry {
    std::uint32_t column, triangle;
  };
  struct Part {
    std::vector<Entry> entries;
    std::vector<std::uint32_t> counts; ///< of each column
    double volume = 0;                 ///< under the triangles

    void find(const ColumnBins& bins, std::int64_t begin, std::int64_t end) {
      counts.assign(static_cast<std::size_t>(bins.size()), 0);
      entries.reserve(static_cast<std::size_t>(end - begin) * 5 / 4);
      for (std::int64_t i = begin; i < end; ++i)
        volume += bins.forEachColumn(bins.mTriangles.corners()[i], [&](std::uint32_t column) {
          entries.push_back({column, static_cast<std::uint32_t>(i)});
          ++counts[column];
        });
    }
  };

  /// \return six times the volume under the triangle, of which only the sign of a sum matters
  template <class Visit>
  double forEachColumn(const LatticeTriangles::Corners& corners, Visit&& visit) const {
    const double* const p = mTriangles.points();
    const double *a = p + 3 * std::size_t(corners[0]), *b = p + 3 * std::size_t(corners[1]),
                 *c = p + 3 * std::size_t(corners[2]);
    const double volume = (a[2] + b[2] + c[2]) * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    if (std::min(std::min(a[2], b[2]), c[2]) > mLattice.size[2] * kFixedOne) return volume; // beyond the rows' far ends
    const std::int32_t inset = kernels::stagger(0, mLattice.log2);
    // One by one: a list of three would be compared with jumps that cannot be foreseen.
    const double lowX = std::min(std::min(a[0], b[0]), c[0]), highX = std::max(std::max(a[0], b[0]), c[0]);
    const double lowY = std::min(std::min(a[1], b[1]), c[1]), highY = std::max(std::max(a[1], b[1]), c[1]);
    const kernels::RowRange x = kernels::rowRange(lowX, highX, inset, 0, mLattice.size[0] - 1),
                            y = kernels::rowRange(lowY, highY, inset, 0, mLattice.size[1] - 1);
    if (x.first > x.last || y.first > y.last) return volume;
    const int shift = kBrickLog2 + mLattice.log2;
    const int firstX = x.first >> shift, lastX = x.last >> shift, firstY = y.first >> shift, lastY = y.last >> shift;
    const auto column = [&](int i, int j) { return static_cast<std::uint32_t>(i * mColumns[1] + j); };
    // A triangle in no more than one row of columns meets all of them.
    if (firstX == lastX || firstY == lastY) {
      for (int i = firstX; i <= lastX; ++i)
        for (int j = firstY; j <= lastY; ++j) visit(column(i, j));
      return volume;
    }
    const double extent = std::max(highX - lowX, highY - lowY);
    const auto meet = [&](const auto& triangle, auto number) {
      using N = decltype(number);
      if (triangle.flat()) return;
      const auto at = [&](int row) { return N(row) * N(1 << kernels::kFixedBits); };
      for (int i = firstX; i <= lastX; ++i)
        for (int j = firstY; j <= lastY; ++j)
          if (triangle.mayCross(at(i << shift), at(j << shift), at((i + 1) << shift), at((j + 1) << shift)))
            visit(column(i, j));
    };
    if (extent < kernels::kExactInInt64 / 2)
      meet(triangleOf<std::int64_t>(a, b, c), std::int64_t{});
    else
      meet(triangleOf<__int128>(a, b, c), __int128{});
    return volume;
  }
  template <class N>
  static kernels::RowTriangle<N> triangleOf(const double* a, const double* b, const double* c) {
    const auto corner = [](const double* p) { return kernels::Vec3<N>(N(p[0]), N(p[1]), N(p[2])); };
    return {corner(a), corner(b), corner(c)};
  }

  const LatticeTriangles& mTriangles;
  SubLattice mLattice;
  std::array<int, 2> mColumns;
  double mVolume = 0;
  std::vector<std::uint64_t> mStart;
  std::vector<std::uint32_t> mIds;
};

/// Turns the triangles of one column of bricks at a time into coverage. One for each thread: it owns the buffers. Word
/// holds a row through a brick.
template <class Word>
class ColumnVoxeliser {
public:
  ColumnVoxeliser(const ColumnBins& bins, const CapOffsets* offsets, const SubLattice& lattice)
      : mLanes(laneSets().front())
      , mBins(bins)
      , mOffsets(offsets)
      , mLattice(lattice)
      , mReversed(bins.facesInwards())
      , mRows(lattice.brickSamples() * lattice.brickSamples())
      , mBricks(lattice.size[2] / lattice.brickSamples())
      , mPages(mBricks, lattice.log2)
      , mWinding(mRows)
      , mInside(mRows)
      , mZero(2 * std::size_t(mRows), 0)
      , mIrregular(mRows) {}

  void run(std::int64_t column, BrickGrid<float>& grid, BrickCollector<float>& mixed, int slot) {
    const RowsTask task = mBins.task(column);
    if (task.count == 0 && !mOffsets) return;
    mLanes.crossRows(task, mPages);
    if (mPages.empty() && !mOffsets) return;
    mPages.sortExtra();
    mExtra = mPages.extra();
    std::fill(mWinding.begin(), mWinding.end(), 0);
    mWindingRows = 0;
    const auto [x, y] = mBins.coord(column);
    for (int z = 0; z < mBricks; ++z) {
      const std::int64_t brick = grid.brickIndex({x, y, z});
      const std::int16_t offset = mOffsets ? mOffsets->ofBrick(brick) : std::int16_t{0};
      if (!mPages.touched(z) && offset == 0 && (mWindingRows == 0 || mWindingRows == mRows)) {
        if (mWindingRows) grid.setConstant(brick, 1.0f);
        continue;
      }
      if (offset == CapOffsets::kVaries)
        runVarying({x, y, z});
      else
        runRows(z, mReversed ? -offset : offset);
      mWindingRows = mRows - static_cast<int>(std::count(mWinding.begin(), mWinding.end(), 0));
      storeBrick(brick, grid, mixed, slot);
    }
    mPages.clear();
  }

private:
  using Signed = std::make_signed_t<Word>;

  /// Its rises, then its falls.
  const Word* bitsOf(int z) { return mPages.touched(z) ? mPages.page<Word>(z) : mZero.data(); }

  /// The brick's crossings beside those of the bits.
  std::span<const kernels::Crossing> extraOf(int z) {
    const auto ends =
        std::find_if(mExtra.begin(), mExtra.end(), [z](kernels::Crossing c) { return kernels::crossingBrick(c) != z; });
    const auto here = mExtra.first(static_cast<std::size_t>(ends - mExtra.begin()));
    mExtra = mExtra.subspan(here.size());
    return here;
  }

  /// One row by the definition, for what the lanes do not do.
  void walk(int row, const Word* bits, std::span<const kernels::Crossing> extra, const std::int16_t* offsets,
            int offset) {
    const auto of = std::equal_range(
        extra.begin(), extra.end(), kernels::Crossing(row) << 7,
        [](kernels::Crossing a, kernels::Crossing b) { return kernels::crossingRow(a) < kernels::crossingRow(b); });
    auto winding = static_cast<std::int32_t>(mWinding[row]);
    mInside[row] = kernels::insideBits<Word>({bits[row], bits[mRows + row]}, extra.data() + (of.first - extra.begin()),
                                             static_cast<int>(of.second - of.first), offsets, offset,
                                             mLattice.brickSamples(), winding);
    mWinding[row] = winding;
  }

  void runRows(int z, int offset) {
    const Word* const bits = bitsOf(z);
    const std::span<const kernels::Crossing> extra = extraOf(z);
    mSaved.clear();
    for (const kernels::Crossing c : extra)
      mSaved.push_back({kernels::crossingRow(c), mWinding[kernels::crossingRow(c)]});
    const RowSweep<Word> sweep{
        bits, bits + mRows, mWinding.data(), mInside.data(), mIrregular.data(), mRows, mLattice.brickSamples(), offset};
    const int irregular = [&] {
      if constexpr (sizeof(Word) == 4)
        return mLanes.sweepRows32(sweep);
      else
        return mLanes.sweepRows64(sweep);
    }();
    for (const auto& [row, winding] : mSaved) mWinding[row] = winding;
    for (int i = 0; i < irregular; ++i) walk(mIrregular[i], bits, extra, nullptr, offset);
    for (std::size_t i = 0; i < mSaved.size(); ++i) {
      const auto& [row, winding] = mSaved[i];
      if (i > 0 && mSaved[i - 1].first == row) continue;
      mWinding[row] = winding;
      walk(row, bits, extra, nullptr, offset);
    }
  }

  void runVarying(const Vec3i& brick) {
    mOffsets->ofSamples(brick, mSampleOffsets);
    if (mReversed)
      for (std::int16_t& offset : mSampleOffsets) offset = static_cast<std::int16_t>(-offset);
    const Word* const bits = bitsOf(brick[2]);
    const std::span<const kernels::Crossing> extra = extraOf(brick[2]);
    for (int row = 0; row < mRows; ++row)
      walk(row, bits, extra, mSampleOffsets.data() + std::size_t(row) * mLattice.brickSamples(), 0);
  }

  void storeBrick(std::int64_t brick, BrickGrid<float>& grid, BrickCollector<float>& mixed, int slot) {
    countSamples(mInside.data(), mLattice.log2, mCounts);
    const float fraction = 1.0f / static_cast<float>(1 << (3 * mLattice.log2));
    const std::uint16_t first = mCounts[0];
    if (std::all_of(mCounts.begin(), mCounts.end(), [first](std::uint16_t c) { return c == first; })) {
      if (first) grid.setConstant(brick, fraction * first);
      return;
    }
    std::transform(mCounts.begin(), mCounts.end(), mixed.add(slot, brick).begin(),
                   [fraction](std::uint16_t c) { return fraction * c; });
  }

  const LaneSet& mLanes;
  const ColumnBins& mBins;
  const CapOffsets* mOffsets;
  SubLattice mLattice;
  bool mReversed;
  int mRows, mBricks;
  int mWindingRows = 0; // rows whose winding number is not zero at the end of the brick
  RowPages mPages;
  std::span<const kernels::Crossing> mExtra; // of the bricks to come
  std::vector<Signed> mWinding;
  std::vector<Word> mInside, mZero;
  std::vector<std::uint16_t> mIrregular;
  std::vector<std::pair<int, Signed>> mSaved;
  std::vector<std::int16_t> mSampleOffsets;
  std::array<std::uint16_t, kBrickVoxels> mCounts{};
};

template <class Word>
void voxeliseColumns(const ColumnBins& bins, const CapOffsets* offsets, const SubLattice& lattice,
                     BrickGrid<float>& grid, BrickCollector<float>& mixed, const RunContext& ctx) {
  std::vector<std::unique_ptr<ColumnVoxeliser<Word>>> voxelisers(threadCount(ctx));
  parallelFor(
      bins.size(), 1, ctx,
      [&](std::int64_t begin, std::int64_t end, int slot) {
        auto& voxeliser = voxelisers[slot];
        if (!voxeliser) voxeliser = std::make_unique<ColumnVoxeliser<Word>>(bins, offsets, lattice);
        for (std::int64_t column = begin; column < end; ++column) voxeliser->run(column, grid, mixed, slot);
      },
      "voxelise");
}

} // namespace

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

void coverColumns(const LatticeTriangles& triangles, const CapOffsets* offsets, const SubLattice& lattice,
                  const std::string& what, BrickGrid<float>& coverage, const RunContext& ctx) {
  const ColumnBins bins(triangles, lattice, what, ctx);
  BrickCollector<float> mixed(ctx);
  const auto run = lattice.log2 > 2 ? voxeliseColumns<std::uint64_t> : voxeliseColumns<std::uint32_t>;
  run(bins, offsets, lattice, coverage, mixed, ctx);
  mixed.moveInto(coverage, what, ctx);
}

} // namespace volcaustic
