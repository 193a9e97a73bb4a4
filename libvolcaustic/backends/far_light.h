// Straight ways through many voxels, kept as chords and rasterised block by block when the sums are asked for.
#pragma once

#include "backends/lanes.h"

#include <deque>

namespace volcaustic {

class FarLight {
public:
  FarLight(const kernels::Int3& dims, const LaneSet& lanes);

  /// Room for the chords of `count` tasks, in an order that does not depend on who runs them. Valid until the next
  /// call.
  [[nodiscard]] std::span<FarChords> newTasks(std::int64_t count);
  /// Chords of the tasks that are not sorted yet.
  [[nodiscard]] std::size_t waiting() const;
  /// Sorts all chords by block. \throws Error(Input) beyond the memory limit.
  void sort(const RunContext& ctx);

  [[nodiscard]] bool touched(std::int64_t block) const { return mFirst[block] < mFirst[block + 1]; }
  /// Adds the light inside the block; returns the voxels crossed. After sort().
  std::int64_t addTo(std::int64_t block, float scale, BlockSums& sums) const;
  [[nodiscard]] std::uint64_t bytes() const;
  [[nodiscard]] std::int64_t blockCount() const { return static_cast<std::int64_t>(mFirst.size()) - 1; }
  void clear();

private:
  kernels::Int3 mBlockDims;
  const LaneSet& mLanes;
  std::deque<std::vector<FarChords>> mTasks;
  std::vector<FarChord> mChords;
  std::vector<std::int64_t> mFirst; // of each block in mIds, and the end
  std::vector<std::uint32_t> mIds;  // chords, block by block
};

} // namespace volcaustic
