// The tables of `volcaustic bench` for people, on stdout.
#pragma once

#include "bench_frames.h"
#include "bench_limits.h"

#include <span>
#include <string>

namespace volcaustic::cli {

/// One device's frames, a pair of columns for each scene: the paper's figures and these.
void printFrames(const std::string& device, std::span<const FrameFigures> frames);

void printLimits(const MachineLimits& limits, int threads);

} // namespace volcaustic::cli
