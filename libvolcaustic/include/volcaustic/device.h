/// \file device.h
/// What can run here, and why something cannot.
#pragma once

#include "volcaustic/export.h"

#include <cstdint>
#include <string>
#include <vector>

namespace volcaustic {

struct DeviceInfo {
  std::string id; ///< "cpu", "cuda:0", ...; what --device takes
  std::string name;
  bool usable = false;
  std::string reason; ///< why it is not usable, in a sentence
  std::uint64_t memoryBytes = 0;
  int parallelUnits = 0; ///< CPU threads, or streaming multiprocessors
};

/// The CPU first, then every CUDA device, or one unusable "cuda" entry that says why there is none.
VOLCAUSTIC_API std::vector<DeviceInfo> listDevices();

} // namespace volcaustic
