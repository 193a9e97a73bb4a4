// Deformation with merging: two drops are drawn together by handles, and become one where they meet.
// Usage: 08_merging_drops [RESOLUTION]   writes drops.0001.ply to drops.0006.ply, drops.0001.vdb to drops.0006.vdb and
// drops.png into the current folder.
#include <volcaustic/volcaustic.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

namespace vc = volcaustic;

namespace {

constexpr int kFrames = 6;
constexpr double kRadius = .35, kApart = .55; // of the drops, and of their centres from the middle

/// Two drops in one mesh: two parts, as far as topology is concerned.
std::shared_ptr<const vc::Mesh> drops(double cell) {
  const vc::Shape drop = vc::Shape::sphere(kRadius);
  return std::make_shared<const vc::Mesh>(
      vc::polygonise(drop.translated({-kApart, 0, 0}) | drop.translated({kApart, 0, 0}), {.cellSize = cell}));
}

vc::Scene scene(int resolution) {
  vc::Scene s;
  s.volume.automatic = false;
  s.volume.bounds = {{-1.2, -.8, -.8}, {1.2, .8, .8}};
  s.volume.resolution = resolution;
  s.volume.ambient.attenuation = s.volume.ambient.scattering = {.2, .2, .2};
  s.materials.front().index = 1.33;
  vc::SceneObject water;
  water.name = "drops";
  water.mesh = drops(.03);
  // Two handles hold each drop, one at its near and one at its far side; the rest of the drop follows them.
  for (const double side : {-1.0, 1.0})
    for (const double end : {-1.0, 1.0}) {
      vc::Deformer handle;
      handle.center = {side * kApart + end * side * kRadius, 0, 0};
      handle.radius = .12;
      water.deform.push_back(handle);
    }
  water.topology.topology = vc::Topology::Merge;
  water.topology.blend = .12;
  s.objects = {water};
  s.lights.resize(1);
  s.lights[0].direction = {0, .3, -1};
  s.lights[0].irradiance = {3, 3, 3};
  s.photons.grid = {4 * resolution, 4 * resolution};
  s.camera.position = {0, -4.5, 1.5};
  s.camera.resolution = {320, 240};
  return s;
}

int run(int resolution) {
  vc::Session session(scene(resolution));
  std::uint64_t first = 0, last = 0;
  bool closed = true;
  for (int frame = 1; frame <= kFrames; ++frame) {
    vc::Scene next = session.scene();
    constexpr double kSteps[] = {.07, .02, -.07,
                                 -.02}; // a frame: near and far side of the left, then of the right drop
    for (int i = 0; i < 4; ++i) next.objects[0].deform[i].placement.translate = {kSteps[i] * (frame - 1), 0, 0};
    session.setScene(next);
    const vc::Mesh mesh = *session.surface(0);
    const vc::MeshReport report = vc::checkMesh(mesh);
    const std::string number = "000" + std::to_string(frame);
    vc::writeMesh("drops." + number + ".ply", mesh);
    vc::writeVdb("drops." + number + ".vdb", session.photons(), session.medium());
    std::printf("frame %d: %llu part(s), volume %.4f, %zu triangles\n", frame,
                static_cast<unsigned long long>(report.closedShells), report.signedVolume, mesh.triangles.size());
    closed = closed && report.closedAndConsistent() && !vc::findSelfIntersections(mesh).any();
    if (frame == 1) first = report.closedShells;
    last = report.closedShells;
  }
  vc::writeImage("drops.png", session.view().image);
  return first == 2 && last == 1 && closed ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? std::atoi(argv[1]) : 128);
  } catch (const vc::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
