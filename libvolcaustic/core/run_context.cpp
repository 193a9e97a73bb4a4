#include "volcaustic/run_context.h"

#include "volcaustic/error.h"

#include <string>
#include <unistd.h>

namespace volcaustic {

void RunContext::throwIfCancelled() const {
  if (cancel && cancel->load(std::memory_order_relaxed)) throw Error(ErrorKind::Cancelled, "interrupted");
}

void RunContext::progress(std::string_view stage, double fraction) const {
  throwIfCancelled();
  if (onProgress) onProgress(stage, fraction);
}

void RunContext::log(LogLevel level, std::string_view line) const {
  if (onLog) onLog(level, line);
}

std::uint64_t RunContext::effectiveMemoryLimit() const {
  if (memoryLimit) return memoryLimit;
  const long pages = sysconf(_SC_PHYS_PAGES), pageSize = sysconf(_SC_PAGE_SIZE);
  if (pages <= 0 || pageSize <= 0) return std::uint64_t{4} << 30;
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(pageSize) / 4 * 3;
}

void RunContext::requireMemory(std::uint64_t bytes, std::string_view what) const {
  const std::uint64_t limit = effectiveMemoryLimit();
  if (bytes <= limit) return;
  constexpr std::uint64_t kMiB = 1 << 20;
  throw Error(ErrorKind::Input, std::string(what) + ": needs about " + std::to_string(bytes / kMiB) +
                                    " MiB, more than the memory limit of " + std::to_string(limit / kMiB) +
                                    " MiB; lower the resolution or raise --memory-limit");
}

} // namespace volcaustic
