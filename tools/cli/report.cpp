#include "report.h"

#include <volcaustic/error.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <malloc.h>
#include <sys/resource.h>
#include <system_error>
#include <unistd.h>

namespace volcaustic::cli {

namespace {

std::string textOf(const Json& value) { return value.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

} // namespace

std::uint64_t peakMemoryBytes() {
  // getrusage also counts what a large parent process left behind over exec; the kernel's own mark does not.
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

void resetPeakMemory() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5"; // resets VmHWM
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
  for (const StageRun& run : runs)
    stages.push_back({{"stage", run.stage},
                      {"ms", run.milliseconds},
                      {"key", run.key},
                      {"because", run.because},
                      {"fromDisk", run.fromDisk}});
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
  const std::string text = textOf(value);
  std::fwrite(text.data(), 1, text.size(), stdout);
}

void writeJson(const std::string& path, const Json& value) {
  const std::string part = path + "." + std::to_string(getpid()) + ".part";
  std::error_code failed;
  if (!(std::ofstream(part, std::ios::binary) << textOf(value) << std::flush))
    failed = std::make_error_code(std::errc::io_error);
  else
    std::filesystem::rename(part, path, failed);
  if (!failed) return;
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  throw Error(ErrorKind::File, path + ": cannot be written; check that the folder is there and has room");
}

} // namespace volcaustic::cli
