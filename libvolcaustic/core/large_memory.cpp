#include "core/large_memory.h"

#include <cstdlib>
#include <sys/mman.h>

namespace volcaustic {

namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;

} // namespace

void* allocateLarge(std::size_t bytes) {
  const bool huge = bytes >= 2 * kHugePage;
  const std::size_t unit = huge ? kHugePage : 64;
  void* memory = std::aligned_alloc(unit, (bytes + unit - 1) / unit * unit);
  if (!memory) throw std::bad_alloc();
#if defined(MADV_HUGEPAGE)
  if (huge) (void)madvise(memory, bytes, MADV_HUGEPAGE); // a wish
#endif
  return memory;
}

void freeLarge(void* memory) noexcept { std::free(memory); }

} // namespace volcaustic
