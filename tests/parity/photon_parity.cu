// The bodies of the photon pass, compiled for CUDA as they stand, against the CPU's result for the same scene.

#include "kernels/photon.h"
#include "kernels/view.h"
#include "support/fields.h"
#include "transport/emission.h"
#include "transport/march_rules.h"
#include "volcaustic/photons.h"
#include "volume/flatten.h"

#include <cuda_runtime.h>
#include <gtest/gtest.h>
#include <vector>

namespace volcaustic::test {

using namespace volcaustic::kernels;

/// Dense sums in 64-bit fixed point, three for each voxel; integer atomics add up to the same in any order.
struct AtomicSink {
  Int3 dims;
  unsigned long long* sums;
  double scale;

  VOLCAUSTIC_HD void deposit(const Int3& v, const Float3& w, const Float3&) {
#if defined(__CUDA_ARCH__)
    unsigned long long* at = sums + 3 * ((static_cast<std::int64_t>(v.x) * dims.y + v.y) * dims.z + v.z);
    atomicAdd(at, static_cast<unsigned long long>(static_cast<long long>(w.x * scale)));
    atomicAdd(at + 1, static_cast<unsigned long long>(static_cast<long long>(w.y * scale)));
    atomicAdd(at + 2, static_cast<unsigned long long>(static_cast<long long>(w.z * scale)));
#else
    (void)v, (void)w;
#endif
  }
  VOLCAUSTIC_HD void tally(Outcome, const Double3&) {}
  VOLCAUSTIC_HD void count(Counter, std::int64_t) {}
};

template <class Body, class Sink>
__global__ void run(std::int64_t n, Body body, Sink sink) {
  const std::int64_t i = blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (i < n) body(i, sink);
}

template <class Body>
void launch(std::int64_t n, const Body& body, const AtomicSink& sink) {
  run<<<static_cast<unsigned>((n + 127) / 128), 128>>>(n, body, sink);
  ASSERT_EQ(cudaDeviceSynchronize(), cudaSuccess) << cudaGetErrorString(cudaGetLastError());
}

/// A device copy of a vector, freed at the end.
template <class T>
class DeviceArray {
public:
  explicit DeviceArray(const std::vector<T>& values) : mSize(values.size()) {
    cudaMalloc(&mData, std::max<std::size_t>(mSize, 1) * sizeof(T));
    cudaMemcpy(mData, values.data(), mSize * sizeof(T), cudaMemcpyHostToDevice);
  }
  ~DeviceArray() { cudaFree(mData); }
  DeviceArray(const DeviceArray&) = delete;
  DeviceArray& operator=(const DeviceArray&) = delete;
  [[nodiscard]] T* data() const { return mData; }
  [[nodiscard]] std::size_t size() const { return mSize; }

private:
  T* mData = nullptr;
  std::size_t mSize;
};

template <class T>
std::vector<T> download(const DeviceArray<T>& array) {
  std::vector<T> values(array.size());
  cudaMemcpy(values.data(), array.data(), array.size() * sizeof(T), cudaMemcpyDeviceToHost);
  return values;
}

// Instantiated so that the view body, too, compiles for the device on every build.
template __global__ void run(std::int64_t, ViewBody<AtomicSink>, AtomicSink);

TEST(Parity, CausticFluenceOnTheGpuIsTheCpus) {
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) GTEST_SKIP() << "no CUDA device";

  const int n = 64;
  const Medium medium = sampleMedium(unitCube(n), {}, indexField("smooth_sphere"));
  Light sun;
  PhotonOptions options;
  options.grid = {256, 256};
  options.smooth = false;
  const PhotonResult cpu = tracePhotons(medium, std::span(&sun, 1), {}, options);

  const FlatMediumStorage host = flattenMedium(medium, {}, {});
  const DeviceArray bricks(host.bricks);
  const DeviceArray fields(host.fields);
  const DeviceArray steps(host.steps);
  const DeviceArray voxelOptics(host.voxelOptics);
  const DeviceArray optics(host.optics);
  const FlatMedium flat{host.dims,    host.brickDims,     bricks.data(), fields.data(),
                        steps.data(), voxelOptics.data(), optics.data(), host.cap};
  const EmissionFrame frame = emissionFrames(sun, 0, medium.domain(), options, 0).front();
  const DeviceArray<float> entry(std::vector<float>(frame.cells()));
  const DeviceArray<unsigned long long> sums(std::vector<unsigned long long>(std::size_t{3} * n * n * n));
  const AtomicSink sink{host.dims, sums.data(), 0x1p40};
  launch(frame.cells(), EmissionBody<AtomicSink>{flat, frame, entry.data()}, sink);

  std::vector<std::uint32_t> cells;
  const std::vector<float> met = download(entry);
  for (std::size_t i = 0; i < met.size(); ++i)
    if (met[i] != kNeverBends) cells.push_back(static_cast<std::uint32_t>(i));
  EXPECT_EQ(static_cast<std::int64_t>(cells.size()), cpu.balance.photonsTraced);
  const DeviceArray list(cells);
  PhotonRules rules;
  rules.march = marchRules(options);
  launch(static_cast<std::int64_t>(cells.size()), PhotonBody<AtomicSink>{flat, frame, entry.data(), list.data(), rules},
         sink);

  const std::vector<unsigned long long> gpu = download(sums);
  double difference = 0, total = 0;
  const double toFluence = double{n} * n / sink.scale;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        const double a = cpu.radiance.causticFluence({x, y, z})[0];
        const auto sum = static_cast<long long>(gpu[3 * ((static_cast<std::size_t>(x) * n + y) * n + z)]);
        difference += std::abs(a - static_cast<double>(sum) * toFluence);
        total += a;
      }
  EXPECT_LE(difference, 1e-4 * total);
}

} // namespace volcaustic::test
