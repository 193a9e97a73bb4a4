// From RunContext::device to the machines that take part.
#pragma once

#include "backends/cuda.h"

#include <optional>

namespace volcaustic {

/// A parsed device word, whatever this machine has.
struct DeviceRequest {
  enum class Kind { Auto, Cpu, Cuda, Hybrid };
  Kind kind = Kind::Auto;
  std::string text;               ///< as given
  std::string lanes;              ///< cpu: instruction set, "" for the widest
  int ordinal = -1;               ///< cuda: which one, -1 for the first usable
  std::optional<double> cpuShare; ///< hybrid: the CPU's share of the rows; without one the balance is dynamic
};

/// \throws Error(Usage) for anything but auto, cpu[:LANES], cuda[:I] and hybrid[:SHARE].
DeviceRequest parseDevice(const std::string& text);

/// Who takes part.
struct DeviceChoice {
  bool cpu = true;
  std::string lanes;              ///< the CPU's instruction set, "" for the widest
  int cudaOrdinal = -1;           ///< the GPU; -1: none
  std::optional<double> cpuShare; ///< of a static balance
  bool mayFallBack = false;       ///< "auto" chose the GPU: when that fails, the CPU takes over

  /// "cpu", "cpu:avx2", "cuda:0" or "hybrid (cpu + cuda:0)".
  [[nodiscard]] std::string id() const;
};

/// Decides on what is here. "auto" tells what it chose, and why, in one line of the log: not at all where nobody would
/// expect a GPU. \throws Error(Device) when a device asked for by name cannot be used.
DeviceChoice chooseDevice(const DeviceRequest& request, const CudaDevices& cuda, const RunContext& ctx);
/// The same for ctx.device on this machine.
DeviceChoice chooseDevice(const RunContext& ctx);

} // namespace volcaustic
