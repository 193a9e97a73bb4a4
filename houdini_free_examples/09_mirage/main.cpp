// A mirage: air over a hot road bends light that comes in low back up, the more the hotter the road is.
// Usage: 09_mirage [RESOLUTION]   writes mirage.0001.vdb to mirage.0003.vdb (index) into the current folder.
#include <volcaustic/volcaustic.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

namespace vc = volcaustic;

namespace {

constexpr double kHeight = .1; // over which the heat fades, world

/// n = 1 - strength exp(-z / height): hot below, thin air.
double indexAt(double z, double strength) { return 1 - strength * std::exp(-z / kHeight); }

/// Where a ray that starts level enough turns: n there is n at the start times the cosine of its dip (Snell).
double turningHeight(double startHeight, double dip, double strength) {
  const double n = indexAt(startHeight, strength) * std::cos(dip);
  return -kHeight * std::log((1 - n) / strength);
}

/// Lowest point of a traced ray, by tracing it to many lengths.
double lowestPoint(const vc::Medium& medium, const vc::Vec3d& from, double dip) {
  double lowest = from[2];
  for (double length = .02; length < 1.9; length += .02) {
    vc::TracedRay ray{from, {std::cos(dip), 0, -std::sin(dip)}, 0, length};
    vc::traceRays(medium, std::span(&ray, 1));
    if (ray.left) break;
    lowest = std::min(lowest, ray.position[2]);
  }
  return lowest;
}

int run(int resolution) {
  const vc::Domain domain = vc::domainAround({{-1, -.25, 0}, {1, .25, .5}}, 2 * resolution, 0, 0);
  const double dip = .06;
  const vc::Vec3d eye{-.95, 0, .12};
  double worst = 0;
  for (int frame = 1; frame <= 3; ++frame) {
    const double strength = .008 * frame; // thousands of times that of air: a metre of road does what kilometres do
    const vc::Medium medium = vc::sampleMedium(domain, {}, [=](const vc::Vec3d& p) { return indexAt(p[2], strength); });
    vc::writeVdb("mirage.000" + std::to_string(frame) + ".vdb", medium);
    const double expected = turningHeight(eye[2], dip, strength), found = lowestPoint(medium, eye, dip);
    worst = std::max(worst, std::abs(found - expected));
    std::printf("frame %d: a ray that dips by %.3f turns at height %.4f, in closed form %.4f\n", frame, dip, found,
                expected);
  }
  return worst < .5 * domain.voxelSize ? 0 : 1;
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
