#include "backends/cuda.h"

namespace volcaustic {

std::vector<DeviceInfo> listCudaDevices() {
  DeviceInfo none;
  none.id = none.name = "cuda";
  none.reason = "this build has no CUDA backend; configure with nvcc on PATH or VOLCAUSTIC_CUDA=ON";
  return {none};
}

} // namespace volcaustic
