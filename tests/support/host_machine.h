// This machine as one that builds a medium the way a device does (backends/medium_pipeline.h): the same bodies, one
// thread.
#pragma once

#include "kernels/bricks.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <numeric>
#include <vector>

namespace volcaustic::test {

class HostMachine {
public:
  /// What was not written shows.
  static constexpr int kGarbage = 0xcd;

  template <class T>
  class Array {
  public:
    Array() = default;
    Array(std::int64_t count, int byte)
        : mCount(std::max<std::int64_t>(count, 1)), mBytes(static_cast<std::size_t>(mCount) * sizeof(T)) {
      std::memset(mBytes.data(), byte, mBytes.size());
    }
    [[nodiscard]] T* data() const { return reinterpret_cast<T*>(const_cast<unsigned char*>(mBytes.data())); }
    [[nodiscard]] std::int64_t size() const { return mCount; }

  private:
    std::int64_t mCount = 0;
    std::vector<unsigned char> mBytes;
  };

  template <class T>
  Array<T> array(std::int64_t count, const char*) {
    return {count, kGarbage};
  }
  template <class T>
  Array<T> zeros(std::int64_t count, const char*) {
    return {count, 0};
  }
  template <class T>
  Array<T> ones(std::int64_t count, const char*) {
    return {count, 0xff};
  }
  template <class T>
  Array<T> copyOf(const T* host, std::int64_t count, const char* what) {
    Array<T> copy = array<T>(count, what);
    std::copy_n(host, count, copy.data());
    return copy;
  }

  template <class Body>
  void forEach(std::int64_t count, const Body& body) {
    for (std::int64_t i = 0; i < count; ++i) body(i);
  }
  template <class Body>
  void forEachBlock(std::int64_t count, const Body& body) {
    alignas(16) static unsigned char room[48 << 10]; // what a block has of shared memory
    using Shared = typename Body::Shared;
    static_assert(sizeof(Shared) <= sizeof room);
    kernels::SerialBlock block;
    for (std::int64_t i = 0; i < count; ++i) {
      std::memset(room, kGarbage, sizeof room);
      body(block, *reinterpret_cast<Shared*>(room), i);
    }
  }
  void sumUp(Array<std::uint32_t>& numbers) {
    std::exclusive_scan(numbers.data(), numbers.data() + numbers.size(), numbers.data(), std::uint32_t{0});
  }
  std::int64_t sortUnique(Array<std::uint64_t>& keys) {
    std::sort(keys.data(), keys.data() + keys.size());
    return std::unique(keys.data(), keys.data() + keys.size()) - keys.data();
  }
  template <class T>
  void fetch(const Array<T>& array, std::int64_t begin, std::int64_t count, T* host) {
    std::copy_n(array.data() + begin, count, host);
  }
  void wait() {}
};

} // namespace volcaustic::test
