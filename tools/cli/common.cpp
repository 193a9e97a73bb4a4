#include "common.h"

#include <algorithm>
#include <fmt/format.h>

namespace volcaustic::cli {

std::atomic<bool> gInterrupted{false};

void addCommonOptions(CLI::App& command, CommonOptions& options) {
  constexpr const char* kGroup = "Common options";
  command.add_option("--threads", options.threads, "CPU threads; 0 takes all. Results do not depend on it")
      ->check(CLI::Range(0, 4096))
      ->option_text("N")
      ->group(kGroup);
  command.add_option("--device", options.device, "auto, cpu, cuda, cuda:I or hybrid; see `volcaustic devices`")
      ->group(kGroup);
  command.add_option("--seed", options.seed, "selects the jitter of photons and of pixel samples")->group(kGroup);
  command
      .add_option("--memory-limit", options.memoryLimit, "bytes, or as 512M, 4G; default: 3/4 of the machine's memory")
      ->transform(CLI::AsSizeValue(false))
      ->option_text("SIZE")
      ->group(kGroup);
  CLI::Option* quiet = command.add_flag("--quiet", options.quiet, "print errors only")->group(kGroup);
  command.add_flag("--verbose", options.verbose, "print what happens on the way")->excludes(quiet)->group(kGroup);
  command.add_flag("--json", options.json, "print one JSON report on stdout")->group(kGroup);
}

namespace {

/// The id of the device that `wanted` selects.
/// \throws Error(Usage) for a word that names none, Error(Device) with the reason when it cannot be used.
std::string selectDevice(const std::string& wanted) {
  if (wanted == "auto" || wanted == "cpu") return "cpu";
  const bool isCuda = wanted == "cuda" || wanted.starts_with("cuda:");
  if (!isCuda && wanted != "hybrid")
    throw Error(ErrorKind::Usage, "--device " + wanted + ": is not a device; give auto, cpu, cuda, cuda:I or hybrid");
  const std::string id = wanted.starts_with("cuda:") ? wanted : "cuda";
  std::string reason = "there is no such device";
  for (const DeviceInfo& device : listDevices())
    if (device.id == id || (id == "cuda" && device.id.starts_with("cuda")) || device.id == "cuda") {
      reason = device.usable ? "this version computes on the CPU only" : device.reason;
      break;
    }
  throw Error(ErrorKind::Device, "--device " + wanted + ": " + reason + "; use --device cpu");
}

} // namespace

Job::Job(const char* command, const CommonOptions& options)
    : mConsole(options.quiet     ? Loudness::Quiet
               : options.verbose ? Loudness::Verbose
                                 : Loudness::Normal)
    , mDevice(selectDevice(options.device))
    , mJson(options.json) {
  mContext.threads = options.threads;
  mContext.seed = options.seed;
  mContext.memoryLimit = options.memoryLimit;
  mContext.cancel = &gInterrupted;
  mContext.onLog = [this](LogLevel level, std::string_view line) { mConsole.log(level, line); };
  mContext.onProgress = [this](std::string_view stage, double fraction) { mConsole.progress(stage, fraction); };

  const int threads = options.threads ? options.threads : listDevices().front().parallelUnits;
  mReport = {{"command", command},      {"version", VOLCAUSTIC_VERSION},
             {"inputs", Json::array()}, {"outputs", Json::array()},
             {"device", mDevice},       {"threads", threads},
             {"seed", options.seed},    {"stages", Json::array()}};
}

void Job::addStages(std::span<const StageRun> runs) {
  for (Json& stage : stagesReport(runs)) mReport["stages"].push_back(std::move(stage));
}

void Job::addStage(const char* stage, std::chrono::steady_clock::time_point start) {
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  mReport["stages"].push_back({{"stage", stage}, {"ms", ms}, {"key", ""}});
}

void Job::finish() {
  mReport["peakMemoryBytes"] = peakMemoryBytes();
  if (mJson) printJson(mReport);
}

} // namespace volcaustic::cli
