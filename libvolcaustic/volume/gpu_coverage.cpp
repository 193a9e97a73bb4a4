#include "volume/gpu_coverage.h"

#include "backends/devices.h"
#include "core/parallel.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace volcaustic {

namespace {

/// Triangles of a mesh that `auto` sends to the GPU. Below, the CPU's lanes take a few milliseconds, no more than
/// starting a dozen kernels and copying the counts back.
constexpr std::size_t kLeastTriangles = 20000;

/// The GPU that ctx.device means for a mesh of this size; without one, cudaOrdinal is -1.
DeviceChoice chooseFor(std::size_t triangles, const RunContext& ctx) {
  // No driver is woken up for small meshes.
  if (triangles < kLeastTriangles && parseDevice(ctx.device).kind == DeviceRequest::Kind::Auto) return {};
  RunContext quiet = ctx; // the photon pass tells what was chosen
  quiet.onLog = {};
  return chooseDevice(quiet);
}

/// Puts counted bricks into a grid.
class CountsIntoGrid {
public:
  CountsIntoGrid(BrickGrid<float>& grid, int log2, std::string_view what, const RunContext& ctx)
      : mGrid(grid), mCtx(ctx), mWhat(what), mFraction(1.0f / static_cast<float>(1 << (3 * log2))) {}

  void operator()(const CountedBricks& bricks) {
    const std::vector<Source> sources = varying(bricks);
    mCtx.requireMemory(mGrid.memoryBytes() + 2 * sources.size() * kBrickVoxels * sizeof(float), mWhat);
    std::vector<std::int64_t> numbers(sources.size());
    std::transform(sources.begin(), sources.end(), numbers.begin(), [](const Source& s) { return s.brick; });
    mGrid.activate(numbers, Fill::Later);
    parallelFor(static_cast<std::int64_t>(sources.size()), 64, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i)
        std::transform(sources[i].counts, sources[i].counts + kBrickVoxels, mGrid.voxels(sources[i].brick).begin(),
                       [this](std::uint16_t count) { return mFraction * count; });
    });
  }

private:
  struct Source {
    std::int64_t brick;
    const std::uint16_t* counts;
  };

  /// The bricks whose voxels differ; the others are set.
  std::vector<Source> varying(const CountedBricks& bricks) {
    std::vector<Source> sources;
    const std::uint16_t* counts = bricks.counts.data();
    for (std::size_t i = 0; i < bricks.fills.size(); ++i) {
      const std::int64_t brick = bricks.first + static_cast<std::int64_t>(i);
      if (bricks.fills[i] == BrickFill::Full) mGrid.setConstant(brick, 1.0f);
      if (bricks.fills[i] != BrickFill::Counted) continue;
      if (std::all_of(counts, counts + kBrickVoxels, [counts](std::uint16_t c) { return c == *counts; }))
        mGrid.setConstant(brick, mFraction * *counts);
      else
        sources.push_back({brick, counts});
      counts += kBrickVoxels;
    }
    return sources;
  }

  BrickGrid<float>& mGrid;
  const RunContext& mCtx;
  std::string_view mWhat;
  float mFraction;
};

} // namespace

bool coverageOnGpu(const CountTask& task, std::string_view what, BrickGrid<float>& coverage, const RunContext& ctx) {
  const DeviceChoice choice = chooseFor(task.triangles.size(), ctx);
  if (choice.cudaOrdinal < 0) return false;
  BrickGrid<float> counted(coverage.dims(), 0.0f);
  try {
    countOnCuda(task, CountsIntoGrid(counted, task.log2, what, ctx), ctx, choice.cudaOrdinal);
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Device || !choice.mayFallBack) throw;
    ctx.warn(std::string(e.what()) + "; going on with the CPU");
    return false;
  }
  coverage = std::move(counted);
  return true;
}

} // namespace volcaustic
