// A CUDA device as a machine that builds a medium (backends/medium_pipeline.h).
#pragma once

#include "backends/cuda_scans.cuh"

#include <algorithm>
#include <string>

namespace volcaustic {

/// A block of threads as kernels/bricks.h has it.
struct CudaBlock {
  template <class Body>
  __device__ void forEach(int count, const Body& body) {
    for (int i = static_cast<int>(threadIdx.x); i < count; i += static_cast<int>(blockDim.x)) body(i);
    __syncthreads();
  }
  template <class Predicate>
  __device__ bool any(int count, const Predicate& predicate) {
    bool found = false;
    for (int i = static_cast<int>(threadIdx.x); i < count && !found; i += static_cast<int>(blockDim.x))
      found = predicate(i);
    return __syncthreads_or(found) != 0;
  }
};

template <class Body>
__global__ void runElements(Body body, std::int64_t count) {
  const std::int64_t i = blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (i < count) body(i);
}
template <class Body>
__global__ void __launch_bounds__(256) runBlocks(Body body) {
  using Shared = typename Body::Shared;
  __shared__ alignas(16) unsigned char room[sizeof(Shared)]; // a Shared has members that would want to be initialised
  CudaBlock block;
  body(block, *reinterpret_cast<Shared*>(room), blockIdx.x);
}

/// Everything is done in the order of one stream. Use it under a DeviceScope.
class CudaMachine {
public:
  template <class T>
  using Array = DeviceArray<T>;

  /// Arrays take no more than `limit` bytes together.
  CudaMachine(int ordinal, std::uint64_t limit) : mStream(ordinal, "the medium"), mDone(mStream), mLimit(limit) {}

  [[nodiscard]] DeviceStream& stream() { return mStream; }

  template <class T>
  Array<T> array(std::int64_t count, const char* what) {
    if (mStream.usedBytes() + static_cast<std::uint64_t>(count) * sizeof(T) > mLimit)
      throw Error(ErrorKind::Device, cudaName(mStream.ordinal()) + ": --memory-limit leaves no room for " + what +
                                         "; lower the resolution, raise the limit or use --device cpu");
    return Array<T>(mStream, count, what);
  }
  template <class T>
  Array<T> zeros(std::int64_t count, const char* what) {
    return filled<T>(count, 0, what);
  }
  template <class T>
  Array<T> ones(std::int64_t count, const char* what) {
    return filled<T>(count, 0xff, what);
  }
  template <class T>
  Array<T> copyOf(const T* host, std::int64_t count, const char* what) {
    Array<T> copy = array<T>(count, what);
    copy.upload(host, 0, count);
    return copy;
  }

  template <class Body>
  void forEach(std::int64_t count, const Body& body) {
    if (count > 0) launchKernel(mStream, runElements<Body>, (count + kThreads - 1) / kThreads, kThreads, body, count);
  }
  template <class Body>
  void forEachBlock(std::int64_t count, const Body& body) {
    if (count > 0) launchKernel(mStream, runBlocks<Body>, count, kThreads, body);
  }
  void sumUp(Array<std::uint32_t>& numbers) { volcaustic::sumUp(mStream, numbers, mStream.what()); }
  std::int64_t sortUnique(Array<std::uint64_t>& keys) {
    Array<std::uint64_t> sorted = array<std::uint64_t>(keys.size(), mStream.what());
    Array<std::int64_t> left = array<std::int64_t>(1, mStream.what());
    sortKeys(mStream, keys, sorted, keys.size(), mStream.what());
    uniqueKeys(mStream, sorted, keys, keys.size(), left, mStream.what());
    std::int64_t count = 0;
    fetch(left, 0, 1, &count);
    wait();
    return count;
  }
  template <class T>
  void fetch(const Array<T>& array, std::int64_t begin, std::int64_t count, T* host) {
    array.download(host, begin, count);
  }
  void wait() {
    mDone.record();
    mDone.wait();
  }

private:
  static constexpr int kThreads = 256;

  template <class T>
  Array<T> filled(std::int64_t count, int byte, const char* what) {
    Array<T> result = array<T>(count, what);
    result.fill(byte);
    return result;
  }

  DeviceStream mStream;
  DeviceEvent mDone;
  std::uint64_t mLimit;
};

} // namespace volcaustic
