#include "transport/tracers.h"

#include "transport/fallback.h"
#include "transport/hybrid.h"
#include "volcaustic/error.h"

namespace volcaustic {

namespace {

/// The CPU, after a GPU that "auto" chose has failed.
std::unique_ptr<PhotonTracer> replaceGpu(const TracerSetup& setup, const RunContext& ctx, TracerState& state,
                                         const std::string& error) {
  ctx.warn(error + "; going on with the CPU");
  state.choice = DeviceChoice{};
  return makeCpuTracer(setup, ctx, "");
}

std::unique_ptr<PhotonTracer> makeAutomaticGpu(const TracerSetup& setup, const RunContext& ctx,
                                               const std::shared_ptr<TracerState>& state) {
  std::unique_ptr<PhotonTracer> gpu;
  try {
    gpu = makeCudaTracer(setup, ctx, state->choice->cudaOrdinal);
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Device) throw;
    return replaceGpu(setup, ctx, *state, e.what());
  }
  return makeFallbackTracer(
      std::move(gpu), [setup, ctx, state](const std::string& error) { return replaceGpu(setup, ctx, *state, error); });
}

std::unique_ptr<PhotonTracer> makeHybrid(const TracerSetup& setup, const RunContext& ctx, TracerState& state) {
  const DeviceChoice& choice = *state.choice;
  if (!state.balancer)
    state.balancer = std::make_shared<HybridBalancer>(choice.cpuShare ? HybridBalancer::fixed(*choice.cpuShare)
                                                                      : HybridBalancer::dynamic());
  // Progress is told by one side only: the callbacks take one call at a time.
  RunContext silent = ctx;
  silent.onProgress = {};
  silent.onLog = {};
  return makeHybridTracer(makeCpuTracer(setup, ctx, choice.lanes), makeCudaTracer(setup, silent, choice.cudaOrdinal),
                          state.balancer);
}

} // namespace

std::unique_ptr<PhotonTracer> makeTracer(const TracerSetup& setup, const RunContext& ctx,
                                         std::shared_ptr<TracerState> state) {
  if (!state->choice || state->device != ctx.device) {
    state->choice = chooseDevice(ctx);
    state->device = ctx.device;
    state->balancer.reset();
  }
  const DeviceChoice& choice = *state->choice;
  if (choice.mayFallBack) return makeAutomaticGpu(setup, ctx, state);
  if (choice.cudaOrdinal < 0) return makeCpuTracer(setup, ctx, choice.lanes);
  return choice.cpu ? makeHybrid(setup, ctx, *state) : makeCudaTracer(setup, ctx, choice.cudaOrdinal);
}

} // namespace volcaustic
