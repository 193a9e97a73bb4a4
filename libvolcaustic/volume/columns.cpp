#include "volume/columns.h"

#include "backends/lanes.h"
#include "backends/row_pages.h"
#include "core/parallel.h"
#include "volume/brick_collector.h"
#include "volume/column_bins.h"

#include <algorithm>
#include <memory>
#include <type_traits>
#include <utility>

namespace volcaustic {

namespace {

/// Of a voxel's samples those that are inside: 512 at most, half of what their fraction takes.
using Count = std::uint16_t;
float fractionOf(const SubLattice& lattice, Count count) {
  return (1.0f / static_cast<float>(1 << (3 * lattice.log2))) * count;
}

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

  void run(std::int64_t column, BrickGrid<float>& grid, BrickCollector<Count>& mixed, int slot) {
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
    insideOfOffsets(mWinding.data(), mSampleOffsets.data(), mRows, mLattice.brickSamples(), mInside.data());
    if (!mPages.touched(brick[2])) return;
    const Word* const bits = mPages.page<Word>(brick[2]);
    const std::span<const kernels::Crossing> extra = extraOf(brick[2]);
    for (int row = 0; row < mRows; ++row) // those of `extra` have a bit, too
      if (bits[row] | bits[mRows + row])
        walk(row, bits, extra, mSampleOffsets.data() + std::size_t(row) * mLattice.brickSamples(), 0);
  }

  void storeBrick(std::int64_t brick, BrickGrid<float>& grid, BrickCollector<Count>& mixed, int slot) {
    countSamples(mInside.data(), mLattice.log2, mCounts);
    const Count first = mCounts[0];
    if (!std::all_of(mCounts.begin(), mCounts.end(), [first](Count c) { return c == first; }))
      std::copy(mCounts.begin(), mCounts.end(), mixed.add(slot, brick).begin());
    else if (first)
      grid.setConstant(brick, fractionOf(mLattice, first));
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
  std::array<Count, kBrickVoxels> mCounts{};
};

template <class Word>
void voxeliseColumns(const ColumnBins& bins, const CapOffsets* offsets, const SubLattice& lattice,
                     BrickGrid<float>& grid, BrickCollector<Count>& mixed, const RunContext& ctx) {
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

void coverColumns(const LatticeTriangles& triangles, const CapOffsets* offsets, const SubLattice& lattice,
                  const std::string& what, BrickGrid<float>& coverage, const RunContext& ctx) {
  const ColumnBins bins(triangles, lattice, what, ctx);
  BrickCollector<Count> mixed(ctx);
  const auto run = lattice.log2 > 2 ? voxeliseColumns<std::uint64_t> : voxeliseColumns<std::uint32_t>;
  run(bins, offsets, lattice, coverage, mixed, ctx);
  mixed.moveInto(coverage, what, ctx, [&lattice](Count count) { return fractionOf(lattice, count); });
}

} // namespace volcaustic
