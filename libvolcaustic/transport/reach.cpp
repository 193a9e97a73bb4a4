#include "transport/reach.h"

#include "transport/footprint.h"

#include <algorithm>

namespace volcaustic {

namespace {

constexpr double kSlack = 1e-3; // voxels; rounding must not hide a brick from a ray that grazes it

void mark(ReachMap& map, const Footprint& f) {
  constexpr int kTile = kernels::kReachTile;
  if (f.empty()) return;
  for (int y = f.v0 / kTile; y <= (f.v1 - 1) / kTile; ++y)
    for (int x = f.u0 / kTile; x <= (f.u1 - 1) / kTile; ++x) {
      const std::size_t tile = std::size_t(y) * map.columns + x;
      map.nearest[tile] = std::min(map.nearest[tile], static_cast<float>(f.nearest - kSlack));
      map.farthest[tile] = std::max(map.farthest[tile], static_cast<float>(f.farthest + kSlack));
    }
}

} // namespace

ReachMap reachOf(const FlatMediumStorage& flat, const kernels::EmissionFrame& frame) {
  const auto tiles = [](int cells) { return (cells + kernels::kReachTile - 1) / kernels::kReachTile; };
  ReachMap map{tiles(frame.columns), tiles(frame.rows), {}, {}};
  map.nearest.assign(std::size_t(map.columns) * map.rows, kernels::kNeverBends);
  map.farthest.assign(map.nearest.size(), -kernels::kNeverBends);
  std::int64_t brick = 0;
  for (int x = 0; x < flat.brickDims.x; ++x)
    for (int y = 0; y < flat.brickDims.y; ++y)
      for (int z = 0; z < flat.brickDims.z; ++z, ++brick)
        if (flat.bends[brick])
          mark(map, footprint(frame, kernels::Double3(8 * x - kSlack, 8 * y - kSlack, 8 * z - kSlack), 8 + 2 * kSlack));
  return map;
}

} // namespace volcaustic
