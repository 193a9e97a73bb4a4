// Memory that this process really holds.
#pragma once

#include <cstdint>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__)
#define VOLCAUSTIC_NEED_TRUE_MEMORY GTEST_SKIP() << "the address sanitizer keeps memory of its own"
#else
#define VOLCAUSTIC_NEED_TRUE_MEMORY static_cast<void>(0)
#endif

namespace volcaustic::test {

inline std::int64_t residentBytes() {
  std::ifstream file("/proc/self/statm");
  std::int64_t size = 0, resident = 0;
  file >> size >> resident;
  return resident * sysconf(_SC_PAGE_SIZE);
}

/// The most it ever held.
inline std::int64_t peakResidentBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

} // namespace volcaustic::test
