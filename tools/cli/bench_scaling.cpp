#include "bench_scaling.h"

#include "own_process.h"

#include <volcaustic/error.h>

#include <csignal>
#include <fmt/format.h>
#include <vector>

namespace volcaustic::cli {

namespace {

struct Case {
  int raster;     ///< photons along each side
  int resolution; ///< voxels along each axis
};

struct Sweep {
  const char* name;
  std::vector<Case> cases;
};

std::vector<Sweep> sweepsOf(const ScalingOptions& o) {
  Sweep photons{"photons", {}}, voxels{"voxels", {}};
  for (int raster = 1 << 8; std::int64_t{raster} * raster <= o.maxPhotons; raster *= 2)
    photons.cases.push_back({raster, 256});
  for (int resolution = 64; resolution <= o.maxVoxels; resolution *= 2) voxels.cases.push_back({1 << 10, resolution});
  return {photons, voxels};
}

std::vector<std::string> argumentsOf(const Case& c, const ScalingOptions& o, const RunContext& ctx) {
  return {"bench",
          "--scene",
          "ball",
          "--no-view",
          "--no-limits",
          "--json",
          "--quiet",
          "--repeat",
          std::to_string(o.repeats),
          "--photons",
          std::to_string(c.raster),
          "--resolution",
          std::to_string(c.resolution),
          "--device",
          o.device,
          "--threads",
          std::to_string(ctx.threads),
          "--seed",
          std::to_string(ctx.seed),
          "--memory-limit",
          std::to_string(ctx.effectiveMemoryLimit())};
}

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

/// Why a case could not be run within the memory there is; empty when that was not its trouble.
std::string memoryTrouble(const ChildResult& child) {
  constexpr int kBadInput = 3, kDevice = 4; // the program's exit statuses for the machine's and the device's memory
  if (child.status == 128 + SIGKILL) return "was killed, which is how a machine out of memory ends a process";
  if (child.status == kBadInput || child.status == kDevice) return firstLine(child.words);
  return "";
}

std::string describe(const Case& c) { return fmt::format("{:>5}² photons, {:>4}³ voxels", c.raster, c.resolution); }

std::string figuresOf(const Case& c, const Json& frame) {
  const Json &counts = frame.at("counts"), &ms = frame.at("ms");
  return fmt::format("{}: voxelisation {:9.2f} ms, step field {:8.2f} ms, photons {:10.2f} ms, {:5.1f} ns a voxel "
                     "crossed ({:8.2f}M), peak memory {:6.0f} MiB",
                     describe(c), ms.at("voxelisation").get<double>(), ms.at("stepField").get<double>(),
                     ms.at("photonTracing").get<double>(), frame.at("nsPerVoxelCrossed").get<double>(),
                     counts.at("voxelsCrossed").get<double>() / 1e6,
                     frame.at("peakMemoryBytes").get<double>() / (1 << 20));
}

} // namespace

Json measureScaling(const ScalingOptions& o, const RunContext& ctx,
                    const std::function<void(std::string_view line)>& say) {
  // A GPU's driver claims memory of its own beforehand, which is no measure of a case.
  const std::uint64_t childLimit = o.device.starts_with("cpu") ? ctx.effectiveMemoryLimit() : 0;
  Json report = Json::array();
  for (const Sweep& sweep : sweepsOf(o)) {
    Json cases = Json::array(), stopped;
    for (const Case& c : sweep.cases) {
      const ChildResult child = runOwnProgram(argumentsOf(c, o, ctx), childLimit);
      if (const std::string trouble = memoryTrouble(child); !trouble.empty()) {
        stopped = {{"photons", std::int64_t{c.raster} * c.raster}, {"voxels", c.resolution}, {"reason", trouble}};
        say(fmt::format("{}: the sweep of {} stops here: {}", describe(c), sweep.name, trouble));
        break;
      }
      if (child.status != 0)
        throw Error(ErrorKind::Internal,
                    fmt::format("{} ended in status {}: {}", describe(c), child.status, firstLine(child.words)));
      Json frame = Json::parse(child.output).at("results").at(0);
      say(figuresOf(c, frame));
      cases.push_back(std::move(frame));
    }
    report.push_back({{"sweep", sweep.name}, {"cases", cases}, {"stopped", stopped}});
  }
  return report;
}

} // namespace volcaustic::cli
