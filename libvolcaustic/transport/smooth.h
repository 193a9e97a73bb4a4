// 3x3x3 Gaussian over sparse fields.
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/run_context.h"

namespace volcaustic {

/// The separable kernel (1, 2, 1)/4 along each axis; values beyond a face of the domain mirror those before it, so the
/// total stays what it was. Bricks of one value between neighbours of the same value stay as they are.
BrickGrid<Vec3f> smoothed(const BrickGrid<Vec3f>& field, const RunContext& ctx);

} // namespace volcaustic
