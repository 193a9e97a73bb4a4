#include "transport/caustic.h"

#include "backends/lanes.h"
#include "core/parallel.h"

#include <optional>

namespace volcaustic {

namespace {

using kernels::Int3;

constexpr int kBlockBricks = kBlockEdge / kBrickSize; // along an axis
constexpr std::int32_t kBricks = kBlockBricks * kBlockBricks * kBlockBricks;

/// Goes through the blocks of a domain: sums first, then, while they are in cache, light.
class CausticGatherer {
public:
  CausticGatherer(const PhotonTracer& tracer, const FlatMediumStorage& flat, double voxelSize, const FixedPoint& scale,
                  bool smooth, FluenceGrid& caustic, const RunContext& ctx)
      : mTracer(tracer)
      , mFlat(flat.view())
      , mBlocks(blockDims(mFlat.dims))
      , mWatts(1 / scale.deposit)
      // Sums are W*voxel; fluence is their world length over the voxel's volume.
      , mUnit(static_cast<float>(mWatts / (voxelSize * voxelSize)))
      , mSmooth(smooth)
      , mCaustic(caustic)
      , mCtx(ctx)
      , mWorkers(threadCount(ctx)) {}

  Rgb run() {
    std::vector<std::int64_t> blocks;
    for (std::int64_t b = 0; b < std::int64_t{mBlocks.x} * mBlocks.y * mBlocks.z; ++b)
      if (mTracer.touched(b)) blocks.push_back(b);
    const auto count = static_cast<std::int64_t>(blocks.size());
    mCaustic.reserve((count + static_cast<std::int64_t>(mWorkers.size())) * kBricks, mCtx);
    std::vector<Rgb> losses(count);
    parallelFor(count, 1, mCtx, [&](std::int64_t begin, std::int64_t end, int slot) {
      for (std::int64_t i = begin; i < end; ++i) losses[i] = gather(blocks[i], mWorkers[slot]);
    });
    Rgb loss{0, 0, 0};
    for (const Rgb& l : losses)
      for (int c = 0; c < 3; ++c) loss[c] += l[c];
    return loss;
  }

private:
  struct Worker {
    std::optional<BlockSums> sums;
    std::vector<std::int32_t> slots; ///< claimed and not given to a brick yet
  };

  /// Light of a block; returns what the medium takes of it.
  Rgb gather(std::int64_t block, Worker& worker) {
    if (!worker.sums) worker.sums.emplace();
    BlockSums& sums = *worker.sums;
    sums.clear();
    mTracer.addBlock(block, sums);
    const Int3 corner = blockCorner(mBlocks, block);

    if (const auto missing = kBricks - static_cast<std::int32_t>(worker.slots.size()); missing > 0) {
      const std::int32_t first = mCaustic.claim(missing);
      for (std::int32_t i = 0; i < missing; ++i) worker.slots.push_back(first + i);
    }
    std::array<kernels::FluenceVoxel*, kBricks> bricks;
    for (std::int32_t i = 0; i < kBricks; ++i) {
      const auto voxels = mCaustic.slot(worker.slots[i]);
      if (crossesFace(corner, i)) std::fill(voxels.begin(), voxels.end(), kernels::FluenceVoxel{});
      bricks[i] = voxels.data();
    }
    const std::vector<kernels::CarriedSums> carried = sums.carried();
    kernels::LightSums<std::int32_t> light{
        sums.low(), carried.data(), static_cast<std::int32_t>(carried.size()), {}, {}, mUnit, mSmooth};
    for (int a = 0; a < 3; ++a) {
      light.from[a] = corner[a] == 0 ? 1 : 0;
      light.to[a] = std::min(kSumsEdge, mFlat.dims[a] - corner[a] + 1);
    }
    assign(corner, mLanes.finishBlock(light, bricks.data()), worker.slots);
    return mFlat.attenuates ? lossOf(corner, sums) : Rgb{0, 0, 0};
  }

  static Int3 brickAt(const Int3& corner, std::int32_t i) {
    return {corner.x / kBrickSize + i / (kBlockBricks * kBlockBricks),
            corner.y / kBrickSize + i / kBlockBricks % kBlockBricks, corner.z / kBrickSize + i % kBlockBricks};
  }
  /// Whether a part of the brick is outside the domain.
  [[nodiscard]] bool crossesFace(const Int3& corner, std::int32_t i) const {
    const Int3 brick = brickAt(corner, i);
    bool crosses = false;
    for (int a = 0; a < 3; ++a) crosses = crosses || (brick[a] + 1) * kBrickSize > mFlat.dims[a];
    return crosses;
  }

  /// Gives the lit bricks their slots; the others' slots stay with the worker.
  void assign(const Int3& corner, std::uint64_t lit, std::vector<std::int32_t>& slots) const {
    std::vector<std::int32_t> left;
    for (std::int32_t i = 0; i < kBricks; ++i) {
      const Int3 brick = brickAt(corner, i);
      if (lit >> i & 1)
        mCaustic.assign(mCaustic.brickIndex({brick.x, brick.y, brick.z}), slots[i]);
      else
        left.push_back(slots[i]);
    }
    slots = std::move(left);
  }

  /// Attenuation (1/voxel) times light (W*voxel), over the block's voxels.
  [[nodiscard]] Rgb lossOf(const Int3& corner, const BlockSums& sums) const {
    Rgb loss{0, 0, 0};
    for (std::int32_t i = 0; i < kBricks; ++i) {
      if (!insideDomain(brickAt(corner, i))) continue;
      const Int3 brick = brickAt(corner, i), first(brick.x * 8, brick.y * 8, brick.z * 8);
      const std::int32_t slot = mFlat.opticsSlots[mFlat.brickIndex(first)];
      const auto forVoxels = [&](const auto& visit) {
        forVoxelsInSums({first.x - corner.x, first.y - corner.y, first.z - corner.z},
                        [&](int k, int voxel) { visit(k, sums.at(voxel)); });
      };
      const auto add = [&](std::int32_t entry, const VoxelSums& s) {
        for (int c = 0; c < 3; ++c)
          loss[c] += static_cast<double>(mFlat.optics[entry].attenuation[c]) * static_cast<double>(s[c]) * mWatts;
      };
      if (slot > 0) {
        forVoxels([&](int k, const VoxelSums& s) {
          add(mFlat.voxelOptics[std::size_t(slot) * kernels::kStepVoxels + k], s);
        });
      } else if (kernels::maxComponent(mFlat.optics[-slot].attenuation) > 0) {
        VoxelSums all{};
        forVoxels([&](int, const VoxelSums& s) {
          for (int c = 0; c < 3; ++c) all[c] += s[c];
        });
        add(-slot, all);
      }
    }
    return loss;
  }
  [[nodiscard]] bool insideDomain(const Int3& brick) const {
    return brick.x < mFlat.brickDims.x && brick.y < mFlat.brickDims.y && brick.z < mFlat.brickDims.z;
  }

  const PhotonTracer& mTracer;
  kernels::FlatMedium mFlat;
  Int3 mBlocks;
  double mWatts;
  float mUnit;
  bool mSmooth;
  FluenceGrid& mCaustic;
  const RunContext& mCtx;
  const LaneSet& mLanes = laneSet("");
  std::vector<Worker> mWorkers;
};

} // namespace

Rgb gatherCaustic(const PhotonTracer& tracer, const FlatMediumStorage& flat, double voxelSize, const FixedPoint& scale,
                  bool smooth, FluenceGrid& caustic, const RunContext& ctx) {
  return CausticGatherer(tracer, flat, voxelSize, scale, smooth, caustic, ctx).run();
}

} // namespace volcaustic
