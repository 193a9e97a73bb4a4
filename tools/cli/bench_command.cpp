// bench: the paper's table on this machine, beside the paper's figures and the machine's own limits; and how time and
// memory grow.
#include "bench_frames.h"
#include "bench_interactive.h"
#include "bench_limits.h"
#include "bench_scaling.h"
#include "bench_scenes.h"
#include "bench_table.h"
#include "common.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace volcaustic::cli {

namespace {

struct Bench {
  CommonOptions common;
  std::vector<std::string> scenes{"all"};
  int repeats = 5;
  BenchSize size;
  bool noView = false, noLimits = false, scaling = false, interactive = false;
  std::int64_t maxPhotons = ScalingOptions{}.maxPhotons;
  int maxVoxels = ScalingOptions{}.maxVoxels;
};

/// "2^20" as the number that it is; anything else as it stands.
CLI::Validator powersOfTwo() {
  return {[](std::string& word) -> std::string {
            int exponent = 0;
            if (!word.starts_with("2^")) return "";
            if (!CLI::detail::lexical_cast(word.substr(2), exponent) || exponent < 0 || exponent > 40)
              return word + " is not a power of two up to 2^40";
            word = std::to_string(std::int64_t{1} << exponent);
            return "";
          },
          ""};
}

void declareBench(CLI::App& command, Bench& o) {
  command
      .add_option("--scene", o.scenes,
                  fmt::format("{}, or all: the paper's four; again for more", fmt::join(benchSceneNames(), ", ")))
      ->allow_extra_args(false)
      ->capture_default_str();
  command.add_option("--repeat", o.repeats, "times are the least of so many runs; default 5")
      ->check(CLI::Range(1, 1000));
  command.add_option("--resolution", o.size.resolution, "voxels along the box's edge; default 256")
      ->check(CLI::Range(8, 4096));
  command.add_option("--photons", o.size.raster, "source photons along each side of the light's raster; default 1024")
      ->check(CLI::Range(1, 65536));
  command.add_flag("--fog", o.size.fog, "fill the box with fog, so that the view steps through all of it");
  command.add_flag("--no-view", o.noView, "stop after the photons");
  command.add_flag("--no-limits", o.noLimits, "do not measure what the machine can do at most");
  CLI::Option* interactive = command.add_flag(
      "--interactive", o.interactive,
      "instead of the table: relighting, other materials, deforming and another view, each whole and as "
      "rough as a window shows it while it moves");
  CLI::Option* scaling = command.add_flag(
      "--scaling", o.scaling, "instead of the table: time and memory against photons and against voxels, a glass ball");
  scaling->excludes(interactive);
  command.add_option("--max-photons", o.maxPhotons, "end of --scaling's sweep over photons; default 2^26")
      ->transform(powersOfTwo())
      ->needs(scaling)
      ->option_text("2^N");
  command.add_option("--max-voxels", o.maxVoxels, "end of --scaling's sweep over voxels along an axis; default 1024")
      ->check(CLI::Range(64, 4096))
      ->needs(scaling);
  command
      .add_option_function<std::string>(
          "--json",
          [&o](const std::string& file) {
            o.common.json = file.empty();
            o.common.jsonFile = file;
          },
          "a JSON report to FILE beside the table, or on stdout in its place")
      ->expected(0, 1)
      ->option_text("[FILE]")
      ->group(kCommonOptions);
}

std::vector<BenchScene> scenesOf(const Bench& o) {
  std::vector<BenchScene> scenes;
  for (const std::string& name : o.scenes)
    if (name == "all")
      for (const char* paper : benchSceneNames().first(kPaperScenes)) scenes.push_back(benchScene(paper));
    else
      scenes.push_back(benchScene(name));
  return scenes;
}

/// The one that was asked for, or every one that can be used.
std::vector<std::string> devicesOf(const Bench& o) {
  if (o.common.device != "auto") return {o.common.device};
  std::vector<std::string> ids;
  for (const DeviceInfo& device : listDevices())
    if (device.usable) ids.push_back(device.id);
  return ids;
}

/// Figures of a machine that is busy with something else mean little.
void warnWhenBusy(Job& job, int threads) {
  double load = 0;
  if (getloadavg(&load, 1) == 1 && load > threads)
    job.context().warn(fmt::format("the machine is busy (load {:.1f} on {} threads): times will be too long; run it "
                                   "again when nothing else runs",
                                   load, threads));
}

std::string titleOf(const std::string& id, int threads) {
  for (const DeviceInfo& device : listDevices())
    if (device.id == id) return fmt::format("{}: {}, {} CPU threads", id, device.name, threads);
  return fmt::format("{}: {} CPU threads", id, threads);
}

void runTable(Job& job, const Bench& o, int threads) {
  const std::vector<BenchScene> scenes = scenesOf(o);
  job.report()["results"] = Json::array();
  for (const std::string& device : devicesOf(o)) {
    CommonOptions common = o.common;
    common.device = device;
    const Job onDevice("bench", common);
    std::vector<FrameFigures> frames;
    for (const BenchScene& scene : scenes) {
      frames.push_back(measureFrame(scene, device, {o.size, o.repeats, !o.noView}, onDevice.context()));
      job.report()["results"].push_back(frameReport(frames.back()));
    }
    if (!job.json()) printFrames(titleOf(device, threads), frames);
  }
}

void runLimits(Job& job, int wantedThreads) {
  const int threads = std::min(wantedThreads, listDevices().front().parallelUnits);
  const MachineLimits limits = measureLimits(threads);
  Json& report = job.report()["limits"];
  report["instructionSet"] = limits.instructionSet;
  for (const MachineLimit& l : limits.limits)
    report[l.key] = {{"oneThread", l.oneThread}, {"allThreads", l.allThreads}};
  if (!job.json()) printLimits(limits, threads);
}

void runScaling(Job& job, const Bench& o) {
  job.report()["scaling"] = Json::array();
  for (const std::string& device : devicesOf(o)) {
    const ScalingOptions options{device, o.repeats, o.maxPhotons, o.maxVoxels};
    const auto say = [&](std::string_view line) {
      if (!job.json()) fmt::print("{}\n", line);
      std::fflush(stdout);
    };
    say(device);
    job.report()["scaling"].push_back({{"device", device}, {"sweeps", measureScaling(options, job.context(), say)}});
  }
}

void runInteractive(Job& job, const Bench& o, int threads) {
  constexpr double kMovingMs = 2000;
  job.report()["interactive"] = Json::array();
  for (const std::string& device : devicesOf(o)) {
    CommonOptions common = o.common;
    common.device = device;
    const Job onDevice("bench", common);
    std::vector<InteractiveFigures> scenes;
    Json report = Json::array();
    for (const BenchScene& scene : scenesOf(o)) {
      scenes.push_back(measureInteractive(scene, o.size, o.repeats, kMovingMs, onDevice.context()));
      report.push_back(interactiveReport(scenes.back()));
    }
    job.report()["interactive"].push_back({{"device", device}, {"scenes", std::move(report)}});
    if (!job.json()) printInteractive(titleOf(device, threads), scenes);
  }
}

int runBench(const Bench& o) {
  Job job("bench", o.common);
  const int threads = o.common.threads ? o.common.threads : listDevices().front().parallelUnits;
  job.report()["device"] = o.common.device; // each result names its own
  warnWhenBusy(job, threads);
  if (o.scaling) {
    runScaling(job, o);
  } else if (o.interactive) {
    runInteractive(job, o, threads);
  } else {
    runTable(job, o, threads);
    if (!o.noLimits) runLimits(job, threads);
  }
  job.finish();
  return 0;
}

} // namespace

void addBenchCommand(CLI::App& app, Action& action) {
  addCommand<Bench>(app, action, "bench", "the paper's table on this machine, beside the machine's limits",
                    declareBench, runBench);
}

} // namespace volcaustic::cli
