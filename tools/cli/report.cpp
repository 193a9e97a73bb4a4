#include "report.h"

#include <cstdio>
#include <fstream>
#include <sys/resource.h>

namespace volcaustic::cli {

std::uint64_t peakMemoryBytes() {
  // getrusage also counts what a large parent process left behind over exec; the kernel's own mark does not.
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

Json energyReport(const EnergyBalance& b) {
  return {{"unit", "W"},
          {"emitted", b.emitted},
          {"absorbed", b.absorbed},
          {"scattered", b.scattered},
          {"escaped", b.escaped},
          {"received", b.received},
          {"cutOff", b.cutOff},
          {"tracedLoss", b.tracedLoss},
          {"depositedLoss", b.depositedLoss},
          {"relativeImbalance", b.relativeImbalance()}};
}

Json stagesReport(std::span<const StageRun> runs) {
  Json stages = Json::array();
  for (const StageRun& run : runs) stages.push_back({{"stage", run.stage}, {"ms", run.milliseconds}, {"key", run.key}});
  return stages;
}

Json photonCounts(const EnergyBalance& b) {
  return {{"photonsEmitted", b.photonsEmitted},
          {"photonsTraced", b.photonsTraced},
          {"photonsAtStepLimit", b.photonsAtStepLimit},
          {"photonsNotFinite", b.photonsNotFinite},
          {"photonSteps", b.steps},
          {"voxelsCrossed", b.voxelsCrossed}};
}

void printJson(const Json& value) {
  const std::string text = value.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  std::fwrite(text.data(), 1, text.size(), stdout);
}

} // namespace volcaustic::cli
