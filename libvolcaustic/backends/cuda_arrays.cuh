// What a photon pass keeps in a CUDA device's memory: the medium, the light sums, and the first bends of a raster.
#pragma once

#include "backends/cuda_memory.cuh"
#include "backends/cuda_sums.cuh"
#include "backends/flat_storage.h"

#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace volcaustic {

/// Receivers in device memory.
class DeviceReceivers {
public:
  DeviceReceivers(DeviceStream& s, const kernels::ReceiverScene& r) : mView(r) {
    if (!r.any()) return;
    const auto copy = [&](auto& array, const auto*& host, std::int64_t count) {
      if (!host) return;
      array = {s, host, count, "the receivers"};
      host = array.data();
    };
    copy(mNodes, mView.nodes, r.nodeCount);
    copy(mTriangles, mView.triangles, r.triangleCount);
    copy(mSurfaces, mView.surfaces, r.surfaceCount);
    copy(mIrradiance, mView.irradiance, 3 * r.texelCount);
  }
  [[nodiscard]] const kernels::ReceiverScene& view() const { return mView; }

private:
  kernels::ReceiverScene mView;
  DeviceArray<kernels::ReceiverNode> mNodes;
  DeviceArray<kernels::ReceiverTriangle> mTriangles;
  DeviceArray<kernels::ReceiverSurface> mSurfaces;
  DeviceArray<float> mIrradiance;
};

/// Whether two rasters have the same rays, and so the same bends.
inline bool sameRays(const kernels::EmissionFrame& a, const kernels::EmissionFrame& b) {
  const auto same = [](const kernels::Double3& p, const kernels::Double3& q) {
    return p.x == q.x && p.y == q.y && p.z == q.z;
  };
  return same(a.origin, b.origin) && same(a.axisU, b.axisU) && same(a.axisV, b.axisV) && same(a.axisW, b.axisW) &&
         a.u0 == b.u0 && a.v0 == b.v0 && a.du == b.du && a.dv == b.dv && a.columns == b.columns && a.rows == b.rows &&
         a.point == b.point && a.jitter == b.jitter && a.seed == b.seed && a.depth0 == b.depth0;
}

/// A flat medium in device memory: copied there, or `there` already because it was made on the device.
class DeviceMedium {
public:
  DeviceMedium(DeviceStream& s, const kernels::FlatMedium& m, std::shared_ptr<const DeviceFlatMedium> there = nullptr)
      : mView(m) {
    if (there && there->ordinal() == s.ordinal()) {
      mThere = std::move(there);
      mView = mThere->view();
      return;
    }
    const auto copy = [&](auto& array, const auto*& host, std::int64_t count) {
      array = {s, host, count, kWhat};
      host = array.data();
    };
    copy(mFieldSlots, mView.fieldSlots, m.brickCount());
    copy(mIndexOffsets, mView.indexOffsets, m.brickCount());
    copy(mStepSlots, mView.stepSlots, m.brickCount());
    copy(mOpticsSlots, mView.opticsSlots, m.brickCount());
    copy(mBends, mView.bends, m.brickCount());
    copy(mFields, mView.fields, m.fieldCount);
    copy(mSteps, mView.steps, m.stepCount);
    copy(mVoxelOptics, mView.voxelOptics, m.voxelOpticsCount);
    copy(mOptics, mView.optics, m.opticsCount);
  }
  [[nodiscard]] const kernels::FlatMedium& view() const { return mView; }

private:
  static constexpr const char* kWhat = "the medium";

  kernels::FlatMedium mView;
  std::shared_ptr<const DeviceFlatMedium> mThere;
  DeviceArray<std::int32_t> mFieldSlots, mStepSlots, mOpticsSlots;
  DeviceArray<float> mIndexOffsets;
  DeviceArray<std::uint8_t> mBends;
  DeviceArray<kernels::FieldVoxel> mFields;
  DeviceArray<std::uint8_t> mSteps;
  DeviceArray<std::int32_t> mVoxelOptics;
  DeviceArray<kernels::Optics> mOptics;
};

