// Where photons leave their light on a CUDA device: 8x8x8 bricks from a pool, claimed on first touch.
//
//   slots[brick]      kNoSlot, kClaiming, kPoolSpent, or the brick's slot
//   pool[slot]        512 voxels x 6 sums, 64 bits each: 24 KiB
//   totals            PhotonTally: power by outcome and channel, then counts
//
// Sums are integers because their order is the scheduler's: the same input gives the same bits, and the sums of several
// devices add up exactly (docs/algorithms/cuda.md).
#pragma once

#include "backends/photon_tracer.h"

#include <cuda_runtime.h>

namespace volcaustic {

inline constexpr int kNoSlot = -1, kClaiming = -2, kPoolSpent = -3;
inline constexpr int kSlotSums = kernels::kStepVoxels * kSums;
inline constexpr int kOutcomes = static_cast<int>(kernels::Outcome::Count);
inline constexpr int kCounters = static_cast<int>(kernels::Counter::Count);
inline constexpr int kTotals = 3 * kOutcomes + kCounters;

using DeviceSum = unsigned long long; // two's complement: what atomicAdd takes

struct DeviceSums {
  int* slots = nullptr;
  DeviceSum* pool = nullptr;
  int capacity = 0;       ///< slots in the pool
  int* claimed = nullptr; ///< slots handed out; beyond `capacity` when the pool was too small
  DeviceSum* totals = nullptr;
  float depositScale = 1;
  double tallyScale = 1;
};

/// The brick's sums, claimed when nobody has yet; null when the pool is spent. One thread moves the entry from kNoSlot
/// to kClaiming, takes a slot and publishes it, without waiting for anybody; the others look again until it has. All of
/// that is inside one turn of the loop, so threads of one warp do not wait for each other across a branch. The pool is
/// zero from the start and its words are touched by atomics only: nothing but the slot's number has to become visible.
__device__ inline DeviceSum* sumsOf(const DeviceSums& sums, int brick) {
  int* entry = sums.slots + brick;
  while (true) {
    int slot = *static_cast<volatile int*>(entry);
    if (slot == kNoSlot && atomicCAS(entry, kNoSlot, kClaiming) == kNoSlot) {
      slot = atomicAdd(sums.claimed, 1);
      if (slot >= sums.capacity) slot = kPoolSpent;
      atomicExch(entry, slot);
    }
    if (slot >= 0) return sums.pool + static_cast<std::int64_t>(slot) * kSlotSums;
    if (slot == kPoolSpent) return nullptr;
  }
}

/// The sink of one thread. What it leaves in one voxel in a row is added up in registers: the last voxel of a step is
/// mostly the first one of the next.
class DeviceSink {
public:
  __device__ explicit DeviceSink(const DeviceSums& sums) : mSums(sums) {}

  __device__ void deposit(std::int32_t brick, std::int32_t offset, const kernels::Float3& powerLength,
                          const kernels::Float3& direction) {
    if (brick != mBrick || offset != mOffset) {
      flush();
      moveTo(brick, offset);
    }
    // As on the CPU: the scale is a power of two, so the product is exact and is rounded once.
    const float scale = mSums.depositScale;
    mVoxel[0] += llrintf(powerLength.x * scale);
    mVoxel[1] += llrintf(powerLength.y * scale);
    mVoxel[2] += llrintf(powerLength.z * scale);
    mVoxel[3] += llrintf(direction.x * scale);
    mVoxel[4] += llrintf(direction.y * scale);
    mVoxel[5] += llrintf(direction.z * scale);
  }
  __device__ void tally(kernels::Outcome outcome, const kernels::Double3& power) {
    long long* t = mTotals + 3 * static_cast<int>(outcome);
    t[0] += static_cast<long long>(power.x * mSums.tallyScale);
    t[1] += static_cast<long long>(power.y * mSums.tallyScale);
    t[2] += static_cast<long long>(power.z * mSums.tallyScale);
  }
  __device__ void count(kernels::Counter counter, std::int64_t n) {
    mTotals[3 * kOutcomes + static_cast<int>(counter)] += n;
  }

  /// Adds what is in registers to the voxel's sums. Call it when a body is done.
  __device__ void flush() {
    if (mPool) {
      DeviceSum* voxel = mPool + mOffset * kSums;
      for (int i = 0; i < kSums; ++i)
        if (mVoxel[i]) atomicAdd(voxel + i, static_cast<DeviceSum>(mVoxel[i]));
    }
    for (int i = 0; i < kSums; ++i) mVoxel[i] = 0;
  }

  /// Adds the totals of a whole block's threads to the pass's: every thread of the block must call it, once.
  __device__ void addTotals() {
    __shared__ DeviceSum block[kTotals];
    if (threadIdx.x < kTotals) block[threadIdx.x] = 0;
    __syncthreads();
    for (int i = 0; i < kTotals; ++i) {
      long long sum = mTotals[i];
      for (int lanes = 16; lanes > 0; lanes /= 2) sum += __shfl_down_sync(0xffffffffu, sum, lanes);
      if (threadIdx.x % 32 == 0) atomicAdd(block + i, static_cast<DeviceSum>(sum));
    }
    __syncthreads();
    if (threadIdx.x < kTotals) atomicAdd(mSums.totals + threadIdx.x, block[threadIdx.x]);
  }

private:
  __device__ void moveTo(std::int32_t brick, std::int32_t offset) {
    if (brick != mBrick) mPool = sumsOf(mSums, brick);
    mBrick = brick;
    mOffset = offset;
  }

  const DeviceSums mSums;
  DeviceSum* mPool = nullptr; ///< of mBrick
  std::int32_t mBrick = -1, mOffset = 0;
  long long mVoxel[kSums] = {};
  long long mTotals[kTotals] = {};
};

} // namespace volcaustic
