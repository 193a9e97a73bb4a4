#include "core/large_memory.h"

#include <algorithm>
#include <cstdlib>
#include <sys/mman.h>

namespace volcaustic {

namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;
/// Zeros from here on are mapped: a heap that was used before would have to write them.
constexpr std::size_t kMapped = std::size_t{1} << 20;

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

void* allocateZeroed(std::size_t bytes) {
  if (bytes < kMapped) {
    if (void* memory = std::calloc(std::max<std::size_t>(bytes, 1), 1)) return memory;
    throw std::bad_alloc();
  }
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
#if defined(MADV_NOHUGEPAGE)
  (void)madvise(memory, bytes, MADV_NOHUGEPAGE); // a write here and there must not cost two megabytes each
#endif
  return memory;
}

void freeZeroed(void* memory, std::size_t bytes) noexcept {
  if (bytes < kMapped)
    std::free(memory);
  else
    (void)munmap(memory, bytes);
}

} // namespace volcaustic
