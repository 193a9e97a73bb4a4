#include "backends/cuda.h"
#include "backends/cuda_medium.h"
#include "backends/photon_tracer.h"
#include "backends/view_tracer.h"
#include "volcaustic/error.h"

namespace volcaustic {

namespace {

constexpr const char* kWhy = "this build has no CUDA backend; configure with nvcc on PATH or VOLCAUSTIC_CUDA=ON";

[[noreturn]] void refuse(int ordinal) {
  throw Error(ErrorKind::Device, "cuda:" + std::to_string(ordinal) + ": " + kWhy + ", or use --device cpu");
}

} // namespace

CudaDevices findCudaDevices() { return {{}, kWhy, false}; }

std::unique_ptr<PhotonTracer> makeCudaTracer(const TracerSetup&, const RunContext&, int ordinal) { refuse(ordinal); }

std::unique_ptr<ViewTracer> makeCudaViewer(const kernels::ViewScene&, const ViewTables&,
                                           std::shared_ptr<const DeviceFlatMedium>, const kernels::PixelPlanes&,
                                           const RunContext&, int ordinal) {
  refuse(ordinal);
}

std::unique_ptr<DeviceMediumBuilder> makeCudaMediumBuilder(std::uint64_t, int ordinal) { refuse(ordinal); }

} // namespace volcaustic
