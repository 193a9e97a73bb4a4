/// \file device.h
/// What can run here, and why something cannot.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/run_context.h"

#include <cstdint>
#include <string>
#include <vector>

namespace volcaustic {

struct DeviceInfo {
  std::string id;   ///< "cpu", "cuda:0", ...; what --device takes
  std::string name; ///< with the widest instruction set of a CPU, the compute capability of a GPU
  bool usable = false;
  std::string reason; ///< why it is not usable, in a sentence
  std::uint64_t memoryBytes = 0;
  int parallelUnits = 0; ///< CPU threads, or streaming multiprocessors
};

/// What ctx.device selects on this machine: "cpu", "cpu:avx2", "cuda:0" or "hybrid (cpu + cuda:0)".
/// \throws Error(Usage) for a word that names no device, Error(Device) with the reason when it cannot be used here.
VOLCAUSTIC_API std::string selectedDevice(const RunContext& ctx);

/// The CPU, without looking for anything else.
VOLCAUSTIC_API DeviceInfo cpuDevice();

/// The CPU first, then every CUDA device, or one unusable "cuda" entry that says why there is none.
VOLCAUSTIC_API std::vector<DeviceInfo> listDevices();

} // namespace volcaustic
