#include "common.h"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

namespace volcaustic::cli {

std::atomic<bool> gInterrupted{false};

int statusOf(ErrorKind kind) {
  switch (kind) {
  case ErrorKind::Usage:
    return kWrongUsage;
  case ErrorKind::Input:
  case ErrorKind::File:
    return kBadInput;
  case ErrorKind::Device:
    return kDeviceTrouble;
  case ErrorKind::Cancelled:
    return kInterrupted;
  case ErrorKind::Internal:
    break;
  }
  return kOurFault;
}

std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

std::string errorLine(const Error& error, const std::string& command) {
  switch (error.kind()) {
  case ErrorKind::Input:
  case ErrorKind::File:
    return error.what();
  case ErrorKind::Internal:
    return fmt::format("volcaustic: internal error: {}", error.what());
  default:
    return fmt::format("{}: {}", command, error.what());
  }
}

void addCommonOptions(CLI::App& command, CommonOptions& options) {
  command.add_option("--threads", options.threads, "CPU threads; 0 takes all. Results do not depend on it")
      ->check(CLI::Range(0, 4096))
      ->option_text("N")
      ->group(kCommonOptions);
  command
      .add_option(
          "--device", options.device,
          "auto, cpu, cpu:scalar, cpu:avx2, cpu:avx512, cuda, cuda:I, hybrid or hybrid:SHARE; see `volcaustic devices`")
      ->group(kCommonOptions);
  command.add_option("--seed", options.seed, "selects the jitter of photons and of pixel samples")
      ->group(kCommonOptions);
  command
      .add_option("--memory-limit", options.memoryLimit, "bytes, or as 512M, 4G; default: 3/4 of the machine's memory")
      ->transform(CLI::AsSizeValue(false))
      ->option_text("SIZE")
      ->group(kCommonOptions);
  CLI::Option* quiet = command.add_flag("--quiet", options.quiet, "print errors only")->group(kCommonOptions);
  command.add_flag("--verbose", options.verbose, "print what happens on the way")
      ->excludes(quiet)
      ->group(kCommonOptions);
  command
      .add_flag("--progress", options.progress,
                "print progress as lines \"progress: FILE/FILES STAGE FRACTION\" on stderr, for programs that show it")
      ->group(kCommonOptions);
  if (!command.get_option_no_throw("--json"))
    command.add_flag("--json", options.json, "print one JSON report on stdout")->group(kCommonOptions);
}

Job::Job(const char* command, const CommonOptions& options)
    : mConsole(options.quiet     ? Loudness::Quiet
               : options.verbose ? Loudness::Verbose
                                 : Loudness::Normal,
               options.progress ? ProgressStyle::Lines : ProgressStyle::OnTerminal)
    , mJson(options.json)
    , mJsonFile(options.jsonFile) {
  mContext.threads = options.threads;
  mContext.seed = options.seed;
  mContext.memoryLimit = options.memoryLimit;
  mContext.device = options.device;
  // What "auto" comes to is asked by tracesPhotons(): looking for GPUs takes longer than some commands.
  if (options.device != "auto") (void)selectedDevice(mContext);
  mContext.cancel = &gInterrupted;
  mContext.onLog = [this](LogLevel level, std::string_view line) { mConsole.log(level, line); };
  mContext.onProgress = [this](std::string_view stage, double fraction) { mConsole.progress(stage, fraction); };

  const int threads = options.threads ? options.threads : cpuDevice().parallelUnits;
  mReport = {{"command", command},      {"version", VOLCAUSTIC_VERSION},
             {"inputs", Json::array()}, {"outputs", Json::array()},
             {"device", mDevice},       {"threads", threads},
             {"seed", options.seed},    {"stages", Json::array()}};
}

void Job::tracesPhotons() {
  mDevice = selectedDevice(mContext);
  mReport["device"] = mDevice;
}

void Job::addStages(std::span<const StageRun> runs) {
  for (Json& stage : stagesReport(runs)) mReport["stages"].push_back(std::move(stage));
}

void Job::addStage(const char* stage, std::chrono::steady_clock::time_point start) {
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  mReport["stages"].push_back({{"stage", stage}, {"ms", ms}, {"key", ""}});
}

bool Job::skips(bool resume, const std::string& output) {
  std::error_code ignored;
  if (!resume || !std::filesystem::exists(output, ignored)) return false;
  console().say(output + ": is there, skipped");
  return true;
}

void Job::attempt(Json& entry, const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& error) {
    const int status = statusOf(error.kind());
    if (status != kBadInput && status != kWrongUsage) throw;
    mConsole.error(oneLine(errorLine(error, "volcaustic " + mReport["command"].get<std::string>())));
    entry["error"] = error.what();
    if (mStatus == kDone) mStatus = status;
  }
}

void Job::finish() {
  mReport["peakMemoryBytes"] = peakMemoryBytes();
  if (mJson) printJson(mReport);
  if (!mJsonFile.empty()) writeJson(mJsonFile, mReport);
}

} // namespace volcaustic::cli
