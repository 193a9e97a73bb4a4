// Sums and sorted lists in device memory.
#pragma once

#include "backends/cuda_memory.cuh"

#include <cstdint>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <cub/device/device_select.cuh>

namespace volcaustic {

/// Runs call(room, bytes), a function of CUB: it says first how much room it wants.
template <class Call>
void withRoom(DeviceStream& stream, const char* what, const Call& call) {
  std::size_t bytes = 0;
  check(call(static_cast<void*>(nullptr), bytes), stream.ordinal(), what);
  const DeviceArray<std::uint8_t> room(stream, static_cast<std::int64_t>(bytes), what);
  check(call(static_cast<void*>(room.data()), bytes), stream.ordinal(), what);
}

/// Each number becomes the sum of those before it.
template <class T>
void sumUp(DeviceStream& stream, DeviceArray<T>& numbers, const char* what) {
  withRoom(stream, what, [&](void* room, std::size_t& bytes) {
    return cub::DeviceScan::ExclusiveSum(room, bytes, numbers.data(), numbers.data(), numbers.size(), stream.get());
  });
}

template <class T>
void sortKeys(DeviceStream& stream, const DeviceArray<T>& keys, DeviceArray<T>& sorted, std::int64_t count,
              const char* what) {
  withRoom(stream, what, [&](void* room, std::size_t& bytes) {
    return cub::DeviceRadixSort::SortKeys(room, bytes, static_cast<const T*>(keys.data()), sorted.data(), count, 0,
                                          8 * static_cast<int>(sizeof(T)), stream.get());
  });
}

/// Of sorted keys, each once; writes how many there are.
template <class T>
void uniqueKeys(DeviceStream& stream, const DeviceArray<T>& sorted, DeviceArray<T>& unique, std::int64_t count,
                DeviceArray<std::int64_t>& left, const char* what) {
  withRoom(stream, what, [&](void* room, std::size_t& bytes) {
    return cub::DeviceSelect::Unique(room, bytes, static_cast<const T*>(sorted.data()), unique.data(), left.data(),
                                     count, stream.get());
  });
}

} // namespace volcaustic
