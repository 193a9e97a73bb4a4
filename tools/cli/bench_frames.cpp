#include "bench_frames.h"

#include "occupied_voxels.h"

#include <volcaustic/session.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace volcaustic::cli {

namespace {

class Stopwatch {
public:
  [[nodiscard]] double milliseconds() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - mStart).count();
  }

private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point mStart = Clock::now();
};

double timeOf(const StageTimes& times, std::string_view stage) {
  for (const auto& [name, ms] : times)
    if (name == stage) return ms;
  return 0;
}

/// The smaller of what is there and `ms`.
void keepLeast(StageTimes& times, const std::string& stage, double ms) {
  for (auto& [name, least] : times)
    if (name == stage) {
      least = std::min(least, ms);
      return;
    }
  times.emplace_back(stage, ms);
}

double sessionTime(const Session& session, std::string_view stage) {
  double ms = 0;
  for (const StageRun& run : session.runs())
    if (run.stage == stage) ms += run.milliseconds;
  return ms;
}

/// One frame as a session runs it. Its own time for the medium holds copies of the meshes and their hashes: what
/// buildMedium did not take (`voxelisation`) goes to the rest.
void runFrame(const BenchScene& scene, const FrameOptions& options, double voxelisation, const RunContext& ctx,
              FrameFigures& figures) {
  Session session(sessionScene(scene, options.size), ctx);
  const Stopwatch watch;
  const PhotonResult& traced = session.photons();
  figures.balance = traced.balance;
  for (const PassPart& part : traced.parts) keepLeast(figures.photonParts, part.name.c_str(), part.ms);
  if (options.view) session.view();
  const double frame = watch.milliseconds();

  const double stepField = sessionTime(session, "stepField"), photons = sessionTime(session, "photons"),
               view = sessionTime(session, "view");
  keepLeast(figures.stages, kVoxelisation, voxelisation);
  keepLeast(figures.stages, kStepField, stepField);
  keepLeast(figures.stages, kPhotonTracing, photons);
  if (options.view) keepLeast(figures.stages, kView, view);
  keepLeast(figures.stages, kRest, std::max(0.0, frame - voxelisation - stepField - photons - view));
}

double perCount(double ms, std::int64_t count) { return count > 0 ? ms * 1e6 / static_cast<double>(count) : 0; }

Json paperReport(const PaperFigures& p) {
  return {{"device", "GeForce GTX 1080 Ti"},
          {"objects", p.objects},
          {"triangles", p.triangles},
          {"occupiedVoxels", std::pow(p.occupiedCubeRoot, 3)},
          {"photonSteps", p.steps},
          {"photonsTraced", p.photonsTraced},
          {"ms",
           {{kVoxelisation, p.voxelisation},
            {kPhotonTracing, p.photonTracing},
            {"everythingElse", p.everythingElse},
            {"total", p.total}}},
          {"framesPerSecond", p.framesPerSecond}};
}

} // namespace

double FrameFigures::milliseconds(const char* stage) const { return timeOf(stages, stage); }

double FrameFigures::total() const {
  double sum = 0;
  for (const auto& [name, ms] : stages) sum += ms;
  return sum;
}

double FrameFigures::nanosecondsPerStep() const { return perCount(milliseconds(kPhotonTracing), balance.steps); }
double FrameFigures::nanosecondsPerVoxelCrossed() const {
  return perCount(milliseconds(kPhotonTracing), balance.voxelsCrossed);
}

FrameFigures measureFrame(const BenchScene& scene, const std::string& device, const FrameOptions& options,
                          const RunContext& ctx) {
  FrameFigures figures;
  figures.scene = scene.name;
  figures.device = device;
  figures.paper = scene.paper;
  figures.size = options.size;
  figures.objects = scene.bodies.size();
  for (const Body& b : scene.bodies) figures.triangles += b.mesh->triangles.size();

  const SceneVolume volume = sessionScene(scene, options.size).volume;
  const Domain domain = domainAround(volume.bounds, volume.resolution, 0, 0);
  resetPeakMemory();
  for (int i = 0; i < options.repeats; ++i) {
    const Stopwatch watch;
    Medium medium = buildMedium(scene.bodies, volume.ambient, domain, {}, ctx);
    const double voxelisation = watch.milliseconds();
    if (i == 0) figures.occupiedVoxels = occupiedVoxels(medium);
    medium = {};
    runFrame(scene, options, voxelisation, ctx, figures);
    ctx.progress(scene.name, (i + 1.0) / options.repeats);
  }
  figures.peakMemoryBytes = peakMemoryBytes();
  return figures;
}

Json frameReport(const FrameFigures& f) {
  Json ms = Json::object();
  for (const auto& [stage, time] : f.stages) ms[stage] = time;
  ms["total"] = f.total();
  Json parts = Json::object();
  for (const auto& [part, time] : f.photonParts) parts[part] = time;
  return {{"scene", f.scene},
          {"device", f.device},
          {"objects", f.objects},
          {"triangles", f.triangles},
          {"volume", {f.size.resolution, f.size.resolution, f.size.resolution}},
          {"occupiedVoxels", f.occupiedVoxels},
          {"sourcePhotons", f.sourcePhotons()},
          {"counts", photonCounts(f.balance)},
          {"ms", ms},
          {"photonTracingMs", parts},
          {"framesPerSecond", f.framesPerSecond()},
          {"nsPerPhotonStep", f.nanosecondsPerStep()},
          {"nsPerVoxelCrossed", f.nanosecondsPerVoxelCrossed()},
          {"peakMemoryBytes", f.peakMemoryBytes},
          {"paper", f.paper ? paperReport(*f.paper) : Json()}};
}

} // namespace volcaustic::cli
