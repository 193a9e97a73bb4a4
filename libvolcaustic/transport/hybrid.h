// Two machines as one tracer (docs/algorithms/cuda.md, "Hybrid").
#pragma once

#include "backends/photon_tracer.h"
#include "transport/balancer.h"

namespace volcaustic {

/// Splits the rows of every call at the balancer's boundary: the first ones are the CPU's, on the calling thread, the
/// others' tracer works from a thread of its own. The balancer hears of a raster when its photons have been traced.
/// What either side throws reaches the caller when both have stopped. `now` is read in seconds, by either side on its
/// own thread; null takes the steady clock.
std::unique_ptr<PhotonTracer> makeHybridTracer(std::unique_ptr<PhotonTracer> cpu, std::unique_ptr<PhotonTracer> other,
                                               std::shared_ptr<HybridBalancer> balancer, double (*now)() = nullptr);

} // namespace volcaustic
