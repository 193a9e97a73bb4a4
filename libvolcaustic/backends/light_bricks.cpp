#include "backends/light_bricks.h"

#include "core/large_memory.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <string>

namespace volcaustic {

namespace {

// Chunks are as big as two huge pages: one page fault for 128 bricks instead of four for each.
constexpr std::size_t kChunkBricks = 256;
constexpr std::size_t kChunkBytes = kChunkBricks * sizeof(LightBricks::Brick);

} // namespace

LightBricks::LightBricks(std::int64_t brickCount, MemoryBudget& budget)
    : mBricks(static_cast<Brick**>(std::calloc(static_cast<std::size_t>(brickCount), sizeof(Brick*))))
    , mInLastChunk(kChunkBricks)
    , mBudget(&budget) {
  if (!mBricks) throw std::bad_alloc();
}

LightBricks::~LightBricks() {
  for (Brick* chunk : mChunks) freeLarge(chunk);
}

void LightBricks::allocate(std::int64_t brick) {
  if (mBudget->used.fetch_add(sizeof(Brick)) + sizeof(Brick) > mBudget->limit)
    throw Error(ErrorKind::Input, "photons: the light sums need more than the memory limit of " +
                                      std::to_string(mBudget->limit >> 20) +
                                      " MiB; lower the resolution or raise --memory-limit");
  if (mInLastChunk == kChunkBricks) {
    mChunks.push_back(static_cast<Brick*>(allocateLarge(kChunkBytes)));
    mInLastChunk = 0;
  }
  Brick* sums = mChunks.back() + mInLastChunk++;
  std::memset(static_cast<void*>(sums), 0, sizeof(Brick));
  mBricks[brick] = sums;
}

void LightBricks::carry(std::int64_t brick, std::int32_t offset) {
  VoxelSums& high = mCarried[brick * kernels::kStepVoxels + offset];
  std::int32_t(&low)[8] = (*mBricks[brick])[offset].s;
  for (int c = 0; c < 3; ++c) {
    high[c] += low[c];
    high[3 + c] += low[4 + c];
  }
  std::fill(std::begin(low), std::end(low), 0);
}

void LightBricks::add(std::int64_t brick, const BlockSums& sums, const kernels::Int3& corner) {
  forVoxelsInSums(corner, [&](int k, int voxel) {
    const VoxelSums v = sums.at(voxel);
    if (std::all_of(v.begin(), v.end(), [](std::int64_t s) { return s == 0; })) return;
    if (addWithinRange(touch(brick)[k].s, v)) return;
    VoxelSums& high = mCarried[brick * kernels::kStepVoxels + k];
    for (int c = 0; c < kSums; ++c) high[c] += v[c];
  });
}

void LightBricks::addTo(std::int64_t brick, BlockSums& sums, const kernels::Int3& corner) const {
  if (!mBricks[brick]) return;
  forVoxelsInSums(corner, [&](int k, int voxel) {
    const std::int32_t(&s)[8] = (*mBricks[brick])[k].s;
    VoxelSums all{s[0], s[1], s[2], s[4], s[5], s[6]};
    if (!mCarried.empty())
      if (const auto high = mCarried.find(brick * kernels::kStepVoxels + k); high != mCarried.end())
        for (int c = 0; c < kSums; ++c) all[c] += high->second[c];
    if (std::any_of(all.begin(), all.end(), [](std::int64_t v) { return v != 0; })) sums.add(voxel, all);
  });
}

} // namespace volcaustic
