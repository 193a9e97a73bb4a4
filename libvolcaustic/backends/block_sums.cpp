#include "backends/block_sums.h"

#include <algorithm>
#include <cstring>
#include <new>

namespace volcaustic {

namespace {

constexpr std::size_t kBytes = std::size_t{kSumsVoxels} * 8 * sizeof(std::int32_t);
constexpr std::int32_t kHalfRange = 1 << 29;

} // namespace

bool addWithinRange(std::int32_t* low, const VoxelSums& sums) {
  const auto fits = [](std::int64_t s) { return s >= -kHalfRange && s < kHalfRange; };
  for (int c = 0; c < 3; ++c)
    if (!fits(low[c] + sums[c]) || !fits(low[4 + c] + sums[3 + c])) return false;
  for (int c = 0; c < 3; ++c) {
    low[c] += static_cast<std::int32_t>(sums[c]);
    low[4 + c] += static_cast<std::int32_t>(sums[3 + c]);
  }
  return true;
}

BlockSums::BlockSums() : mLow(static_cast<std::int32_t*>(std::aligned_alloc(64, (kBytes + 63) / 64 * 64))) {
  if (!mLow) throw std::bad_alloc();
}

void BlockSums::clear() {
  std::memset(mLow.get(), 0, kBytes);
  mHigh.clear();
}

void BlockSums::carry() {
  for (int v = 0; v < kSumsVoxels; ++v) {
    const std::int32_t* s = &mLow[std::size_t(v) * 8];
    std::uint32_t beyond = 0;
    for (int c = 0; c < 8; ++c) beyond |= static_cast<std::uint32_t>(s[c]) + kHalfRange;
    if (beyond & 0xc0000000u) carry(v); // a sum outside [-2^29, 2^29)
  }
}

void BlockSums::carry(int voxel) {
  std::int32_t* low = &mLow[std::size_t(voxel) * 8];
  VoxelSums& high = mHigh[voxel];
  for (int c = 0; c < 3; ++c) {
    high[c] += low[c];
    high[3 + c] += low[4 + c];
  }
  std::fill_n(low, 8, 0);
}

void BlockSums::add(int voxel, const VoxelSums& sums) {
  if (addWithinRange(&mLow[std::size_t(voxel) * 8], sums)) return;
  VoxelSums& high = mHigh[voxel];
  for (int c = 0; c < kSums; ++c) high[c] += sums[c];
}

std::vector<kernels::CarriedSums> BlockSums::carried() const {
  std::vector<kernels::CarriedSums> all;
  all.reserve(mHigh.size());
  for (const auto& [voxel, high] : mHigh) {
    kernels::CarriedSums c{voxel, {}};
    for (int i = 0; i < 3; ++i) {
      c.sums[i] = static_cast<float>(high[i]);
      c.sums[4 + i] = static_cast<float>(high[3 + i]);
    }
    all.push_back(c);
  }
  return all;
}

VoxelSums BlockSums::at(int voxel) const {
  const std::int32_t* s = &mLow[std::size_t(voxel) * 8];
  VoxelSums sums{s[0], s[1], s[2], s[4], s[5], s[6]};
  if (mHigh.empty()) return sums;
  if (const auto high = mHigh.find(voxel); high != mHigh.end())
    for (int c = 0; c < kSums; ++c) sums[c] += high->second[c];
  return sums;
}

} // namespace volcaustic
