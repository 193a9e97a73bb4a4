// The tracer of a pass on whatever machine RunContext::device asks for.
#pragma once

#include "backends/devices.h"
#include "backends/photon_tracer.h"
#include "transport/balancer.h"

namespace volcaustic {

/// What the passes of one Session keep from one to the next. Passes that share it run one after the other.
struct TracerState {
  std::string device; ///< RunContext::device that `choice` was made for
  std::optional<DeviceChoice> choice;
  std::shared_ptr<HybridBalancer> balancer; ///< of a hybrid run
};

/// \throws Error(Usage) for a word that names no device; Error(Device) when a device asked for by name cannot be used,
/// or its memory does not do. A GPU that "auto" chose and that fails, now or in the midst of the pass, is replaced by
/// the CPU with one warning, for the passes after this one too.
std::unique_ptr<PhotonTracer> makeTracer(const TracerSetup& setup, const RunContext& ctx,
                                         std::shared_ptr<TracerState> state = std::make_shared<TracerState>());

} // namespace volcaustic
