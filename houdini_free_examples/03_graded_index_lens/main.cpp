// A Luneburg lens: an index volume that no mesh describes. n = sqrt(2 - (r/R)^2) inside, 1 outside; parallel light
// meets at one point of the far surface. Usage: 03_graded_index_lens [RESOLUTION]   writes luneburg.vdb, .exr and .png
// into the current folder.
#include <volcaustic/volcaustic.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace vc = volcaustic;

namespace {

constexpr double kRadius = 1;
/// Distance, in voxels, from the brightest voxel to the point where the light should meet.
constexpr double kFocusTolerance = 2;

double luneburgIndex(const vc::Vec3d& pWorld) {
  const double r = std::hypot(pWorld[0], pWorld[1], pWorld[2]) / kRadius;
  return r < 1 ? std::sqrt(2 - r * r) : 1;
}

/// World position of the centre of the voxel with the most light.
vc::Vec3d brightestVoxel(const vc::RadianceVolume& light) {
  const vc::Domain& domain = light.domain();
  vc::Vec3d best{0, 0, 0};
  float most = -1;
  for (int x = 0; x < domain.dims[0]; ++x) {
    for (int y = 0; y < domain.dims[1]; ++y) {
      for (int z = 0; z < domain.dims[2]; ++z) {
        const float fluence = light.fluence({x, y, z})[1];
        if (fluence <= most) continue;
        most = fluence;
        for (int axis = 0; axis < 3; ++axis) {
          const int voxel[] = {x, y, z};
          best[axis] = domain.minCorner[axis] + (voxel[axis] + 0.5) * domain.voxelSize;
        }
      }
    }
  }
  return best;
}

int run(int resolution) {
  const vc::Domain domain = vc::domainAround({{-1.3, -1.3, -1.6}, {1.3, 1.3, 1.3}}, resolution, 0, 0);
  vc::Ambient fog;
  fog.attenuation = fog.scattering = {0.15, 0.15, 0.15};
  const vc::Medium lens = vc::sampleMedium(domain, fog, luneburgIndex);

  std::vector<vc::Light> lights(1);
  lights[0].direction = {0, 0, -1};
  lights[0].irradiance = {3, 3, 3};
  vc::PhotonOptions options;
  options.grid = {6 * resolution, 6 * resolution};
  const vc::PhotonResult photons = vc::tracePhotons(lens, lights, {}, options);
  vc::writeVdb("luneburg.vdb", photons.radiance, lens);

  const vc::Camera camera{.position = {0, -7, -0.15},
                          .target = {0, 0, -0.15},
                          .fieldOfView = 17.2,
                          .resolution = {4 * resolution, 4 * resolution}};
  const vc::Background night{.bottom = {0.001, 0.0015, 0.003}, .top = {0.004, 0.006, 0.012}};
  const vc::ViewResult view = vc::renderView(lens, photons.radiance, camera, night);
  vc::writeImage("luneburg.exr", view.image);
  vc::writeImage("luneburg.png", view.image);

  const vc::Vec3d p = brightestVoxel(photons.radiance);
  const double off = std::hypot(p[0], p[1], p[2] + kRadius) / domain.voxelSize;
  std::printf("brightest voxel at (%.4f, %.4f, %.4f); a Luneburg lens focuses at (0, 0, %.4f): off by %.2f voxels\n",
              p[0], p[1], p[2], -kRadius, off);
  return off <= kFocusTolerance ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? std::atoi(argv[1]) : 160);
  } catch (const vc::Error& error) {
    std::fprintf(stderr, "03_graded_index_lens: %s\n", error.what());
    return 3;
  }
}
