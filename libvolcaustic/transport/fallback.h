// A tracer that another one takes over from when its device fails.
#pragma once

#include "backends/photon_tracer.h"

#include <functional>

namespace volcaustic {

/// Works on `first` until it throws Error(Device), in whatever call. Then makeSecond(error) makes the tracer that does
/// all of the pass so far again, and the rest of it: a device may notice at the very end that its memory did not do.
std::unique_ptr<PhotonTracer>
makeFallbackTracer(std::unique_ptr<PhotonTracer> first,
                   std::function<std::unique_ptr<PhotonTracer>(const std::string& error)> makeSecond);

} // namespace volcaustic
