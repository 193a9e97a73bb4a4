// Photons on this machine's cores: oneTBB over tiles of the raster, lanes inside.

#include "backends/cpu_emission.h"
#include "backends/far_light.h"
#include "core/parallel.h"

#include <algorithm>

namespace volcaustic {

namespace {

using kernels::EmissionFrame;
using kernels::kReachTile;

constexpr std::int64_t kPhotonsPerTask = 2048;
constexpr std::size_t kMostFarChords = 1 << 22; // 224 MiB; beyond, they are rasterised before the next trace

class CpuTracer final : public PhotonTracer {
public:
  CpuTracer(const TracerSetup& setup, const RunContext& ctx, const LaneSet& lanes)
      : mSetup(setup), mCtx(ctx), mLanes(lanes), mFar(setup.medium.dims, lanes) {
    mBudget.limit = ctx.effectiveMemoryLimit();
    for (int i = 0; i < threadCount(ctx); ++i) mSums.push_back({LightBricks(setup.medium.brickCount(), mBudget), {}});
  }

  void emit(const EmissionFrame& frame, const kernels::RasterReach& reach, RowRange rows,
            const RasterCells& cells) override {
    emitOnCpu(mSetup, mLanes, mCtx, frame, reach, rows, cells, mSums);
  }

  void trace(const EmissionFrame& frame, RowRange rows, const RasterCells& raster) override {
    const std::vector<std::uint32_t> cells = bendingCells(frame, rows, raster.entry);
    const auto count = static_cast<std::int64_t>(cells.size());
    const std::span<FarChords> far = mFar.newTasks((count + kPhotonsPerTask - 1) / kPhotonsPerTask);
    parallelFor(
        count, kPhotonsPerTask, mCtx,
        [&](std::int64_t begin, std::int64_t end, int slot) {
          mLanes.tracePhotons({mSetup.medium, frame, mSetup.rules, mSetup.scale, raster.entry, cells.data() + begin,
                               end - begin, raster.landings},
                              mSums[slot], far[begin / kPhotonsPerTask]);
        },
        "photons");
    if (mFar.waiting() > kMostFarChords) settleFarLight();
  }

  void finish() override { mFar.sort(mCtx); }

  [[nodiscard]] bool touched(std::int64_t block) const override {
    bool light = mFar.touched(block);
    forBricksInSums(mSetup.medium.brickDims, cornerOf(block), [&](std::int64_t brick, const kernels::Int3&) {
      for (const CpuSums& s : mSums) light = light || s.bricks.touched(brick);
    });
    return light;
  }
  void addBlock(std::int64_t block, BlockSums& sums) const override {
    mFar.addTo(block, static_cast<float>(mSetup.scale.deposit), sums);
    forBricksInSums(mSetup.medium.brickDims, cornerOf(block), [&](std::int64_t brick, const kernels::Int3& corner) {
      for (const CpuSums& s : mSums) s.bricks.addTo(brick, sums, corner);
    });
  }
  [[nodiscard]] PhotonTally tally() const override {
    PhotonTally total;
    for (const CpuSums& s : mSums) total += s.tally;
    return total;
  }
  [[nodiscard]] std::uint64_t peakBytes() const override { return mBudget.used + mFar.bytes(); }

private:
  /// Cells of a tile.
  struct Block {
    std::int32_t row0, row1, column0, column1;

    template <class Visit>
    void forEachCell(const EmissionFrame& frame, const Visit& visit) const {
      for (std::int32_t r = row0; r < row1; ++r)
        for (std::int32_t c = column0; c < column1; ++c) visit(std::int64_t{r} * frame.columns + c);
    }
  };

  /// Cells with a bend, tile by tile: neighbours in the list are neighbours in the raster, so the photons of a register
  /// go through the same bricks.
  [[nodiscard]] std::vector<std::uint32_t> bendingCells(const EmissionFrame& frame, RowRange rows,
                                                        const float* entry) const {
    const std::int64_t first = rows.begin / kReachTile, last = (rows.end + kReachTile - 1) / kReachTile;
    std::vector<std::vector<std::uint32_t>> found(last - first);
    parallelFor(last - first, 1, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t t = begin; t < end; ++t)
        for (std::int32_t column = 0; column < frame.columns; column += kReachTile) {
          const auto row = static_cast<std::int32_t>((first + t) * kReachTile);
          const Block block{std::max(row, rows.begin), std::min(row + kReachTile, rows.end), column,
                            std::min(column + kReachTile, frame.columns)};
          // In quarters, so that a register's photons are as close together as can be.
          for (std::int32_t quarter = 0; quarter < 4; ++quarter) {
            constexpr std::int32_t kHalf = kReachTile / 2;
            const std::int32_t r0 = row + quarter / 2 * kHalf, c0 = column + quarter % 2 * kHalf;
            const Block part{std::max(block.row0, r0), std::min(block.row1, r0 + kHalf), c0,
                             std::min(block.column1, c0 + kHalf)};
            part.forEachCell(frame, [&](std::int64_t cell) {
              if (entry[cell] != kernels::kNeverBends) found[t].push_back(static_cast<std::uint32_t>(cell));
            });
          }
        }
    });
    std::size_t count = 0;
    for (const auto& f : found) count += f.size();
    mCtx.requireMemory(2 * count * sizeof(std::uint32_t), "photons.grid");
    std::vector<std::uint32_t> cells;
    cells.reserve(count);
    for (const auto& f : found) cells.insert(cells.end(), f.begin(), f.end());
    return cells;
  }

  [[nodiscard]] kernels::Int3 cornerOf(std::int64_t block) const {
    return blockCorner(blockDims(mSetup.medium.dims), block);
  }

  /// Rasterises the far chords so far into the workers' bricks, which takes their memory back.
  void settleFarLight() {
    mFar.sort(mCtx);
    parallelFor(mFar.blockCount(), 1, mCtx, [&](std::int64_t begin, std::int64_t end, int slot) {
      BlockSums sums;
      for (std::int64_t block = begin; block < end; ++block) {
        if (!mFar.touched(block)) continue;
        sums.clear();
        mFar.addTo(block, static_cast<float>(mSetup.scale.deposit), sums);
        forBricksInSums(mSetup.medium.brickDims, cornerOf(block), [&](std::int64_t brick, const kernels::Int3& corner) {
          const auto inBlock = [](std::int32_t c) { return c >= 0 && c < kBlockEdge; };
          if (inBlock(corner.x) && inBlock(corner.y) && inBlock(corner.z)) mSums[slot].bricks.add(brick, sums, corner);
        });
      }
    });
    mFar.clear();
  }

  TracerSetup mSetup;
  RunContext mCtx;
  const LaneSet& mLanes;
  MemoryBudget mBudget;
  std::vector<CpuSums> mSums;
  FarLight mFar;
};

} // namespace

std::unique_ptr<PhotonTracer> makeCpuTracer(const TracerSetup& setup, const RunContext& ctx, std::string_view lanes) {
  return std::make_unique<CpuTracer>(setup, ctx, laneSet(lanes));
}

} // namespace volcaustic
