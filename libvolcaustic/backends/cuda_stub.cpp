#include "backends/cuda.h"
#include "backends/photon_tracer.h"
#include "volcaustic/error.h"

namespace volcaustic {

namespace {

constexpr const char* kWhy = "this build has no CUDA backend; configure with nvcc on PATH or VOLCAUSTIC_CUDA=ON";

} // namespace

CudaDevices findCudaDevices() { return {{}, kWhy, false}; }

std::unique_ptr<PhotonTracer> makeCudaTracer(const TracerSetup&, const RunContext&, int ordinal) {
  throw Error(ErrorKind::Device, "cuda:" + std::to_string(ordinal) + ": " + kWhy + ", or use --device cpu");
}

} // namespace volcaustic