// The part of the free memory that the light sums may take; the rest is for whoever else uses the device.
inline constexpr double kPoolPart = 0.8;

/// Light sums in device memory, and their copy on the host.
class DeviceLight {
public:
  DeviceLight(DeviceStream& s, const TracerSetup& setup, const RunContext& ctx)
      : mBrickDims(setup.medium.brickDims)
      , mBlockDims(blockDims(setup.medium.dims))
      , mSlots(s, setup.medium.brickCount(), kWhat)
      , mClaimed(s, 1, kWhat)
      , mTotals(s, kTotals, kWhat) {
    mCapacity = poolCapacity(s, setup.medium.brickCount(), ctx);
    mPool = DeviceArray<DeviceSum>(s, static_cast<std::int64_t>(mCapacity) * kSlotSums, kWhat);
    mSlots.fill(0xff); // kNoSlot
    mClaimed.fill(0);
    mTotals.fill(0);
    mPool.fill(0);
    mScale = setup.scale;
  }

  [[nodiscard]] DeviceSums view() const {
    return {mSlots.data(), mPool.data(), mCapacity, mClaimed.data(), mTotals.data(), static_cast<float>(mScale.deposit),
            mScale.tally};
  }

  /// Copies what was used to the host. `done` is an event of the stream.
  void download(const DeviceStream& s, DeviceEvent& done, const RunContext& ctx) {
    int claimed = 0;
    mClaimed.download(&claimed, 0, 1);
    done.record();
    done.wait();
    if (claimed > mCapacity)
      throw Error(ErrorKind::Device,
                  cudaName(s.ordinal()) + ": out of memory for " + kWhat + ", " + std::to_string(poolMiB()) +
                      " MiB are not enough; lower the resolution, raise --memory-limit or use --device cpu");
    const std::int64_t sums = static_cast<std::int64_t>(claimed) * kSlotSums;
    ctx.requireMemory(static_cast<std::uint64_t>(sums) * sizeof(DeviceSum), "photons: light from the GPU");
    mHostSlots.resize(static_cast<std::size_t>(mSlots.size()));
    mHostSums = std::make_unique_for_overwrite<DeviceSum[]>(static_cast<std::size_t>(sums));
    mSlots.download(mHostSlots.data(), 0, mSlots.size());
    mPool.download(mHostSums.get(), 0, sums);
    mTotals.download(mHostTotals.data(), 0, kTotals);
    done.record();
    done.wait();
  }

  [[nodiscard]] bool touched(std::int64_t block) const {
    bool any = false;
    forEachBrick(block, [&](const DeviceSum*, const kernels::Int3&) { any = true; });
    return any;
  }
  void addBlock(std::int64_t block, BlockSums& sums) const {
    forEachBrick(block, [&](const DeviceSum* brick, const kernels::Int3& corner) {
      forVoxelsInSums(corner, [&](int k, int voxel) {
        VoxelSums s;
        for (int c = 0; c < kSums; ++c) s[c] = static_cast<std::int64_t>(brick[k * kSums + c]);
        sums.add(voxel, s);
      });
    });
  }
  [[nodiscard]] PhotonTally tally() const {
    PhotonTally tally;
    for (int o = 0; o < kOutcomes; ++o)
      for (int c = 0; c < 3; ++c) tally.power[o][c] = static_cast<std::int64_t>(mHostTotals[3 * o + c]);
    for (int i = 0; i < kCounters; ++i) tally.counts[i] = static_cast<std::int64_t>(mHostTotals[3 * kOutcomes + i]);
    return tally;
  }

private:
  static constexpr const char* kWhat = "the light sums";
  static constexpr std::uint64_t kSlotBytes = kSlotSums * sizeof(DeviceSum);

