// Streams, events and memory of a CUDA device as objects, and its errors as exceptions. Included by .cu files only.
#pragma once

#include "volcaustic/error.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cuda_runtime.h>
#include <string>

namespace volcaustic {

inline std::string cudaName(int ordinal) { return "cuda:" + std::to_string(ordinal); }

/// \throws Error(Device) "cuda:0: what: ..." for anything but success. The runtime's last error is taken, so that the
/// next call starts clean.
inline void check(cudaError_t error, int ordinal, const char* what) {
  if (error == cudaSuccess) return;
  (void)cudaGetLastError();
  throw Error(ErrorKind::Device, cudaName(ordinal) + ": " + what + ": " + cudaGetErrorString(error) + " (" +
                                     cudaGetErrorName(error) + "); try --device cpu");
}

/// Makes a device current on this thread, and the one from before again at the end.
class DeviceScope {
public:
  explicit DeviceScope(int ordinal) : mOrdinal(ordinal) {
    check(cudaGetDevice(&mBefore), ordinal, "cannot be reached");
    check(cudaSetDevice(ordinal), ordinal, "cannot be used");
  }
  ~DeviceScope() {
    if (mBefore != mOrdinal) (void)cudaSetDevice(mBefore);
  }
  DeviceScope(const DeviceScope&) = delete;
  DeviceScope& operator=(const DeviceScope&) = delete;

private:
  const int mOrdinal;
  int mBefore = 0;
};

/// A stream of its own, that does not wait for the default stream, and the count of what was allocated in it. `what`
/// names its work in errors. Use it (and destroy it) under a DeviceScope.
class DeviceStream {
public:
  DeviceStream(int ordinal, const char* what) : mOrdinal(ordinal), mWhat(what) {
    int pools = 0;
    check(cudaDeviceGetAttribute(&pools, cudaDevAttrMemoryPoolsSupported, ordinal), ordinal, "cannot be used");
    mHasPools = pools != 0;
    check(cudaStreamCreateWithFlags(&mStream, cudaStreamNonBlocking), ordinal, "no stream can be made");
  }
  ~DeviceStream() {
    (void)cudaStreamSynchronize(mStream);
    (void)cudaStreamDestroy(mStream);
  }
  DeviceStream(const DeviceStream&) = delete;
  DeviceStream& operator=(const DeviceStream&) = delete;

  [[nodiscard]] int ordinal() const { return mOrdinal; }
  [[nodiscard]] const char* what() const { return mWhat; }
  [[nodiscard]] cudaStream_t get() const { return mStream; }
  [[nodiscard]] std::uint64_t usedBytes() const { return mUsed; }
  [[nodiscard]] std::uint64_t peakBytes() const { return mPeak; }

  void* allocate(std::uint64_t bytes, const char* what) {
    void* memory = nullptr;
    const cudaError_t error = mHasPools ? cudaMallocAsync(&memory, bytes, mStream) : cudaMalloc(&memory, bytes);
    if (error == cudaErrorMemoryAllocation) refuse(bytes, what);
    check(error, mOrdinal, what);
    mUsed += bytes;
    mPeak = std::max(mPeak, mUsed);
    return memory;
  }
  void release(void* memory, std::uint64_t bytes) noexcept {
    (void)(mHasPools ? cudaFreeAsync(memory, mStream) : cudaFree(memory));
    mUsed -= bytes;
  }

  [[nodiscard]] std::uint64_t freeBytes() const {
    std::size_t free = 0, total = 0;
    check(cudaMemGetInfo(&free, &total), mOrdinal, "does not tell its memory");
    return free;
  }

private:
  [[noreturn]] void refuse(std::uint64_t bytes, const char* what) const {
    (void)cudaGetLastError();
    const auto mib = [](std::uint64_t b) { return std::to_string(b >> 20) + " MiB"; };
    throw Error(ErrorKind::Device, cudaName(mOrdinal) + ": out of memory for " + what + " (" + mib(bytes) +
                                       " asked for, " + mib(freeBytes()) +
                                       " free); lower the resolution or use --device cpu");
  }

  int mOrdinal;
  const char* mWhat;
  bool mHasPools = false;
  cudaStream_t mStream = nullptr;
  std::uint64_t mUsed = 0, mPeak = 0;
};

/// A mark in a stream that a thread can sleep on.
class DeviceEvent {
public:
  explicit DeviceEvent(const DeviceStream& stream) : mStream(&stream) {
    check(cudaEventCreateWithFlags(&mEvent, cudaEventBlockingSync | cudaEventDisableTiming), stream.ordinal(),
          "no event can be made");
  }
  ~DeviceEvent() { (void)cudaEventDestroy(mEvent); }
  DeviceEvent(const DeviceEvent&) = delete;
  DeviceEvent& operator=(const DeviceEvent&) = delete;

