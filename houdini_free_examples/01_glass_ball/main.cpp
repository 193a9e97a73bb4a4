// A glass ball in fog under parallel light: mesh -> index volume -> photons -> volume of light -> picture.
// Usage: 01_glass_ball [RESOLUTION]   writes glass_ball.vdb, .exr and .png into the current folder.
#include <volcaustic/volcaustic.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <numbers>
#include <utility>

namespace vc = volcaustic;

namespace {

constexpr double kIndex = 1.5;
constexpr double kRadius = 1;
/// The smoothed voxel surface bends paraxial rays nearly as the sharp one does; the difference shrinks with the voxel.
constexpr double kFocusTolerance = 0.02;

/// The unit sphere: an octahedron whose triangles are split in four and pushed out, `levels` times.
vc::Mesh sphere(int levels) {
  vc::Mesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, isNew] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.positions.size()));
      if (isNew) {
        const vc::Vec3d &p = mesh.positions[a], &q = mesh.positions[b];
        const double length = std::hypot(p[0] + q[0], p[1] + q[1], p[2] + q[2]);
        mesh.positions.push_back({(p[0] + q[0]) / length, (p[1] + q[1]) / length, (p[2] + q[2]) / length});
      }
      return found->second;
    };
    std::vector<std::array<std::uint32_t, 3>> split;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      split.insert(split.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(split);
  }
  return mesh;
}

vc::Scene glassBallScene(int resolution) {
  vc::Scene scene;
  scene.volume.automatic = false;
  scene.volume.bounds = {{-1.4, -1.1, -2.6}, {1.4, 1.1, 1.4}};
  scene.volume.resolution = resolution;
  scene.volume.ambient.attenuation = scene.volume.ambient.scattering = {0.1, 0.1, 0.1}; // fog: nothing is absorbed
  scene.materials = {{.name = "glass", .index = kIndex}};
  vc::SceneObject ball;
  ball.mesh = std::make_shared<const vc::Mesh>(sphere(6));
  scene.objects = {ball};
  vc::Light light;
  light.direction = {0, 0, -1};
  light.irradiance = {3, 3, 3};
  scene.lights = {light};
  scene.photons.grid = {6 * resolution, 6 * resolution};
  scene.camera = {.position = {0, -8, -0.6},
                  .target = {0, 0, -0.6},
                  .fieldOfView = 23,
                  .resolution = {3 * resolution, 4 * resolution}};
  scene.background = {.bottom = {0.001, 0.0015, 0.003}, .top = {0.004, 0.006, 0.012}};
  return scene;
}

/// Distance behind the ball's centre where rays of height `h` cross the axis, the mean over a ring of rays.
double axisCrossing(const vc::Medium& medium, double h) {
  constexpr int kRays = 128;
  std::vector<vc::TracedRay> rays(kRays);
  for (int i = 0; i < kRays; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / kRays;
    rays[i].position = {h * std::cos(angle), h * std::sin(angle), 1.3};
    rays[i].direction = {0, 0, -1};
  }
  vc::traceRays(medium, rays);
  double sum = 0;
  for (const vc::TracedRay& ray : rays) {
    // Closest approach of the straight exit ray to the axis.
    const vc::Vec3d &p = ray.position, &d = ray.direction;
    const double along = -(p[0] * d[0] + p[1] * d[1]) / (d[0] * d[0] + d[1] * d[1]);
    sum -= p[2] + along * d[2];
  }
  return sum / kRays;
}

/// Where rays on the axis would cross it: spherical aberration draws the crossing of rays at height h nearer by c h^2,
/// so a straight line through the crossings over h^2, taken to zero.
double paraxialFocus(const vc::Medium& medium) {
  constexpr int kRings = 13;
  double sumX = 0, sumY = 0, sumXX = 0, sumXY = 0;
  for (int ring = 0; ring < kRings; ++ring) {
    const double h = kRadius * (0.2 + 0.3 * ring / (kRings - 1));
    const double x = h * h, y = axisCrossing(medium, h);
    sumX += x;
    sumY += y;
    sumXX += x * x;
    sumXY += x * y;
  }
  const double slope = (kRings * sumXY - sumX * sumY) / (kRings * sumXX - sumX * sumX);
  return (sumY - slope * sumX) / kRings;
}

/// The brightest place on the axis below the ball: distance behind the centre and fluence there.
std::pair<double, double> brightestOnAxis(const vc::RadianceVolume& light) {
  const vc::Domain& domain = light.domain();
  const int x = domain.dims[0] / 2, y = domain.dims[1] / 2;
  std::pair<double, double> best{0, 0};
  for (int z = 0; z < domain.dims[2]; ++z) {
    const double height = domain.minCorner[2] + (z + 0.5) * domain.voxelSize;
    const double fluence = light.fluence({x, y, z})[1];
    if (height < -kRadius && fluence > best.second) best = {-height, fluence};
  }
  return best;
}

int run(int resolution) {
  vc::Session session(glassBallScene(resolution));
  const vc::PhotonResult& photons = session.photons();
  vc::writeVdb("glass_ball.vdb", photons.radiance, session.medium());
  const vc::Image& image = session.view().image;
  vc::writeImage("glass_ball.exr", image);
  vc::writeImage("glass_ball.png", image);

  const double expected = kIndex * 2 * kRadius / (4 * (kIndex - 1));
  const double focus = paraxialFocus(session.medium());
  const double error = std::abs(focus / expected - 1);
  const auto [brightest, fluence] = brightestOnAxis(photons.radiance);
  std::printf("focus of rays on the axis     %.4f behind the centre; nD/(4(n-1)) = %.4f, off by %.2f %%\n", focus,
              expected, 100 * error);
  std::printf("brightest voxel on the axis   %.4f behind the centre, %.1f W/m2 in light of 3 W/m2\n", brightest,
              fluence);
  std::printf("energy unaccounted for        %.1e of what the light emitted\n", photons.balance.relativeImbalance());
  return error <= kFocusTolerance ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? std::atoi(argv[1]) : 160);
  } catch (const vc::Error& error) {
    std::fprintf(stderr, "01_glass_ball: %s\n", error.what());
    return 3;
  }
}
