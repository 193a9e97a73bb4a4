// A jet of syrup rises in water and mixes with it; light that falls through both draws its eddies on a wall. Usage:
// 07_turbulent_mixing [RESOLUTION [FRAMES]] writes mix.0001.vdb (the fluids), light.0001.vdb (the light),
// light.0001.png and so on, and mixing.json, which renders them again, into the current folder.
#include <volcaustic/volcaustic.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

namespace vc = volcaustic;

namespace {

/// Index 1.33 is water; the pure second fluid has .05 more.
constexpr const char* kScene = R"({
  "volcaustic": 1,
  "volume": {"bounds": {"min": [-0.5, -0.5, -0.5], "max": [0.5, 0.8, 0.5]}, "index": 1.33},
  "objects": [{
    "name": "mixing", "volume": "mix.####.vdb",
    "grids": [{"name": "concentration", "property": "index", "scale": [0.05, 0.05, 0.05], "offset": [1.33, 1.33, 1.33]}]
  }],
  "lights": [{"name": "sun", "direction": [0, 1, 0], "irradiance": [1.6, 1.56, 1.48]}],
  "receivers": [{"name": "wall", "translate": [0, 0.79, 0], "rotate": [90, 0, 0], "scale": [1, 1, 1]}],
  "camera": {"position": [0, -1.6, 0], "target": [0, 0, 0], "fieldOfView": 28, "resolution": [512, 512]},
  "background": {"bottom": [0, 0, 0], "top": [0, 0, 0]},
  "frames": {"first": 1, "last": 48, "rate": 24}
}
)";

vc::Scene sceneAt(int frame, int resolution) {
  const std::string cells = std::to_string(resolution), rays = std::to_string(4 * resolution);
  vc::SceneReadOptions options;
  options.frame = frame;
  options.sets = {"volume.resolution=" + cells, "photons.grid=[" + rays + "," + rays + "]"};
  return vc::parseScene(kScene, "mixing.json", options);
}

double amount(const vc::MixingSimulation& flow) {
  const vc::Domain& domain = flow.domain();
  double cells = 0;
  for (int k = 0; k < domain.dims[2]; ++k)
    for (int j = 0; j < domain.dims[1]; ++j)
      for (int i = 0; i < domain.dims[0]; ++i) cells += flow.concentration({i, j, k});
  return cells * domain.voxelSize * domain.voxelSize * domain.voxelSize;
}

/// Whether the second fluid has come to the open top, where it leaves.
bool isLeaving(const vc::MixingSimulation& flow) {
  const vc::Vec3i& n = flow.domain().dims;
  for (int j = 0; j < n[1]; ++j)
    for (int i = 0; i < n[0]; ++i)
      if (flow.concentration({i, j, n[2] - 1}) > 1e-3f) return true;
  return false;
}

/// Brightest and mean irradiance of the wall: 1 and 1 where nothing bends the light.
double contrast(const vc::PhotonResult& photons) {
  const vc::Image wall = photons.receivers.maps().front().image;
  const std::vector<float>& green = wall.planes[wall.find("G")];
  const double sum = std::accumulate(green.begin(), green.end(), 0.);
  return *std::max_element(green.begin(), green.end()) * static_cast<double>(green.size()) / sum;
}

int run(int resolution, int frames) {
  std::ofstream("mixing.json") << kScene;
  vc::MixingOptions options;
  options.resolution = resolution;
  options.inflow = 1.2;
  options.disturbance = .4;
  vc::MixingSimulation flow(options);
  vc::Session session(sceneAt(1, resolution));
  double before = 0, strongest = 0, divergence = 0;
  bool grows = true, leaves = false;
  for (int frame = 1; frame <= frames; ++frame) {
    flow.advance();
    flow.write(vc::withFrame("mix.####.vdb", frame));
    session.setScene(sceneAt(frame, resolution));
    const vc::PhotonResult& photons = session.photons();
    vc::writeVdb(vc::withFrame("light.####.vdb", frame), photons, session.medium());
    vc::writeImage(vc::withFrame("light.####.png", frame), session.view().image);
    const double now = amount(flow);
    leaves = leaves || isLeaving(flow);
    grows = grows && (leaves || now > before);
    before = now;
    divergence = std::max(divergence, flow.divergence());
    strongest = std::max(strongest, contrast(photons));
    std::printf("frame %d: %.4f of the second fluid, brightest place of the wall %.2f times the mean\n", frame, now,
                contrast(photons));
  }
  return grows && divergence < 1e-3 && strongest > 1.2 ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? std::atoi(argv[1]) : 96, argc > 2 ? std::atoi(argv[2]) : 48);
  } catch (const vc::Error& error) {
    std::fprintf(stderr, "07_turbulent_mixing: %s\n", error.what());
    return 3;
  }
}
