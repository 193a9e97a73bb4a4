#include "backends/cuda.h"

#include <cuda_runtime.h>

namespace volcaustic {

namespace {

/// The last error's name and text are taken, so that the next call starts clean.
std::string reasonOf(cudaError_t error) {
  (void)cudaGetLastError();
  return std::string(cudaGetErrorName(error)) + ": " + cudaGetErrorString(error);
}

DeviceInfo describeDevice(int ordinal) {
  DeviceInfo device;
  device.id = "cuda:" + std::to_string(ordinal);
  cudaDeviceProp properties{};
  if (const cudaError_t error = cudaGetDeviceProperties(&properties, ordinal); error != cudaSuccess) {
    device.name = "CUDA device";
    device.reason = reasonOf(error);
    return device;
  }
  device.name = properties.name;
  device.memoryBytes = properties.totalGlobalMem;
  device.parallelUnits = properties.multiProcessorCount;
  device.reason = "photons and views run on the CPU in this version";
  return device;
}

} // namespace

std::vector<DeviceInfo> listCudaDevices() {
  int count = 0;
  if (const cudaError_t error = cudaGetDeviceCount(&count); error != cudaSuccess) {
    DeviceInfo none;
    none.id = none.name = "cuda";
    none.reason = reasonOf(error);
    return {none};
  }
  std::vector<DeviceInfo> devices;
  for (int i = 0; i < count; ++i) devices.push_back(describeDevice(i));
  return devices;
}

} // namespace volcaustic
