// What the CUDA backend offers the host; cuda.cu implements it, cuda_stub.cpp where the build has no nvcc. Names no
// CUDA type.
#pragma once

#include "volcaustic/device.h"

namespace volcaustic {

/// Every CUDA device, or one entry "cuda" that says why there is none.
std::vector<DeviceInfo> listCudaDevices();

} // namespace volcaustic
