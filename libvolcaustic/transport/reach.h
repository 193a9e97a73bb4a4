// Where the rays of a raster can meet a bend at all: found once for each raster, so that most rays need not look.
#pragma once

#include "kernels/emission.h"
#include "volcaustic/run_context.h"
#include "volume/flatten.h"

#include <vector>

namespace volcaustic {

/// Owns what kernels::RasterReach points at.
struct ReachMap {
  std::int32_t columns = 0, rows = 0;
  std::vector<float> nearest, farthest;

  [[nodiscard]] kernels::RasterReach view() const { return {columns, rows, nearest.data(), farthest.data()}; }
};

/// Marks the tiles of the raster that bricks with bends stand in, and how far away these are.
ReachMap reachOf(const FlatMediumStorage& flat, const kernels::EmissionFrame& frame, const RunContext& ctx = {});

} // namespace volcaustic
