// The camera pass on this machine's cores.
#pragma once

#include "backends/lanes.h"
#include "volcaustic/run_context.h"

namespace volcaustic {

/// Writes every pixel of the scene's camera. Progress is told as the stage "view".
ViewCounts viewOnCpu(const kernels::ViewScene& scene, const kernels::PixelPlanes& planes, const LaneSet& lanes,
                     const RunContext& ctx);

} // namespace volcaustic
