#include "backends/devices.h"

#include "backends/lanes.h"
#include "core/parallel.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <unistd.h>

namespace volcaustic {

namespace {

/// The processor's own name, where the system tells it.
std::string processorName() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) {
      const auto colon = line.find(':');
      return colon == std::string::npos ? "CPU" : line.substr(line.find_first_not_of(" \t", colon + 1));
    }
  return "CPU";
}

template <class T>
bool readNumber(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

[[noreturn]] void refuse(const DeviceRequest& request, const std::string& reason, const char* advice) {
  throw Error(ErrorKind::Device, "--device " + request.text + ": " + reason + "; " + advice);
}

DeviceChoice chooseCpu(const DeviceRequest& request) {
  (void)laneSet(request.lanes); // throws where this processor does not have it
  DeviceChoice choice;
  choice.lanes = request.lanes;
  return choice;
}

/// The GPU that `request` means. \throws Error(Device) with the reason when there is none to use.
const DeviceInfo& requireCuda(const DeviceRequest& request, const CudaDevices& cuda) {
  constexpr const char* kAdvice = "use cpu or auto";
  if (cuda.devices.empty()) refuse(request, cuda.whyNone, kAdvice);
  if (request.ordinal >= static_cast<int>(cuda.devices.size()))
    refuse(request, "there is no such device, the last one is " + cuda.devices.back().id, kAdvice);
  const auto usable =
      std::find_if(cuda.devices.begin(), cuda.devices.end(), [](const DeviceInfo& d) { return d.usable; });
  const bool any = request.ordinal < 0;
  const DeviceInfo& device = !any                           ? cuda.devices[request.ordinal]
                             : usable != cuda.devices.end() ? *usable
                                                            : cuda.devices.front();
  if (!device.usable) refuse(request, device.id + " cannot be used, " + device.reason, kAdvice);
  return device;
}

int ordinalOf(const DeviceInfo& device, const CudaDevices& cuda) {
  return static_cast<int>(&device - cuda.devices.data());
}

DeviceChoice chooseAutomatically(const CudaDevices& cuda, const RunContext& ctx) {
  DeviceChoice choice;
  for (const DeviceInfo& device : cuda.devices)
    if (device.usable) {
      choice.cpu = false;
      choice.cudaOrdinal = ordinalOf(device, cuda);
      choice.mayFallBack = true;
      ctx.log(LogLevel::Info, "device: " + device.id + ", " + device.name);
      return choice;
    }
  if (!cuda.devices.empty())
    ctx.log(LogLevel::Info,
            "device: cpu; " + cuda.devices.front().id + " cannot be used, " + cuda.devices.front().reason);
  else
    ctx.log(cuda.expected ? LogLevel::Info : LogLevel::Detail, "device: cpu; " + cuda.whyNone);
  return choice;
}

} // namespace

DeviceRequest parseDevice(const std::string& text) {
  using Kind = DeviceRequest::Kind;
  DeviceRequest request;
  request.text = text;
  const auto colon = text.find(':');
  const std::string name = text.substr(0, colon);
  const bool hasDetail = colon != std::string::npos;
  const std::string detail = hasDetail ? text.substr(colon + 1) : "";

  bool good = true;
  if (name == "auto") {
    good = !hasDetail;
  } else if (name == "cpu") {
    request.kind = Kind::Cpu;
    request.lanes = detail;
    good = !hasDetail || detail == "scalar" || detail == "avx2" || detail == "avx512";
  } else if (name == "cuda") {
    request.kind = Kind::Cuda;
    good = !hasDetail || (readNumber(detail, request.ordinal) && request.ordinal >= 0);
  } else if (name == "hybrid") {
    request.kind = Kind::Hybrid;
    double share = 0;
    good = !hasDetail || (readNumber(detail, share) && share >= 0 && share <= 1);
    if (hasDetail) request.cpuShare = share;
  } else {
    good = false;
  }
  if (!good)
    throw Error(ErrorKind::Usage, "--device " + text +
                                      ": is not a device; give auto, cpu, cpu:scalar, cpu:avx2, cpu:avx512, cuda, "
                                      "cuda:I, hybrid or hybrid:SHARE with a share from 0 to 1");
  return request;
}

std::string DeviceChoice::id() const {
  const std::string host = lanes.empty() ? "cpu" : "cpu:" + lanes;
  const std::string gpu = "cuda:" + std::to_string(cudaOrdinal);
  if (cudaOrdinal < 0) return host;
  return cpu ? "hybrid (" + host + " + " + gpu + ")" : gpu;
}

DeviceChoice chooseDevice(const DeviceRequest& request, const CudaDevices& cuda, const RunContext& ctx) {
  using Kind = DeviceRequest::Kind;
  if (request.kind == Kind::Auto) return chooseAutomatically(cuda, ctx);
  if (request.kind == Kind::Cpu) return chooseCpu(request);
  DeviceChoice choice;
  choice.cpu = request.kind == Kind::Hybrid;
  choice.cudaOrdinal = ordinalOf(requireCuda(request, cuda), cuda);
  choice.cpuShare = request.cpuShare;
  return choice;
}

DeviceChoice chooseDevice(const RunContext& ctx) {
  const DeviceRequest request = parseDevice(ctx.device);
  const bool needsCuda = request.kind != DeviceRequest::Kind::Cpu;
  return chooseDevice(request, needsCuda ? findCudaDevices() : CudaDevices{}, ctx);
}

std::string selectedDevice(const RunContext& ctx) {
  RunContext quiet = ctx;
  quiet.onLog = {};
  return chooseDevice(quiet).id();
}

DeviceInfo cpuDevice() {
  DeviceInfo cpu;
  cpu.id = "cpu";
  cpu.name = processorName() + " (" + std::string(laneSets().front().name) + ")";
  cpu.usable = true;
  cpu.memoryBytes =
      static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
  cpu.parallelUnits = threadCount({});
  return cpu;
}

std::vector<DeviceInfo> listDevices() {
  std::vector<DeviceInfo> devices{cpuDevice()};
  CudaDevices cuda = findCudaDevices();
  for (DeviceInfo& d : cuda.devices) devices.push_back(std::move(d));
  if (cuda.devices.empty()) {
    DeviceInfo none;
    none.id = none.name = "cuda";
    none.reason = cuda.whyNone;
    devices.push_back(std::move(none));
  }
  return devices;
}

} // namespace volcaustic
