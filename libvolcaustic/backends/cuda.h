// What the CUDA backend offers the host, besides makeCudaTracer (backends/photon_tracer.h)
// and makeCudaMediumBuilder (backends/cuda_medium.h); cuda_devices.cu implements
// it, cuda_stub.cpp where the build has no nvcc. Names no CUDA type.
#pragma once

#include "volcaustic/device.h"

#include <string>
#include <vector>

namespace volcaustic {

struct CudaDevices {
  std::vector<DeviceInfo> devices;
  std::string whyNone;   ///< when there are none, in a sentence without a full stop
  bool expected = false; ///< a driver is installed, so that a person would expect a device
};

/// Every CUDA device, in the runtime's order. Creates no context on any.
CudaDevices findCudaDevices();

} // namespace volcaustic
