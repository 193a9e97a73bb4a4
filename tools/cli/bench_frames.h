// Runs a frame of a benchmark scene on a device and keeps its counts and times.
#pragma once

#include "bench_scenes.h"
#include "report.h"

#include <volcaustic/run_context.h>

#include <string>
#include <utility>
#include <vector>

namespace volcaustic::cli {

/// Milliseconds by stage, in the order they ran.
using StageTimes = std::vector<std::pair<std::string, double>>;

inline constexpr const char* kVoxelisation = "voxelisation";
inline constexpr const char* kStepField = "stepField";
inline constexpr const char* kPhotonTracing = "photonTracing";
inline constexpr const char* kView = "view";
inline constexpr const char* kRest = "rest"; ///< what a whole frame takes beside the others

struct FrameFigures {
  std::string scene, device;
  const PaperFigures* paper = nullptr;
  BenchSize size;
  std::size_t objects = 0, triangles = 0;
  std::int64_t occupiedVoxels = 0;
  EnergyBalance balance;
  StageTimes stages;                 ///< the least that each stage took; total() is their sum
  StageTimes photonParts;            ///< of photon tracing, likewise
  std::uint64_t peakMemoryBytes = 0; ///< of one frame, the scene's meshes included

  [[nodiscard]] std::int64_t sourcePhotons() const { return std::int64_t{size.raster} * size.raster; }
  [[nodiscard]] double milliseconds(const char* stage) const; ///< 0 for a stage that did not run
  [[nodiscard]] double total() const;
  [[nodiscard]] double framesPerSecond() const { return 1000 / total(); }
  [[nodiscard]] double nanosecondsPerStep() const;
  [[nodiscard]] double nanosecondsPerVoxelCrossed() const;
};

struct FrameOptions {
  BenchSize size;
  int repeats = 5;
  bool view = true; ///< false stops after the photons
};

/// Voxelises, traces and renders the scene `repeats` times.
FrameFigures measureFrame(const BenchScene& scene, const std::string& device, const FrameOptions& options,
                          const RunContext& ctx);

/// All of it, the paper's figures too.
Json frameReport(const FrameFigures& figures);

} // namespace volcaustic::cli
