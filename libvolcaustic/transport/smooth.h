// 3x3x3 Gaussian over sparse fields.
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/run_context.h"

#include <span>

namespace volcaustic {

/// The separable kernel (1, 2, 1)/4 along each axis; values beyond a face of the domain mirror those before it, so the
/// total stays what it was. Bricks of one value between neighbours of the same value stay as they are.
BrickGrid<Vec3f> smoothed(const BrickGrid<Vec3f>& field, const RunContext& ctx);

/// The same for the given bricks only, in place.
void smoothSome(BrickGrid<Vec3f>& field, std::span<const std::int64_t> bricks, const RunContext& ctx);

} // namespace volcaustic
