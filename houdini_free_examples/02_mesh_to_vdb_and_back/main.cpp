// There and back: mesh file -> sparse volume of glass (.vdb) -> iso-surface -> mesh file, with what was lost on the
// way. Usage: 02_mesh_to_vdb_and_back [RESOLUTION [MESH]]   writes there.vdb and back.ply into the current folder.
#include <volcaustic/volcaustic.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace vc = volcaustic;

namespace {

/// The iso-surface cuts corners by a fraction of a voxel, so the lost volume is bounded by area times voxel.
constexpr double kLostShare = 0.05;

/// A mesh file as glass on a grid of `resolution` voxels along its longest side.
vc::Medium voxelised(const vc::Mesh& mesh, int resolution) {
  const vc::VoxeliseOptions options;
  const vc::Domain domain = vc::domainAround(vc::bounds(mesh), resolution, 0, options.blur);
  std::vector<vc::Body> bodies(1);
  bodies[0].mesh = std::make_shared<const vc::Mesh>(mesh);
  return vc::buildMedium(bodies, vc::Ambient{}, domain, options);
}

void print(const char* name, const vc::MeshReport& report) {
  std::printf("%-6s %9llu triangles, volume %.6f, area %.6f, %llu open edges\n", name,
              static_cast<unsigned long long>(report.triangles), report.signedVolume, report.area,
              static_cast<unsigned long long>(report.openEdges));
}

int run(int resolution, const char* path) {
  const vc::Mesh there = vc::readMesh(path);
  const vc::Medium medium = voxelised(there, resolution);
  vc::writeVdb("there.vdb", medium);
  const vc::Mesh back = vc::surfaceFromVdb("there.vdb");
  vc::writeMesh("back.ply", back);

  const vc::MeshReport before = vc::checkMesh(there), after = vc::checkMesh(back);
  const double voxel = medium.domain().voxelSize;
  const double lost = after.signedVolume - before.signedVolume;
  print("there", before);
  print("back", after);
  std::printf("difference in volume %+.6f (%+.3f %%), a layer of %.4f voxels over the surface\n", lost,
              100 * lost / before.signedVolume, lost / (before.area * voxel));
  const bool closed = after.openEdges == 0;
  return closed && std::abs(lost) <= kLostShare * before.area * voxel ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? std::atoi(argv[1]) : 256, argc > 2 ? argv[2] : "data/meshes/torus_knot.ply");
  } catch (const vc::Error& error) {
    std::fprintf(stderr, "02_mesh_to_vdb_and_back: %s\n", error.what());
    return 3;
  }
}
