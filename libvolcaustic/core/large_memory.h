// Memory for big arrays, in huge pages where the system has them: a page fault for two megabytes instead of for every
// four kilobytes, taken by the thread that writes there first.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace volcaustic {

/// Aligned to 64 bytes at least, not initialised. \throws std::bad_alloc.
void* allocateLarge(std::size_t bytes);
void freeLarge(void* memory) noexcept;

/// Zeros. Big ones come from the system in small pages, each of which costs memory only once it is written to; reading
/// it before that is free. \throws std::bad_alloc.
void* allocateZeroed(std::size_t bytes);
void freeZeroed(void* memory, std::size_t bytes) noexcept;

/// For containers whose elements are written later: leaves new ones as they are.
template <class T>
struct UninitialisedAllocator {
  using value_type = T;

  UninitialisedAllocator() = default;
  template <class U>
  UninitialisedAllocator(const UninitialisedAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(allocateLarge(n * sizeof(T))); }
  void deallocate(T* p, std::size_t) noexcept { freeLarge(p); }
  template <class U>
  void construct(U* p) {
    ::new (static_cast<void*>(p)) U;
  }
  template <class U, class... Args>
  void construct(U* p, Args&&... args) {
    ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
  }
  friend bool operator==(const UninitialisedAllocator&, const UninitialisedAllocator&) { return true; }
};

/// A vector whose resize leaves new elements of built-in types as they are.
template <class T>
using LargeVector = std::vector<T, UninitialisedAllocator<T>>;

} // namespace volcaustic
