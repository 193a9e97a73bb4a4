// What CUDA devices there are, and whether this build has code for them.

#include "backends/cuda.h"
#include "backends/cuda_memory.cuh"

#include <algorithm>

namespace volcaustic {

namespace {

/// The last error's name and text are taken, so that the next call starts clean.
std::string reasonOf(cudaError_t error) {
  (void)cudaGetLastError();
  return std::string(cudaGetErrorString(error)) + " (" + cudaGetErrorName(error) + ")";
}

/// The oldest architecture that nvcc was told to compile for, as 10 * compute capability. Newer devices run it, or
/// translate the PTX beside it.
int oldestArchitecture() { return std::min({__CUDA_ARCH_LIST__}) / 10; }

std::string version(int tenfold) { return std::to_string(tenfold / 10) + "." + std::to_string(tenfold % 10); }

DeviceInfo describeDevice(int ordinal) {
  DeviceInfo device;
  device.id = cudaName(ordinal);
  device.name = "CUDA device";
  cudaDeviceProp properties{};
  if (const cudaError_t error = cudaGetDeviceProperties(&properties, ordinal); error != cudaSuccess) {
    device.reason = reasonOf(error);
    return device;
  }
  const int capability = 10 * properties.major + properties.minor;
  device.name = std::string(properties.name) + " (compute capability " + version(capability) + ")";
  device.memoryBytes = properties.totalGlobalMem;
  device.parallelUnits = properties.multiProcessorCount;
  device.usable = capability >= oldestArchitecture();
  if (!device.usable)
    device.reason = "this build is for compute capability " + version(oldestArchitecture()) + " and newer";
  return device;
}

} // namespace

CudaDevices findCudaDevices() {
  CudaDevices found;
  int driver = 0;
  found.expected = cudaDriverGetVersion(&driver) == cudaSuccess && driver > 0;
  if (!found.expected) {
    found.whyNone = "no NVIDIA driver is installed";
    return found;
  }
  int count = 0;
  if (const cudaError_t error = cudaGetDeviceCount(&count); error != cudaSuccess) {
    found.whyNone = reasonOf(error);
    found.expected = error != cudaErrorNoDevice;
    return found;
  }
  for (int i = 0; i < count; ++i) found.devices.push_back(describeDevice(i));
  if (!count) found.whyNone = "there is no CUDA device";
  return found;
}

} // namespace volcaustic
