// Bricks made by several threads at once, put into a BrickGrid in an order that does not depend on them.
#pragma once

#include "core/brick_grid.h"
#include "core/parallel.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <string_view>
#include <utility>
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

  /// Activates and fills the bricks in `grid` with value(x) of what they hold here, and forgets them.
  /// \throws Error(Input), naming `what`, when they do not fit the memory limit.
  template <class Value, class Of = std::identity>
  void moveInto(BrickGrid<Value>& grid, std::string_view what, const RunContext& ctx, Of value = {}) {
    std::vector<std::pair<std::int64_t, const Entry*>> entries;
    for (const auto& slot : mSlots)
      for (const Entry& entry : slot) entries.emplace_back(entry.brick, &entry);
    ctx.requireMemory(grid.memoryBytes() + entries.size() * (sizeof(Entry) + kBrickVoxels * sizeof(Value)), what);
    std::sort(entries.begin(), entries.end()); // a brick comes once
    std::vector<std::int64_t> bricks(entries.size());
    std::transform(entries.begin(), entries.end(), bricks.begin(), [](const auto& e) { return e.first; });
    grid.activate(bricks, Fill::Later);
    parallelFor(static_cast<std::int64_t>(entries.size()), 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) {
        const auto& [brick, entry] = entries[i];
        std::transform(entry->voxels.begin(), entry->voxels.end(), grid.voxels(brick).begin(), value);
      }
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
