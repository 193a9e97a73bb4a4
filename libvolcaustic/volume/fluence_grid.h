// The owner of a sparse volume of light.
#pragma once

#include "core/brick_grid.h"
#include "core/zeroed_table.h"
#include "kernels/fluence.h"
#include "volcaustic/run_context.h"

#include <atomic>
#include <span>
#include <vector>

namespace volcaustic {

/// kernels::FluenceField's arrays. Bricks are dark until they are given voxels or a constant.
class FluenceGrid {
public:
  FluenceGrid() = default;
  explicit FluenceGrid(const Vec3i& dims);

  [[nodiscard]] const Vec3i& dims() const { return mDims; }
  [[nodiscard]] const Vec3i& brickDims() const { return mBrickDims; }
  [[nodiscard]] std::int64_t brickCount() const { return static_cast<std::int64_t>(mEntries.size()); }
  [[nodiscard]] std::int64_t brickIndex(const Vec3i& brick) const {
    return (std::int64_t{brick[0]} * mBrickDims[1] + brick[1]) * mBrickDims[2] + brick[2];
  }
  [[nodiscard]] Vec3i brickCoord(std::int64_t brick) const;

  /// Room for this many bricks with voxels, or what the memory limit leaves; memory is taken when they are written.
  /// Once, before the first slot.
  void reserve(std::int64_t bricks, const RunContext& ctx);
  /// Slots for `count` bricks' voxels, the first of them. Safe from several threads. The voxels are not initialised.
  /// \throws Error(Input) beyond the room.
  [[nodiscard]] std::int32_t claim(std::int32_t count);
  [[nodiscard]] std::span<kernels::FluenceVoxel, kBrickVoxels> slot(std::int32_t slot) {
    return std::span<kernels::FluenceVoxel, kBrickVoxels>(mVoxels.get() + std::size_t(slot) * kBrickVoxels,
                                                          kBrickVoxels);
  }
  /// Gives a brick the voxels of a slot. Safe from several threads for different bricks.
  void assign(std::int64_t brick, std::int32_t slot) { mEntries[brick] = slot + 1; }
  void setConstant(std::int64_t brick, const kernels::Light& light) { setPacked(brick, kernels::pack(light)); }
  void setPacked(std::int64_t brick, const kernels::FluenceVoxel& value);

  [[nodiscard]] bool isDark(std::int64_t brick) const { return mEntries[brick] == 0; }
  /// Whether the brick is one value, dark or not.
  [[nodiscard]] bool isConstant(std::int64_t brick) const { return mEntries[brick] <= 0; }
  [[nodiscard]] kernels::FluenceField view() const;
  [[nodiscard]] std::uint64_t memoryBytes() const;

private:
  struct Free {
    void operator()(kernels::FluenceVoxel* p) const { freeLarge(p); }
  };
  Vec3i mDims{0, 0, 0}, mBrickDims{0, 0, 0};
  ZeroedTable<std::int32_t> mEntries;
  std::unique_ptr<kernels::FluenceVoxel[], Free> mVoxels;
  std::int64_t mCapacity = 0;
  std::atomic<std::int64_t> mClaimed{0};
  std::vector<kernels::FluenceVoxel> mConstants;
};

} // namespace volcaustic
