// Two balls of that many rings that run into each other, merged with a blend, sharply, and kept apart; and a peanut cut
// at its neck.
//   build/bench/bin/bench_topology

#include "volcaustic/topology.h"
#include "support/solids.h"

#include <benchmark/benchmark.h>
#include <cmath>

namespace volcaustic::test {
namespace {

Mesh twoBalls(int rings) {
  Mesh mesh = ellipsoid({0, 0, 0}, {1, 1, 1}, rings);
  const Mesh other = ellipsoid({1.8, .01, .02}, {1, 1, 1}, rings);
  const auto offset = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const auto& t : other.triangles) mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return mesh;
}

/// A ball drawn out to three lengths, with a waist of a tenth of its width.
Mesh peanut(int rings) {
  Mesh mesh = ellipsoid({0, 0, 0}, {1, 1, 1}, rings);
  for (Vec3d& p : mesh.positions) {
    const double waist = 1 - .9 * std::exp(-p[2] * p[2] / .05);
    p = {p[0] * waist, p[1] * waist, 3 * p[2]};
  }
  return mesh;
}

void run(benchmark::State& state, const Mesh& mesh, const TopologyOptions& options) {
  TopologyResult result;
  for (auto _ : state) result = controlTopology(mesh, options);
  state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
  state.counters["kept"] = static_cast<double>(result.keptTriangles);
  state.counters["new"] = static_cast<double>(result.newTriangles);
  state.counters["parts"] = static_cast<double>(result.partsAfter);
}

void MergeWithBlend(benchmark::State& state) {
  run(state, twoBalls(static_cast<int>(state.range(0))), {.topology = Topology::Merge, .blend = .1});
}
void MergeSharply(benchmark::State& state) {
  run(state, twoBalls(static_cast<int>(state.range(0))), {.topology = Topology::Merge});
}
void KeepApart(benchmark::State& state) {
  run(state, twoBalls(static_cast<int>(state.range(0))), {.topology = Topology::Keep, .gap = .05});
}
void SplitAtNeck(benchmark::State& state) {
  run(state, peanut(static_cast<int>(state.range(0))), {.topology = Topology::Split, .neck = .3});
}

BENCHMARK(MergeWithBlend)->ArgName("rings")->Arg(71)->Arg(158)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(MergeSharply)->ArgName("rings")->Arg(71)->Arg(158)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(KeepApart)->ArgName("rings")->Arg(71)->Arg(158)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(SplitAtNeck)->ArgName("rings")->Arg(71)->Arg(158)->Unit(benchmark::kMillisecond)->UseRealTime();

} // namespace
} // namespace volcaustic::test
