// Straight ways through many voxels, kept as chords and rasterised block by block when the sums are asked for.
#pragma once

#include "backends/lanes.h"
#include "core/large_memory.h"

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

  /// Whether there may be light in the block or in the voxels around it; after sort().
  [[nodiscard]] bool touched(std::int64_t block) const { return mFirst[block] < mFirst[block + 1]; }
  /// Adds that light.
  void addTo(std::int64_t block, float scale, BlockSums& sums) const;
  [[nodiscard]] std::uint64_t bytes() const;
  [[nodiscard]] std::int64_t blockCount() const { return static_cast<std::int64_t>(mFirst.size()) - 1; }
  void clear();

private:
  /// The chords of all tasks in one list.
  void collect(const RunContext& ctx);

  kernels::Int3 mDims, mBlockDims;
  const LaneSet& mLanes;
  std::deque<std::vector<FarChords>> mTasks;
  std::vector<FarChord, UninitialisedAllocator<FarChord>> mChords;
  std::vector<std::int64_t> mFirst;                                       // of each block in mIds, and the end
  std::vector<std::uint32_t, UninitialisedAllocator<std::uint32_t>> mIds; // chords, block by block
};

} // namespace volcaustic
