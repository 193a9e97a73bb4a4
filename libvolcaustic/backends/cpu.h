// launch on the CPU: the bodies of kernels/ over oneTBB.
#pragma once

#include "core/parallel.h"

#include <span>
#include <string_view>

namespace volcaustic {

/// Calls body(i, sinks[slot]) for every i in [0, count). There must be threadCount(ctx) sinks; each is used by one
/// thread at a time.
template <class Body, class Sink>
void launchCpu(std::int64_t count, std::int64_t grain, const RunContext& ctx, std::string_view stage, const Body& body,
               std::span<Sink> sinks) {
  parallelFor(
      count, grain, ctx,
      [&](std::int64_t begin, std::int64_t end, int slot) {
        for (std::int64_t i = begin; i < end; ++i) body(i, sinks[slot]);
      },
      stage);
}

} // namespace volcaustic
