// Voxelising alone: this library at 4x4x4 sub-voxels against openvdb::tools::meshToVolume with sdfToFogVolume, which
// has none, on the same triangles and voxels. The third argument of a name is voxels along the longest side. Reading
// and writing are left out; whole commands are compared by tools/dev/compare_peers.
//   build/bench/bin/bench_mesh_to_volume [--benchmark_filter=head/256]
// Labels: what the fill encloses, relative to the signed volume of the surface (of a closed one 1 is right).

#include "support/shared_data.h"
#include "volcaustic/medium.h"
#include "volcaustic/openvdb.h"

#include <benchmark/benchmark.h>
#include <cmath>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/MeshToVolume.h>

namespace volcaustic::test {
namespace {

constexpr int kPadding = 8;

struct Case {
  const char* name;
  const char* file;
};
constexpr Case kCases[] = {{"head", "data/meshes_clean/nefertiti_100k.obj"},
                           {"open_bunny", "data/meshes_messy/bunny_original_69k.ply"},
                           {"dragon", "data/meshes_clean/dragon_100k.obj"}};

/// Sum of a fog volume's active values over what the surface encloses.
std::string filled(const openvdb::FloatGrid& fog, double voxelSize, const Mesh& mesh) {
  double sum = 0;
  for (auto value = fog.cbeginValueOn(); value; ++value) sum += *value * double(value.getVoxelCount());
  return "volume x " + std::to_string(sum * std::pow(voxelSize, 3) / std::abs(checkMesh(mesh).signedVolume));
}

void coverage(benchmark::State& state, const Case& which, int resolution) {
  const auto mesh = std::make_shared<const Mesh>(readMesh(sharedPath(which.file)));
  const Domain domain = domainAround(bounds(*mesh), resolution, 0, kPadding);
  Body body;
  body.mesh = mesh;
  Medium medium;
  for (auto _ : state) medium = buildMedium({&body, 1}, {}, domain, {.blur = 1});
  state.SetLabel(filled(*medium.grids().coverage, domain.voxelSize, *mesh));
}

void meshToFog(benchmark::State& state, const Case& which, int resolution) {
  openvdb::initialize();
  const Mesh mesh = readMesh(sharedPath(which.file));
  const double voxelSize = domainAround(bounds(mesh), resolution, 0, kPadding).voxelSize;
  const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
  std::vector<openvdb::Vec3s> points;
  for (const Vec3d& p : mesh.positions) points.push_back(transform->worldToIndex(openvdb::Vec3d(p[0], p[1], p[2])));
  std::vector<openvdb::Vec3I> triangles;
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> adapter(points, triangles);
  openvdb::FloatGrid::Ptr fog;
  for (auto _ : state) {
    fog = openvdb::tools::meshToVolume<openvdb::FloatGrid>(adapter, *transform);
    openvdb::tools::sdfToFogVolume(*fog);
  }
  state.SetLabel(filled(*fog, voxelSize, mesh));
}

void registerAll() {
  for (const Case& which : kCases) {
    if (!std::filesystem::exists(sharedPath(which.file))) continue;
    for (const int resolution : {256, 512}) {
      const std::string suffix = std::string("/") + which.name + "/" + std::to_string(resolution);
      const auto add = [&](const char* name, auto body) {
        benchmark::RegisterBenchmark((name + suffix).c_str(),
                                     [body, &which, resolution](benchmark::State& s) { body(s, which, resolution); })
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime()
            ->MeasureProcessCPUTime();
      };
      add("Volcaustic", coverage);
      add("MeshToVolume", meshToFog);
    }
  }
}

} // namespace
} // namespace volcaustic::test

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  volcaustic::test::registerAll();
  benchmark::RunSpecifiedBenchmarks();
}
