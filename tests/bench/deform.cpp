// One drag of a handle on a ball of that many rings (20,000 and 50,000 vertices), what the first one costs, and the
// search for self-intersections.
//   build/bench/bin/bench_deform

#include "volcaustic/deform.h"
#include "support/solids.h"

#include <benchmark/benchmark.h>

namespace volcaustic::test {
namespace {

std::vector<Deformer> dragged(double by) {
  std::vector<Deformer> steps(2);
  steps[0].center = {0, 0, -1};
  steps[1].center = {0, 0, 1};
  for (Deformer& step : steps) step.radius = .3;
  steps[1].placement = {.translate = {by, 0, .2}, .rotate = {0, 60 * by, 0}};
  return steps;
}

DeformOptions methodOf(const benchmark::State& state) {
  return {state.range(1) != 0 ? DeformMethod::Laplacian : DeformMethod::AsRigidAsPossible, 10};
}

void FirstDrag(benchmark::State& state) {
  const auto mesh = ball({0, 0, 0}, 1, static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(deformed(*mesh, dragged(.5), methodOf(state)));
}

void NextDrag(benchmark::State& state) {
  MeshDeformer deformer(ball({0, 0, 0}, 1, static_cast<int>(state.range(0))));
  (void)deformer.deform(dragged(.5), methodOf(state));
  double by = .5;
  for (auto _ : state) benchmark::DoNotOptimize(deformer.deform(dragged(by += .01), methodOf(state)));
}

void Brush(benchmark::State& state) {
  MeshDeformer deformer(ball({0, 0, 0}, 1, static_cast<int>(state.range(0))));
  Deformer brush;
  brush.type = static_cast<DeformerType>(state.range(1));
  brush.center = {0, 0, 1};
  brush.direction = {0, 0, 1};
  brush.radius = brush.strength = .5;
  for (auto _ : state) benchmark::DoNotOptimize(deformer.deform(std::span(&brush, 1)));
}

void SelfIntersectionSearch(benchmark::State& state) {
  const auto mesh = ball({0, 0, 0}, 1, static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(findSelfIntersections(*mesh));
}

constexpr std::int64_t kInflate = static_cast<std::int64_t>(DeformerType::Inflate);
constexpr std::int64_t kSmooth = static_cast<std::int64_t>(DeformerType::Smooth);

BENCHMARK(FirstDrag)
    ->ArgNames({"rings", "laplacian"})
    ->ArgsProduct({{100, 158}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(NextDrag)
    ->ArgNames({"rings", "laplacian"})
    ->ArgsProduct({{100, 158}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(Brush)
    ->ArgNames({"rings", "type"})
    ->ArgsProduct({{158}, {kInflate, kSmooth}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(SelfIntersectionSearch)->ArgName("rings")->Arg(100)->Arg(158)->Unit(benchmark::kMillisecond)->UseRealTime();

} // namespace
} // namespace volcaustic::test
