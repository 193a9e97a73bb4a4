// Loops over oneTBB that honour a RunContext: thread count, cancellation, progress. The only folder of the library
// that names TBB.
#pragma once

#include "volcaustic/run_context.h"

#include <cstdint>
#include <functional>
#include <string_view>

namespace volcaustic {

/// Threads that `ctx` asks for: its own number, or all that the machine offers.
int threadCount(const RunContext& ctx);

/// Calls body(begin, end, slot) over [0, count) in pieces of at most `grain`. `slot` is in [0, threadCount(ctx)) and
/// never in use by two calls at once, so it can index private storage. The pieces are the same whatever the number of
/// threads; their order is not. Exceptions travel to the caller; between pieces the loop stops when cancelled.
void parallelFor(std::int64_t count, std::int64_t grain, const RunContext& ctx,
                 const std::function<void(std::int64_t begin, std::int64_t end, int slot)>& body,
                 std::string_view stage = {});

/// For part `i` of `count` like ones of a stage: its progress is that much of the stage's. `ctx` must outlive it.
RunContext shareOf(const RunContext& ctx, std::size_t i, std::size_t count);

/// Runs one function inside an arena of threadCount(ctx) threads, so that libraries which use TBB on their own
/// (OpenVDB) keep to it.
void withThreads(const RunContext& ctx, const std::function<void()>& body);

} // namespace volcaustic
