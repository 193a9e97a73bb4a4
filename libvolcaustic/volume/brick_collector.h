// Bricks made by several threads at once, put into a BrickGrid in an order that does not depend on them.
#pragma once

#include "core/brick_grid.h"
#include "core/parallel.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <string_view>
#include <vector>

namespace volcaustic {

template <class T>
class BrickCollector {
public:
  explicit BrickCollector(const RunContext& ctx) : mSlots(threadCount(ctx)) {}

  /// 512 values to fill for a brick that varies. Safe from several threads, each with its own slot (see parallelFor).
  std::span<T, kBrickVoxels> add(int slot, std::int64_t brick) {
    mSlots[slot].push_back({brick, {}});
    return mSlots[slot].back().voxels;
  }

  /// Activates and fills the bricks in `grid`, and forgets them.
  /// \throws Error(Input), naming `what`, when they do not fit the memory limit.
  void moveInto(BrickGrid<T>& grid, std::string_view what, const RunContext& ctx) {
    std::vector<const Entry*> entries;
    for (const auto& slot : mSlots)
      for (const Entry& entry : slot) entries.push_back(&entry);
    ctx.requireMemory(grid.memoryBytes() + 2 * entries.size() * sizeof(Entry), what);
    std::sort(entries.begin(), entries.end(), [](const Entry* a, const Entry* b) { return a->brick < b->brick; });
    std::vector<std::int64_t> bricks(entries.size());
    std::transform(entries.begin(), entries.end(), bricks.begin(), [](const Entry* e) { return e->brick; });
    grid.activate(bricks);
    parallelFor(static_cast<std::int64_t>(entries.size()), 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i)
        std::copy(entries[i]->voxels.begin(), entries[i]->voxels.end(), grid.voxels(entries[i]->brick).begin());
    });
    mSlots.assign(mSlots.size(), {});
  }

private:
  struct Entry {
    std::int64_t brick;
    std::array<T, kBrickVoxels> voxels;
  };
  std::vector<std::deque<Entry>> mSlots; // a deque never moves what it holds
};

} // namespace volcaustic
