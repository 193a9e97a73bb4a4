#include "bench_interactive.h"

#include <volcaustic/error.h>
#include <volcaustic/live.h>
#include <volcaustic/session.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

using Clock = std::chrono::steady_clock;

double msSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Turned about the vertical axis, by radians.
Vec3d turned(const Vec3d& v, double angle) {
  return {std::cos(angle) * v[0] - std::sin(angle) * v[1], std::sin(angle) * v[0] + std::cos(angle) * v[1], v[2]};
}

struct Change {
  const char* name;
  void (*apply)(Scene&, int i); ///< state `i` of the change; each differs from all others
};

/// Also of a light that shines straight down.
void relight(Scene& s, int i) {
  for (Light& light : s.lights) {
    light.direction[0] += .2;
    light.direction = turned(light.direction, .01 * i);
    light.position = turned(light.position, .01 * i);
  }
}

void rematerial(Scene& s, int i) {
  for (Material& m : s.materials) {
    m.index += .002 * (i % 64 + 1);
    m.attenuation[1] += .01 * (i % 64 + 1);
  }
}

/// Twists the first object about the vertical axis through its middle.
void deform(Scene& s, int i) {
  SceneObject& o = s.objects.front();
  const Box box = bounds(*o.mesh);
  Deformer twist;
  twist.type = DeformerType::Twist;
  double radius = 0;
  for (int a = 0; a < 3; ++a) {
    twist.center[a] = (box.min[a] + box.max[a]) / 2;
    radius = std::max(radius, box.max[a] - box.min[a]);
  }
  twist.radius = radius;
  twist.direction = {0, 0, 1};
  twist.strength = .5 * (i + 1);
  o.deform = {twist};
}

void orbit(Scene& s, int i) {
  const Vec3d offset{s.camera.position[0] - s.camera.target[0], s.camera.position[1] - s.camera.target[1],
                     s.camera.position[2] - s.camera.target[2]};
  const Vec3d at = turned(offset, .01 * (i + 1));
  for (int a = 0; a < 3; ++a) s.camera.position[a] = s.camera.target[a] + at[a];
}

constexpr Change kChanges[] = {{"relight", relight}, {"material", rematerial}, {"deform", deform}, {"view", orbit}};

void measureWhole(const Scene& scene, const Change& change, int repeats, const RunContext& ctx,
                  ChangeFigures& figures) {
  Session session(scene, ctx);
  session.view();
  std::vector<double> whole;
  std::vector<std::pair<std::string, std::vector<double>>> stages;
  for (int i = 1; i <= repeats; ++i) {
    Scene next = scene;
    change.apply(next, i);
    const std::size_t before = session.runs().size();
    const auto start = Clock::now();
    session.setScene(std::move(next));
    session.view();
    whole.push_back(msSince(start));
    for (std::size_t r = before; r < session.runs().size(); ++r) {
      const StageRun& run = session.runs()[r];
      const auto known =
          std::find_if(stages.begin(), stages.end(), [&](const auto& s) { return s.first == run.stage; });
      if (known == stages.end())
        stages.push_back({run.stage, {run.milliseconds}});
      else
        known->second.push_back(run.milliseconds);
    }
  }
  figures.wholeMs = median(whole);
  for (const auto& [stage, ms] : stages) figures.stages.emplace_back(stage, median(ms));
}

void measureMoving(const Scene& scene, const Change& change, double movingMs, RunContext ctx, ChangeFigures& figures) {
  ctx.onProgress = nullptr;
  LiveSession live(scene, {}, ctx);
  (void)live.wait(1);
  std::vector<double> between;
  const auto start = Clock::now();
  for (int i = 1; msSince(start) < movingMs || between.size() < 3; ++i) {
    Scene next = scene;
    change.apply(next, i);
    const auto before = Clock::now();
    const auto frame = live.wait(live.setScene(std::move(next)), LiveOptions{}.greatestReduction);
    if (!frame->error.empty()) throw Error(ErrorKind::Device, figures.change + ": " + frame->error);
    between.push_back(msSince(before));
    figures.reduction = frame->reduction;
  }
  figures.movingMs = median(between);
}

} // namespace

InteractiveFigures measureInteractive(const BenchScene& scene, const BenchSize& size, int repeats, double movingMs,
                                      const RunContext& ctx) {
  InteractiveFigures figures{scene.name, {}};
  const Scene whole = sessionScene(scene, size);
  for (const Change& change : kChanges) {
    ChangeFigures& f = figures.changes.emplace_back();
    f.change = change.name;
    measureWhole(whole, change, repeats, ctx, f);
    measureMoving(whole, change, movingMs, ctx, f);
    ctx.progress(scene.name, static_cast<double>(figures.changes.size()) / std::size(kChanges));
  }
  return figures;
}

Json interactiveReport(const InteractiveFigures& figures) {
  Json changes = Json::array();
  for (const ChangeFigures& f : figures.changes) {
    Json stages = Json::object();
    for (const auto& [stage, ms] : f.stages) stages[stage] = ms;
    changes.push_back(
        {{"change", f.change},
         {"ms", f.wholeMs},
         {"stageMs", std::move(stages)},
         {"moving", {{"ms", f.movingMs}, {"framesPerSecond", 1000 / f.movingMs}, {"reduction", f.reduction}}}});
  }
  return {{"scene", figures.scene}, {"changes", std::move(changes)}};
}

void printInteractive(const std::string& title, const std::vector<InteractiveFigures>& scenes) {
  fmt::print("{}\n", title);
  fmt::print("{:<8} {:<10} {:>9} {:>7}   {:<44} {:>10} {:>6} {:>9}\n", "scene", "change", "whole ms", "fps",
             "stages, ms", "moving ms", "fps", "reduced");
  for (const InteractiveFigures& scene : scenes)
    for (const ChangeFigures& f : scene.changes) {
      std::string stages;
      for (const auto& [stage, ms] : f.stages)
        stages += fmt::format("{}{} {:.0f}", stages.empty() ? "" : ", ", stage, ms);
      fmt::print("{:<8} {:<10} {:>9.1f} {:>7.1f}   {:<44} {:>10.1f} {:>6.1f} {:>8}x\n", scene.scene, f.change,
                 f.wholeMs, 1000 / f.wholeMs, stages, f.movingMs, 1000 / f.movingMs, f.reduction);
    }
}

} // namespace volcaustic::cli