  void record() { check(cudaEventRecord(mEvent, mStream->get()), mStream->ordinal(), mStream->what()); }
  /// Until everything before the latest record() is done; at once when there was none.
  void wait() const { check(cudaEventSynchronize(mEvent), mStream->ordinal(), mStream->what()); }

private:
  const DeviceStream* mStream;
  cudaEvent_t mEvent = nullptr;
};

/// Keeps few launches on their way, so that between them the run can be cancelled.
class FewInFlight {
public:
  explicit FewInFlight(const DeviceStream& stream) : mMarks{DeviceEvent(stream), DeviceEvent(stream)} {}

  /// Calls submit(), which launches, once what was launched the time before the last is done.
  template <class Submit>
  void launch(const Submit& submit) {
    mMarks[mNext].wait();
    submit();
    mMarks[mNext].record();
    mNext = (mNext + 1) % static_cast<int>(mMarks.size());
  }

private:
  std::array<DeviceEvent, 2> mMarks;
  int mNext = 0;
};

template <class... Parameters, class... Arguments>
void launchKernel(const DeviceStream& stream, void (*kernel)(Parameters...), std::int64_t blocks, int threads,
                  const Arguments&... arguments) {
  cudaLaunchConfig_t config{};
  config.gridDim = dim3(static_cast<unsigned>(blocks));
  config.blockDim = dim3(static_cast<unsigned>(threads));
  config.stream = stream.get();
  check(cudaLaunchKernelEx(&config, kernel, arguments...), stream.ordinal(), stream.what());
}

/// Elements in device memory, allocated, copied and freed in the order of a stream.
template <class T>
class DeviceArray {
public:
  DeviceArray() = default;
  DeviceArray(DeviceStream& stream, std::int64_t count, const char* what)
      : mStream(&stream), mCount(std::max<std::int64_t>(count, 1)), mWhat(what) {
    mData = static_cast<T*>(stream.allocate(bytes(mCount), what));
  }
  /// A copy of `count` elements of the host.
  DeviceArray(DeviceStream& stream, const T* host, std::int64_t count, const char* what)
      : DeviceArray(stream, count, what) {
    upload(host, 0, count);
  }
  DeviceArray(DeviceArray&& other) noexcept { swap(other); }
  DeviceArray& operator=(DeviceArray&& other) noexcept {
    DeviceArray taken(std::move(other));
    swap(taken);
    return *this;
  }
  ~DeviceArray() {
    if (mData) mStream->release(mData, bytes(mCount));
  }

  [[nodiscard]] T* data() const { return mData; }
  [[nodiscard]] std::int64_t size() const { return mCount; }

  void upload(const T* host, std::int64_t begin, std::int64_t count) {
    if (count > 0) copy(mData + begin, host, count, cudaMemcpyHostToDevice);
  }
  void download(T* host, std::int64_t begin, std::int64_t count) const {
    if (count > 0) copy(host, mData + begin, count, cudaMemcpyDeviceToHost);
  }
  /// Elements [0, count) of another array of the device, from `begin` on.
  void copyFrom(const DeviceArray& other, std::int64_t begin, std::int64_t count) {
    if (count > 0) copy(mData + begin, other.mData, count, cudaMemcpyDeviceToDevice);
  }
  /// Sets every byte.
  void fill(int byte) { check(cudaMemsetAsync(mData, byte, bytes(mCount), mStream->get()), mStream->ordinal(), mWhat); }

private:
  static std::uint64_t bytes(std::int64_t count) { return static_cast<std::uint64_t>(count) * sizeof(T); }
  void copy(T* to, const T* from, std::int64_t count, cudaMemcpyKind kind) const {
    check(cudaMemcpyAsync(to, from, bytes(count), kind, mStream->get()), mStream->ordinal(), mWhat);
  }
  void swap(DeviceArray& other) noexcept {
    std::swap(mStream, other.mStream);
    std::swap(mData, other.mData);
    std::swap(mCount, other.mCount);
    std::swap(mWhat, other.mWhat);
  }

  DeviceStream* mStream = nullptr;
  T* mData = nullptr;
  std::int64_t mCount = 0;
  const char* mWhat = "";
};

} // namespace volcaustic
