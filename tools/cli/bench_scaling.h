// How time and memory grow with photons and with voxels: one glass ball, a process of its own for each case.
#pragma once

#include "report.h"

#include <volcaustic/run_context.h>

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace volcaustic::cli {

struct ScalingOptions {
  std::string device;
  int repeats = 3;
  std::int64_t maxPhotons = std::int64_t{1} << 26; ///< from 2^16 on, four times as many each time, at 256^3 voxels
  int maxVoxels = 1024; ///< along an axis, from 64 on, twice as many each time, at 2^20 photons
};

/// One object a sweep: its name, its cases as `bench --json` reports a frame, and where and why it stopped early. A
/// case that would need more memory than the limit ends its sweep; `say` is told so, and every case's figures. \throws
/// Error for anything else that goes wrong in a case.
Json measureScaling(const ScalingOptions& options, const RunContext& ctx,
                    const std::function<void(std::string_view line)>& say);

} // namespace volcaustic::cli
