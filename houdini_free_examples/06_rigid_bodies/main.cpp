// Glass bodies fall through a beam of light and come to rest on a floor. Usage: 06_rigid_bodies [RESOLUTION [FRAMES]]
// writes beam.0001.vdb, beam.0001.png and so on into the current folder.
#include <volcaustic/volcaustic.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

namespace vc = volcaustic;

namespace {

constexpr int kSimulated = 73; // three seconds, which is enough to come to rest

vc::SceneObject body(const char* name, const vc::Shape& shape, const vc::Vec3d& at, const vc::Vec3d& turned) {
  vc::SceneObject object;
  object.name = name;
  object.mesh = std::make_shared<const vc::Mesh>(vc::polygonise(shape, {.resolution = 40}));
  object.placement.translate = at;
  object.placement.rotate = turned;
  return object;
}

vc::Scene makeScene(int resolution) {
  vc::Scene scene;
  scene.volume.automatic = false;
  scene.volume.bounds = {{-1.4, -.8, -.05}, {1.4, .8, 1.75}};
  scene.volume.resolution = resolution;
  scene.volume.ambient.attenuation = scene.volume.ambient.scattering = {.25, .25, .25};
  scene.objects = {body("ball", vc::Shape::sphere(.24), {-.6, 0, 1.3}, {0, 0, 0}),
                   body("cube", vc::Shape::cuboid({.4, .4, .4}), {.05, .05, 1.4}, {20, 30, 0}),
                   body("egg", vc::Shape::ellipsoid({.2, .2, .32}), {.65, -.05, 1.35}, {0, 60, 0})};
  vc::Light lamp;
  lamp.name = "beam";
  lamp.type = vc::LightType::Spot;
  lamp.position = {-2.6, 0, 1.9};
  lamp.direction = {1, 0, -.5};
  lamp.outerAngle = 12;
  lamp.innerAngle = 10;
  lamp.intensity = {130, 124, 110};
  scene.lights = {lamp};
  vc::SceneReceiver floor;
  floor.name = "floor";
  floor.placement.scale = {8, 8, 1};
  floor.albedo = {.4, .4, .42};
  scene.receivers = {floor};
  scene.photons.grid = {4 * resolution, 4 * resolution};
  scene.camera = {.position = {.4, -4.2, 1.5}, .target = {0, 0, .7}, .fieldOfView = 34};
  scene.camera.resolution = {4 * resolution, 3 * resolution};
  scene.background = {.bottom = {.01, .012, .02}, .top = {.03, .035, .05}};
  return scene;
}

/// The objects as they fall, the floor as it is.
std::vector<vc::RigidBody> rigidBodies(const vc::Scene& scene) {
  std::vector<vc::RigidBody> bodies;
  for (const vc::SceneObject& object : scene.objects)
    bodies.push_back({.name = object.name, .mesh = object.mesh, .placement = object.placement, .spin = {40, 90, 0}});
  vc::Mesh square;
  square.positions = {{-.5, -.5, 0}, {.5, -.5, 0}, {.5, .5, 0}, {-.5, .5, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  bodies.push_back({.name = "floor",
                    .mesh = std::make_shared<const vc::Mesh>(square),
                    .placement = scene.receivers.front().placement,
                    .fixed = true});
  return bodies;
}

/// Height of the lowest point of what moves.
double lowestPoint(const std::vector<vc::RigidBody>& bodies, const std::vector<vc::Placement>& placements) {
  double lowest = 1e9;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (!bodies[i].fixed)
      lowest = std::min(lowest, vc::bounds(vc::transformed(*bodies[i].mesh, vc::affine(placements[i]))).min[2]);
  return lowest;
}

int run(int resolution, int frames) {
  vc::Scene scene = makeScene(resolution);
  const std::vector<vc::RigidBody> bodies = rigidBodies(scene);
  const auto placements = vc::simulateRigidBodies(bodies, kSimulated);

  double lowest = 1e9, imbalance = 0;
  for (const auto& frame : placements) lowest = std::min(lowest, lowestPoint(bodies, frame));
  std::printf("lowest point of all frames %.4f above the floor, at rest %.4f\n", lowest,
              lowestPoint(bodies, placements.back()));

  vc::Session session(scene);
  for (int frame = 1; frame <= std::min(frames, kSimulated); ++frame) {
    for (std::size_t i = 0; i < scene.objects.size(); ++i) scene.objects[i].placement = placements[frame - 1][i];
    session.setScene(scene);
    const vc::PhotonResult& photons = session.photons();
    imbalance = std::max(imbalance, std::abs(photons.balance.relativeImbalance()));
    vc::writeVdb(vc::withFrame("beam.####.vdb", frame), photons, session.medium());
    vc::writeImage(vc::withFrame("beam.####.png", frame), session.view().image);
    std::printf("frame %d: %.2f W land on the floor\n", frame, photons.balance.received[1]);
  }
  std::printf("energy balance to %.1e\n", imbalance);
  return lowest > -.02 && lowestPoint(bodies, placements.back()) < .01 && imbalance < 1e-3 ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? std::atoi(argv[1]) : 128, argc > 2 ? std::atoi(argv[2]) : 24);
  } catch (const vc::Error& error) {
    std::fprintf(stderr, "06_rigid_bodies: %s\n", error.what());
    return 3;
  }
}
