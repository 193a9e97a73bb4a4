#include "volume/fluence_grid.h"

#include "volcaustic/error.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace volcaustic {

FluenceGrid::FluenceGrid(const Vec3i& dims)
    : mDims(dims)
    , mBrickDims{(dims[0] + 7) / 8, (dims[1] + 7) / 8, (dims[2] + 7) / 8}
    , mEntries(std::size_t(mBrickDims[0]) * mBrickDims[1] * mBrickDims[2]) {}

Vec3i FluenceGrid::brickCoord(std::int64_t brick) const {
  const std::int64_t rest = brick / mBrickDims[2];
  return {static_cast<int>(rest / mBrickDims[1]), static_cast<int>(rest % mBrickDims[1]),
          static_cast<int>(brick % mBrickDims[2])};
}

void FluenceGrid::reserve(std::int64_t bricks, const RunContext& ctx) {
  assert(!mVoxels);
  const std::uint64_t limit = ctx.effectiveMemoryLimit() / (kBrickVoxels * sizeof(kernels::FluenceVoxel));
  mCapacity = static_cast<std::int64_t>(std::min<std::uint64_t>(
      {static_cast<std::uint64_t>(bricks), limit, std::uint64_t{std::numeric_limits<std::int32_t>::max()}}));
  mVoxels.reset(static_cast<kernels::FluenceVoxel*>(
      allocateLarge(static_cast<std::size_t>(mCapacity) * kBrickVoxels * sizeof(kernels::FluenceVoxel))));
}

std::int32_t FluenceGrid::claim(std::int32_t count) {
  const std::int64_t first = mClaimed.fetch_add(count);
  if (first + count > mCapacity)
    throw Error(ErrorKind::Input,
                "light volume: needs more than the memory limit; lower the resolution or raise --memory-limit");
  return static_cast<std::int32_t>(first);
}

void FluenceGrid::setPacked(std::int64_t brick, const kernels::FluenceVoxel& value) {
  const auto same = [&](const kernels::FluenceVoxel& v) { return std::equal(v.words, v.words + 4, value.words); };
  if (same({})) {
    mEntries[brick] = 0;
    return;
  }
  if (mConstants.empty() || !same(mConstants.back())) mConstants.push_back(value);
  mEntries[brick] = ~static_cast<std::int32_t>(mConstants.size() - 1);
}

kernels::FluenceField FluenceGrid::view() const {
  return {{mDims[0], mDims[1], mDims[2]},
          {mBrickDims[0], mBrickDims[1], mBrickDims[2]},
          mEntries.data(),
          mVoxels.get(),
          mConstants.data()};
}

std::uint64_t FluenceGrid::memoryBytes() const {
  return (static_cast<std::uint64_t>(mClaimed) * kBrickVoxels + mConstants.size()) * sizeof(kernels::FluenceVoxel);
}

} // namespace volcaustic
