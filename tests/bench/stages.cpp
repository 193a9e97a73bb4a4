// The stages of a frame at the size of the paper's table: 256^3 voxels, a ball of 90, 1024^2 photons, 1024 x 768
// pixels.
//   build/bench/bin/bench_stages [--benchmark_filter=Photons]

#include "support/fields.h"
#include "support/solids.h"
#include "transport/passes.h"
#include "volcaustic/photons.h"
#include "volcaustic/view.h"

#include <benchmark/benchmark.h>

namespace volcaustic::test {
namespace {

constexpr double kRadius = 45.0 / 256;

Medium glassBall(const Ambient& ambient = {}) {
  Body body;
  body.mesh = ball({.5, .5, .6}, kRadius, 115); // 53K triangles
  return buildMedium(std::span(&body, 1), ambient, unitCube(256));
}

void Voxelise(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(glassBall());
}

void StepFieldAndFlatten(benchmark::State& state) {
  const Medium medium = glassBall();
  std::size_t bytes = 0;
  for (auto _ : state) bytes = flattenMedium(medium, {}, {}).memoryBytes();
  state.counters["MiB"] = static_cast<double>(bytes) / (1 << 20);
}

void Photons(benchmark::State& state) {
  const Medium medium = glassBall();
  const FlatMediumStorage flat = flattenMedium(medium, {}, {});
  const Light sun;
  EnergyBalance balance;
  for (auto _ : state) balance = tracePhotons(medium, flat, std::span(&sun, 1), {}, {}, {}).balance;
  state.counters["traced"] = static_cast<double>(balance.photonsTraced);
  state.counters["steps"] = static_cast<double>(balance.steps);
  state.counters["voxelsCrossed"] = static_cast<double>(balance.voxelsCrossed);
}

void View(benchmark::State& state) {
  Ambient ambient;
  if (state.range(0)) ambient.attenuation = ambient.scattering = {.2, .2, .2};
  const Medium medium = glassBall(ambient);
  const FlatMediumStorage flat = flattenMedium(medium, {}, {});
  const Light sun;
  const RadianceVolume radiance = tracePhotons(medium, flat, std::span(&sun, 1), {}, {}, {}).radiance;
  Camera camera;
  camera.position = {.5, -2, .6};
  camera.target = {.5, .5, .5};
  std::int64_t steps = 0;
  for (auto _ : state) steps = renderView(medium, flat, radiance, {}, camera, {}, {}, {}).steps;
  state.counters["steps"] = static_cast<double>(steps);
}

BENCHMARK(Voxelise)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(StepFieldAndFlatten)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(Photons)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(View)->ArgName("fog")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();

} // namespace
} // namespace volcaustic::test
