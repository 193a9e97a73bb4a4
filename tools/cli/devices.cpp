// devices: what can run here, and why something cannot.
#include "common.h"

#include <volcaustic/device.h>

#include <cstdio>
#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

struct Devices {
  CommonOptions common;
};

int runDevices(const Devices& o) {
  Job job("devices", o.common);
  constexpr double kGiB = 1 << 30;
  for (const DeviceInfo& device : listDevices()) {
    job.report()["devices"].push_back({{"id", device.id},
                                       {"name", device.name},
                                       {"usable", device.usable},
                                       {"reason", device.reason},
                                       {"memoryBytes", device.memoryBytes},
                                       {"parallelUnits", device.parallelUnits}});
    if (job.json()) continue;
    if (device.usable)
      fmt::print("{:<8} {}, {} parallel units, {:.1f} GiB\n", device.id, device.name, device.parallelUnits,
                 static_cast<double>(device.memoryBytes) / kGiB);
    else
      fmt::print("{:<8} {}not usable: {}\n", device.id, device.name.empty() ? "" : device.name + ", ", device.reason);
  }
  job.finish();
  return 0;
}

} // namespace

void addDevicesCommand(CLI::App& app, Action& action) {
  addCommand<Devices>(
      app, action, "devices", "what can run here, and why something cannot", [](CLI::App&, Devices&) {}, runDevices);
}

} // namespace volcaustic::cli
