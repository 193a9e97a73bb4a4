#include "transport/reach.h"

#include "core/parallel.h"
#include "transport/footprint.h"

#include <algorithm>
#include <atomic>

namespace volcaustic {

namespace {

using kernels::Double3;
using kernels::Int3;

constexpr double kSlack = 1e-3; // voxels; rounding must not hide a brick from a ray that grazes it

/// Brings *bound to `value` where that is lower. Which thread comes first makes no difference.
void lower(float& bound, float value) {
  const std::atomic_ref<float> shared(bound);
  float old = shared.load(std::memory_order_relaxed);
  while (value < old && !shared.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
  }
}
void raise(float& bound, float value) {
  const std::atomic_ref<float> shared(bound);
  float old = shared.load(std::memory_order_relaxed);
  while (value > old && !shared.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
  }
}

class ReachFinder {
public:
  ReachFinder(const FlatMediumStorage& flat, const kernels::EmissionFrame& frame, ReachMap& map)
      : mBends(flat.bends), mCount(flat.brickDims), mFrame(frame), mMap(map), mLight(brickOf(frame.origin)) {}

  /// Marks the bricks [begin, end).
  void mark(std::int64_t begin, std::int64_t end) {
    mBends.forEachNonZero(static_cast<std::size_t>(begin), static_cast<std::size_t>(end),
                          [this](std::size_t brick) { markBrick(static_cast<std::int64_t>(brick)); });
  }

private:
  static Int3 brickOf(const Double3& p) {
    const auto axis = [](double v) { return static_cast<std::int32_t>(std::floor(std::clamp(v, -1e9, 1e9) / 8)); };
    return {axis(p.x), axis(p.y), axis(p.z)};
  }
  void markBrick(std::int64_t brick) {
    const auto z = static_cast<std::int32_t>(brick % mCount.z),
               y = static_cast<std::int32_t>(brick / mCount.z % mCount.y),
               x = static_cast<std::int32_t>(brick / mCount.z / mCount.y);
    if (enclosed(brick, {x, y, z})) return;
    mark(footprint(mFrame, Double3(8 * x - kSlack, 8 * y - kSlack, 8 * z - kSlack), 8 + 2 * kSlack));
  }

  /// Whether every ray that meets the brick has to pass others with bends before and behind it, so that they alone
  /// bound where it bends.
  [[nodiscard]] bool enclosed(std::int64_t brick, const Int3& at) const {
    if (at.x == 0 || at.y == 0 || at.z == 0 || at.x == mCount.x - 1 || at.y == mCount.y - 1 || at.z == mCount.z - 1)
      return false;
    const std::int64_t x = std::int64_t{mCount.y} * mCount.z, y = mCount.z;
    if (!(mBends[brick - 1] && mBends[brick + 1] && mBends[brick - y] && mBends[brick + y] && mBends[brick - x] &&
          mBends[brick + x]))
      return false;
    // Not where a light in it, or on its face, starts.
    const auto beside = [](std::int32_t a, std::int32_t b) { return std::abs(a - b) <= 1; };
    return !(mFrame.point && beside(at.x, mLight.x) && beside(at.y, mLight.y) && beside(at.z, mLight.z));
  }

  void mark(const Footprint& f) {
    constexpr int kTile = kernels::kReachTile;
    if (f.empty()) return;
    const auto nearest = static_cast<float>(f.nearest - kSlack), farthest = static_cast<float>(f.farthest + kSlack);
    for (int y = f.v0 / kTile; y <= (f.v1 - 1) / kTile; ++y)
      for (int x = f.u0 / kTile; x <= (f.u1 - 1) / kTile; ++x) {
        const std::size_t tile = std::size_t(y) * mMap.columns + x;
        lower(mMap.nearest[tile], nearest);
        raise(mMap.farthest[tile], farthest);
      }
  }

  const ZeroedTable<std::uint8_t>& mBends;
  const Int3 mCount; ///< bricks
  const kernels::EmissionFrame& mFrame;
  ReachMap& mMap;
  const Int3 mLight; ///< brick that holds a point light
};

} // namespace

ReachMap reachOf(const FlatMediumStorage& flat, const kernels::EmissionFrame& frame, const RunContext& ctx) {
  const auto tiles = [](int cells) { return (cells + kernels::kReachTile - 1) / kernels::kReachTile; };
  ReachMap map{tiles(frame.columns), tiles(frame.rows), {}, {}};
  map.nearest.assign(std::size_t(map.columns) * map.rows, kernels::kNeverBends);
  map.farthest.assign(map.nearest.size(), -kernels::kNeverBends);
  constexpr std::int64_t kBricksAtOnce = 4096;
  ReachFinder finder(flat, frame, map);
  parallelFor(static_cast<std::int64_t>(flat.bends.size()), kBricksAtOnce, ctx,
              [&](std::int64_t begin, std::int64_t end, int) { finder.mark(begin, end); });
  return map;
}

} // namespace volcaustic
