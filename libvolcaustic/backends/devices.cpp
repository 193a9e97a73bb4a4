#include "volcaustic/device.h"

#include "backends/cuda.h"
#include "core/parallel.h"

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

} // namespace

std::vector<DeviceInfo> listDevices() {
  DeviceInfo cpu;
  cpu.id = "cpu";
  cpu.name = processorName();
  cpu.usable = true;
  cpu.memoryBytes =
      static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
  cpu.parallelUnits = threadCount({});
  std::vector<DeviceInfo> devices{cpu};
  for (DeviceInfo& d : listCudaDevices()) devices.push_back(std::move(d));
  return devices;
}

} // namespace volcaustic
