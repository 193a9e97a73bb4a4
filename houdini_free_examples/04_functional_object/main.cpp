// A functional object: a paperweight of a few quadrics, written as an expression, changed by one coefficient from frame
// to frame. Usage: 04_functional_object [RESOLUTION]   writes paperweight.ply, paperweight.0001.vdb to .0004.vdb and
// paperweight.png into the current folder.
#include <volcaustic/volcaustic.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace vc = volcaustic;

namespace {

constexpr int kFrames = 4;

/// An ellipsoid on a flat foot with five petals, which are deviation functions, around a bubble of air.
vc::Shape paperweight(double petals) {
  vc::Shape glass = vc::Shape::ellipsoid({1, 1, .8});
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * 3.14159265358979 * i / 5;
    glass = glass.bulge(vc::Shape::sphere(.6).translated({.8 * std::cos(angle), .8 * std::sin(angle), 0}), petals);
  }
  const vc::Shape foot = vc::Shape::plane({0, 0, -1}, .55);
  const vc::Shape bubble = vc::Shape::sphere(.22).translated({0, 0, .15});
  return (glass & foot) - bubble;
}

/// Greatest value of the shape at the vertices, which should lie on its surface, where it is 0.
double farthestVertex(const vc::Shape& shape, const vc::Mesh& mesh) {
  std::vector<double> values(mesh.positions.size());
  vc::ShapeField(shape).values(mesh.positions, values);
  double farthest = 0;
  for (const double value : values) farthest = std::max(farthest, std::abs(value));
  return farthest;
}

int run(int resolution) {
  const vc::Domain domain = vc::domainAround({{-2, -2, -2.2}, {2, 2, 1.2}}, resolution, 0, 0);
  vc::Ambient fog;
  fog.attenuation = fog.scattering = {.1, .1, .1};
  vc::Body body;
  body.name = "paperweight";
  body.material.index = 1.5;
  std::vector<vc::Light> lights(1);
  lights[0].direction = {.3, .2, -1};
  lights[0].irradiance = {3, 3, 3};
  vc::PhotonOptions options;
  options.grid = {4 * resolution, 4 * resolution};

  vc::Polygoniser polygoniser; // keeps what does not change from frame to frame
  double worst = 0, before = 0;
  bool grows = true;
  for (int frame = 1; frame <= kFrames; ++frame) {
    const vc::Shape shape = paperweight(.5 * frame);
    const vc::Mesh mesh = polygoniser.polygonise(shape, {.cellSize = .5 * domain.voxelSize});
    if (frame == 1) vc::writeMesh("paperweight.ply", mesh);
    const double off = farthestVertex(shape, mesh) / domain.voxelSize, volume = vc::checkMesh(mesh).signedVolume;
    worst = std::max(worst, off);
    grows = grows && volume > before;
    before = volume;
    const vc::PolygoniseReport& report = polygoniser.report();
    std::printf("frame %d: %zu triangles, volume %.4f, vertices within %.4f voxels of the surface; %llu of %llu blocks "
                "as before\n",
                frame, mesh.triangles.size(), volume, off, static_cast<unsigned long long>(report.reusedBlocks),
                static_cast<unsigned long long>(report.blocks));

    body.shape = shape; // no triangles: the shape itself decides what is inside
    const vc::Medium medium = vc::buildMedium(std::span(&body, 1), fog, domain);
    const vc::PhotonResult photons = vc::tracePhotons(medium, lights, {}, options);
    vc::writeVdb("paperweight.000" + std::to_string(frame) + ".vdb", photons.radiance, medium);
    if (frame == kFrames) {
      const vc::Camera camera{.position = {1.5, -6, 3}, .target = {0, 0, -.4}, .fieldOfView = 32};
      const vc::Background dusk{.bottom = {.01, .015, .03}, .top = {.05, .07, .12}};
      vc::writeImage("paperweight.png", vc::renderView(medium, photons.radiance, camera, dusk).image);
    }
  }
  return worst < .05 && grows ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? std::atoi(argv[1]) : 128);
  } catch (const vc::Error& error) {
    std::fprintf(stderr, "04_functional_object: %s\n", error.what());
    return 3;
  }
}
