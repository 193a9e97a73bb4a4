#include "core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <mutex>

namespace volcaustic {

int threadCount(const RunContext& ctx) { return ctx.threads > 0 ? ctx.threads : tbb::info::default_concurrency(); }

RunContext shareOf(const RunContext& ctx, std::size_t i, std::size_t count) {
  RunContext share = ctx;
  if (ctx.onProgress)
    share.onProgress = [&ctx, i, count](std::string_view stage, double fraction) {
      ctx.onProgress(stage, (static_cast<double>(i) + fraction) / static_cast<double>(count));
    };
  return share;
}

void withThreads(const RunContext& ctx, const std::function<void()>& body) {
  tbb::task_arena arena(threadCount(ctx));
  arena.execute(body);
}

void parallelFor(std::int64_t count, std::int64_t grain, const RunContext& ctx,
                 const std::function<void(std::int64_t, std::int64_t, int)>& body, std::string_view stage) {
  if (count <= 0) return;
  grain = std::max<std::int64_t>(grain, 1);
  const std::int64_t pieces = (count + grain - 1) / grain;
  std::atomic<std::int64_t> done{0};
  std::mutex reporting;

  const auto piece = [&](std::int64_t p, int slot) {
    ctx.throwIfCancelled();
    body(p * grain, std::min(count, (p + 1) * grain), slot);
    const std::int64_t finished = done.fetch_add(1, std::memory_order_relaxed) + 1;
    if (stage.empty() || !ctx.onProgress) return;
    // A thread that finds another one reporting goes on: progress is a courtesy, not a barrier.
    if (const std::unique_lock lock(reporting, std::try_to_lock); lock)
      ctx.progress(stage, static_cast<double>(finished) / static_cast<double>(pieces));
  };

  tbb::task_arena arena(threadCount(ctx));
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::int64_t>(0, pieces, 1),
        [&](const tbb::blocked_range<std::int64_t>& range) {
          for (std::int64_t p = range.begin(); p != range.end(); ++p)
            piece(p, tbb::this_task_arena::current_thread_index());
        },
        tbb::simple_partitioner{});
  });
}

} // namespace volcaustic
