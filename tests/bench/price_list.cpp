// What accuracy costs: each way of carrying a photon on the ray tables of reference/ and on a glass ball, as CSV on
// stdout. tools/dev/price_list turns it into a table and a picture.
//   build/bench/bin/bench_price_list [VOXELS]      along an axis, 256 by default; ten minutes there
//
// Ray tables: the exit against the closed form, over all rays of all tables. Ball: the exit angle against the path that
// the same field gives with steps of a sixteenth of a voxel. Cost: of the whole photon pass for 512^2 photons, divided
// by the photons that met the ball.

#include "support/ray_tables.h"
#include "support/shared_data.h"
#include "support/solids.h"
#include "volcaustic/options.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

namespace volcaustic::test {
namespace {

struct Variant {
  Scheme scheme;
  Lookup lookup;
  double step;
  bool everyStep; ///< steps of `step` everywhere, not only where the step field asks for its shortest
};

std::vector<Variant> variants() {
  std::vector<Variant> all;
  for (const Scheme scheme : {Scheme::Euler, Scheme::DriftKickDrift})
    for (const Lookup lookup : {Lookup::Nearest, Lookup::Trilinear})
      for (const double step : {.5, 1., 2., 4.})
        for (const bool everyStep : {false, true}) all.push_back({scheme, lookup, step, everyStep});
  return all;
}

PhotonOptions optionsOf(const Variant& v) {
  PhotonOptions o;
  o.grid = {512, 512};
  o.scheme = v.scheme;
  o.lookup = v.lookup;
  o.minStep = v.step;
  if (v.everyStep) o.maxStep = v.step;
  return o;
}

/// By rank: 0.5 is the median.
double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// A table, the medium that samples its field, and the field.
struct RayTable {
  Table table;
  IndexField field;
  Medium medium;
};

std::vector<RayTable> rayTables(int resolution) {
  std::vector<RayTable> tables;
  for (const char* name : {"luneburg", "linear", "linear_n2", "slab", "mirage_exp", "mirage_linear", "smooth_sphere",
                           "fibre", "maxwell_fisheye"}) {
    const auto path = sharedPath(std::string("reference/analytic_") + name + ".csv");
    if (!std::filesystem::exists(path)) {
      std::fprintf(stderr, "not present: %s\n", path.c_str());
      continue;
    }
    tables.push_back({readCsv(path), indexField(name), sampleMedium(unitCube(resolution), {}, indexField(name))});
  }
  return tables;
}

struct Ball {
  Medium medium;
  std::vector<TracedRay> starts, exact;
};

/// Parallel rays over the ball and its skin.
Ball glassBall(int resolution) {
  constexpr double kRadius = 45.0 / 256, kHalfWidth = kRadius + .02;
  constexpr int kSide = 64;
  Ball b;
  Body body;
  body.mesh = ball({.5, .5, .6}, kRadius, 115);
  b.medium = buildMedium(std::span(&body, 1), {}, unitCube(resolution));
  for (int i = 0; i < kSide * kSide; ++i) {
    TracedRay r;
    const double x = (i % kSide + .5) / kSide * 2 - 1, y = (i / kSide + .5) / kSide * 2 - 1;
    r.position = {.5 + kHalfWidth * x, .5 + kHalfWidth * y, 1};
    r.direction = {0, 0, -1};
    if (std::hypot(x, y) < 1) b.starts.push_back(r);
  }
  PhotonOptions fine;
  fine.minStep = fine.maxStep = 1.0 / 16;
  b.exact = b.starts;
  traceRays(b.medium, b.exact, {}, fine);
  return b;
}

void printRow(const Variant& v, const std::vector<RayTable>& tables, const Ball& ball, int resolution) {
  const PhotonOptions options = optionsOf(v);
  std::vector<double> position, direction, angle;
  for (const RayTable& t : tables) {
    auto rays = startsOf(t.table);
    traceRays(t.medium, rays, {}, options);
    for (const ExitError& e : exitErrors(t.table, rays, t.field, resolution)) {
      position.push_back(e.position);
      direction.push_back(e.direction);
    }
  }
  auto rays = ball.starts;
  traceRays(ball.medium, rays, {}, options);
  for (std::size_t i = 0; i < rays.size(); ++i)
    angle.push_back(angleBetween(rays[i].direction, ball.exact[i].direction));

  const Light sun;
  double best = 1e300;
  EnergyBalance balance;
  for (int i = 0; i < 3; ++i) {
    const auto start = std::chrono::steady_clock::now();
    balance = tracePhotons(ball.medium, std::span(&sun, 1), {}, options).balance;
    best = std::min(best, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count());
  }
  const double photons = static_cast<double>(std::max<std::int64_t>(balance.photonsTraced, 1));
  std::printf("%s,%s,%g,%d,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.2f,%.1f\n",
              enumNames(v.scheme)[static_cast<int>(v.scheme)], enumNames(v.lookup)[static_cast<int>(v.lookup)], v.step,
              v.everyStep, quantile(position, .5), quantile(position, .9), quantile(direction, .5),
              quantile(direction, .9), quantile(angle, .5), quantile(angle, .9),
              static_cast<double>(balance.photonsAtStepLimit) / photons, static_cast<double>(balance.steps) / photons,
              best / photons);
  std::fflush(stdout);
}

int run(int resolution) {
  const std::vector<RayTable> tables = rayTables(resolution);
  const Ball ball = glassBall(resolution);
  std::printf("scheme,lookup,step,everyStep,tablePositionMedian,tablePosition90,tableDirectionMedian,tableDirection90,"
              "ballAngleMedian,ballAngle90,trapped,stepsPerPhoton,nsPerPhoton\n");
  for (const Variant& v : variants()) printRow(v, tables, ball, resolution);
  return 0;
}

} // namespace
} // namespace volcaustic::test

int main(int argc, char** argv) { return volcaustic::test::run(argc > 1 ? std::max(16, std::atoi(argv[1])) : 256); }