  /// Slots for every brick, or as many as memory allows.
  static int poolCapacity(const DeviceStream& s, std::int64_t bricks, const RunContext& ctx) {
    const std::uint64_t limit = ctx.effectiveMemoryLimit(), used = s.usedBytes();
    const std::uint64_t bytes = std::min(static_cast<std::uint64_t>(kPoolPart * static_cast<double>(s.freeBytes())),
                                         limit > used ? limit - used : 0);
    const std::uint64_t slots = std::min<std::uint64_t>(static_cast<std::uint64_t>(bricks), bytes / kSlotBytes);
    return static_cast<int>(std::min<std::uint64_t>(slots, 0x7fffffff));
  }
  /// Calls visit(sums, first voxel relative to the block's) for the bricks in and around a block that have light.
  template <class Visit>
  void forEachBrick(std::int64_t block, const Visit& visit) const {
    if (mHostSlots.empty()) return;
    forBricksInSums(mBrickDims, blockCorner(mBlockDims, block), [&](std::int64_t brick, const kernels::Int3& corner) {
      if (const int slot = mHostSlots[brick]; slot >= 0)
        visit(mHostSums.get() + std::int64_t{slot} * kSlotSums, corner);
    });
  }
  [[nodiscard]] std::uint64_t poolMiB() const { return (kSlotBytes * static_cast<std::uint64_t>(mCapacity)) >> 20; }

  kernels::Int3 mBrickDims, mBlockDims;
  DeviceArray<int> mSlots, mClaimed;
  DeviceArray<DeviceSum> mTotals, mPool;
  int mCapacity = 0;
  FixedPoint mScale;
  std::vector<int> mHostSlots;
  std::unique_ptr<DeviceSum[]> mHostSums;
  std::array<DeviceSum, kTotals> mHostTotals{};
};

/// First bends of a raster's cells in device memory, for some of its rows.
class DeviceEntry {
public:
  /// Room for the raster; what is known of another one is forgotten.
  void prepare(DeviceStream& s, const kernels::EmissionFrame& frame) {
    if (mFrame && sameRays(*mFrame, frame)) return;
    mKnown = {};
    mFrame = frame;
    if (mCells.data() && mCells.size() >= frame.cells()) return;
    mCells = {}; // before the new one is asked for
    mCells = DeviceArray<float>(s, frame.cells(), "the light raster");
  }
  [[nodiscard]] float* data() const { return mCells.data(); }

  /// The rows have been written on the device.
  void know(RowRange rows) {
    const bool touches = rows.begin <= mKnown.end && mKnown.begin <= rows.end && mKnown.begin < mKnown.end;
    mKnown = touches ? RowRange{std::min(rows.begin, mKnown.begin), std::max(rows.end, mKnown.end)} : rows;
  }
  void download(RowRange rows, float* entry) const {
    mCells.download(entry + firstCell(rows), firstCell(rows), cellCount(rows));
  }
  /// Copies those of the rows that are not known yet.
  void fetch(RowRange rows, const float* entry) {
    const RowRange before{rows.begin, std::min(rows.end, std::max(rows.begin, mKnown.begin))};
    const RowRange after{std::max(rows.begin, std::min(rows.end, mKnown.end)), rows.end};
    if (mKnown.begin >= mKnown.end || before.end == rows.end || after.begin == rows.begin) {
      upload(rows, entry);
    } else {
      upload(before, entry);
      upload(after, entry);
    }
    know(rows);
  }

private:
  void upload(RowRange rows, const float* entry) {
    mCells.upload(entry + firstCell(rows), firstCell(rows), cellCount(rows));
  }
  [[nodiscard]] std::int64_t firstCell(RowRange rows) const { return std::int64_t{rows.begin} * mFrame->columns; }
  [[nodiscard]] std::int64_t cellCount(RowRange rows) const {
    return std::int64_t{rows.end - rows.begin} * mFrame->columns;
  }

  DeviceArray<float> mCells;
  std::optional<kernels::EmissionFrame> mFrame;
  RowRange mKnown;
};

} // namespace volcaustic
