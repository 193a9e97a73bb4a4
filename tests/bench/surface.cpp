// The way back, against a plain call of OpenVDB's mesher on the same grid: the coverage of a ball of 90 or 240 voxels.
//   build/bench/bin/bench_surface

#include "support/fields.h"
#include "support/solids.h"
#include "volcaustic/openvdb.h"

#include <benchmark/benchmark.h>
#include <openvdb/tools/VolumeToMesh.h>

namespace volcaustic::test {
namespace {

Medium solidBall(std::int64_t voxels) {
  Body body;
  body.mesh = ball({.5, .5, .5}, static_cast<double>(voxels) / 512, 115);
  return buildMedium(std::span(&body, 1), {}, unitCube(256));
}

void OpenVdbVolumeToMesh(benchmark::State& state) {
  const Medium medium = solidBall(state.range(0));
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  for (auto _ : state) openvdb::tools::volumeToMesh(*medium.grids().coverage, points, triangles, quads, .5, 0.0);
  state.counters["vertices"] = static_cast<double>(points.size());
}

void Surface(benchmark::State& state) {
  const Medium medium = solidBall(state.range(0));
  SurfaceOptions options;
  options.sharpen = state.range(1) != 0;
  std::size_t vertices = 0;
  for (auto _ : state) vertices = surfaceFromMedium(medium, options).positions.size();
  state.counters["vertices"] = static_cast<double>(vertices);
}

BENCHMARK(OpenVdbVolumeToMesh)->ArgName("voxels")->Arg(90)->Arg(240)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(Surface)
    ->ArgNames({"voxels", "sharpen"})
    ->ArgsProduct({{90, 240}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

} // namespace
} // namespace volcaustic::test
