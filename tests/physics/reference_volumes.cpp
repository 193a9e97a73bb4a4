// Fluence behind glass bodies against ground truth made by exact ray and surface intersection (reference/README.md).
// The reference bodies are sharp, ours are voxelised; the difference has to shrink with the voxel.

#include "support/csv.h"
#include "support/fields.h"
#include "support/npy.h"
#include "support/shared_data.h"
#include "support/solids.h"
#include "volcaustic/photons.h"
#include "volcaustic/view.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace volcaustic::test {
namespace {

constexpr int kReference = 64;

struct Glass {
  const char* name;
  Vec3d centre, radii;
  double index;
};
const Glass kBall15{"sphere15_nofresnel", {.5, .5, .65}, {.3, .3, .3}, 1.5};
const Glass kBall11{"sphere11_nofresnel", {.5, .5, .65}, {.3, .3, .3}, 1.1};
const Glass kOblate{"elloblate_nofresnel", {.5, .5, .83}, {.3, .3, .15}, 1.5};

/// What follows a sharp surface best at these sizes: 8x8x8 sub-voxels, so that normals are true to a few hundredths of
/// a degree, and the narrowest Gaussian that a voxel's step can follow (docs/performance.md).
VoxeliseOptions sharpest() {
  VoxeliseOptions o;
  o.supersample = 8;
  o.blur = 7;
  return o;
}

/// Fluence (red) of a body lit from above with 1 W/m2, no smoothing.
RadianceVolume trace(const Glass& glass, int resolution, int photonsPerSide, EnergyBalance* balance = nullptr) {
  Body body;
  body.mesh = std::make_shared<const Mesh>(ellipsoid(glass.centre, glass.radii, 256));
  body.material.index = glass.index;
  const Medium medium = buildMedium(std::span(&body, 1), {}, unitCube(resolution), sharpest());
  PhotonOptions photons;
  photons.grid = {photonsPerSide, photonsPerSide};
  photons.smooth = false;
  Light sun;
  sun.direction = {0, 0, -1};
  const PhotonResult result = tracePhotons(medium, std::span(&sun, 1), {}, photons);
  if (balance) *balance = result.balance;
  return result.radiance;
}

/// Block means on the reference's 64^3 lattice.
std::vector<double> reduced(const RadianceVolume& v) {
  const int n = v.domain().dims[0], block = n / kReference;
  std::vector<double> out(kReference * kReference * kReference);
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z)
        out[(x / block * kReference + y / block) * kReference + z / block] += v.fluence({x, y, z})[0];
  for (double& o : out) o /= block * block * block;
  return out;
}

struct Comparison {
  double median = 0, percentile90 = 0; ///< relative error where the reference is smooth
  double meanRatio = 0;                ///< total fluence over the reference's
  int voxels = 0;
};

/// Smooth: the 27 values around a voxel differ by less than a tenth of its own.
Comparison compare(const std::vector<double>& ours, const std::vector<float>& truth) {
  std::vector<double> errors;
  const auto at = [&](int x, int y, int z) { return truth[(x * kReference + y) * kReference + z]; };
  for (int x = 1; x < kReference - 1; ++x)
    for (int y = 1; y < kReference - 1; ++y)
      for (int z = 1; z < kReference - 1; ++z) {
        float low = at(x, y, z), high = low;
        for (int i = -1; i <= 1; ++i)
          for (int j = -1; j <= 1; ++j)
            for (int k = -1; k <= 1; ++k) {
              low = std::min(low, at(x + i, y + j, z + k));
              high = std::max(high, at(x + i, y + j, z + k));
            }
        const double t = at(x, y, z);
        if (t > .01 && high - low < .1 * t)
          errors.push_back(std::abs(ours[(x * kReference + y) * kReference + z] - t) / t);
      }
  std::sort(errors.begin(), errors.end());
  Comparison c;
  c.voxels = static_cast<int>(errors.size());
  c.median = errors[errors.size() / 2];
  c.percentile90 = errors[errors.size() * 9 / 10];
  c.meanRatio = std::accumulate(ours.begin(), ours.end(), 0.0) / std::accumulate(truth.begin(), truth.end(), 0.0);
  return c;
}

class ReferenceVolume : public testing::TestWithParam<Glass> {};
void PrintTo(const Glass& g, std::ostream* out) { *out << g.name; }

TEST_P(ReferenceVolume, SmoothPartsAndTotalAgreeAt256) {
  const auto path = sharedPath(std::string("reference/") + GetParam().name + "_64.npy");
  VOLCAUSTIC_NEED_SHARED(path);
  EnergyBalance balance;
  const Comparison c = compare(reduced(trace(GetParam(), 256, 2048, &balance)), readNpy(path, 64 * 64 * 64));
  std::printf(
      "  %s: median %.3f %%, 90 %% under %.3f %% of %d smooth voxels, total fluence ratio %.5f, imbalance %.1e\n",
      GetParam().name, 100 * c.median, 100 * c.percentile90, c.voxels, c.meanRatio, balance.relativeImbalance());
  EXPECT_GT(c.voxels, 20000);
  EXPECT_LE(c.median, .01);
  // All power that enters the unit cube's lid leaves the cube. Its path is a percent or two longer than in the sharp
  // bodies: what meets the rim travels along the soft skin and comes out at wide angles.
  EXPECT_NEAR(balance.emitted[0], 1, .002);
  EXPECT_NEAR(balance.escaped[0], balance.emitted[0], .002);
  EXPECT_LE(balance.relativeImbalance(), 1e-4);
  EXPECT_NEAR(c.meanRatio, 1, .025);
}
INSTANTIATE_TEST_SUITE_P(Bodies, ReferenceVolume, testing::Values(kBall15, kBall11, kOblate),
                         [](const auto& instance) { return std::string(instance.param.name); });

/// Mean over the 2x2 voxels around the axis at each depth, as in the reference's exact_2x2 columns.
std::vector<double> axisProfile(const RadianceVolume& v) {
  const int n = v.domain().dims[0];
  std::vector<double> profile(n);
  for (int k = 0; k < n; ++k)
    for (int i = n / 2 - 1; i <= n / 2; ++i)
      for (int j = n / 2 - 1; j <= n / 2; ++j) profile[k] += .25 * v.fluence({i, j, n - 1 - k})[0];
  return profile;
}

TEST(BallLens, AxisProfileAndFocusAt256) {
  const auto path = sharedPath("reference/sphere15_nofresnel_axis.csv");
  VOLCAUSTIC_NEED_SHARED(path);
  const Table t = readCsv(path);
  const auto ours = axisProfile(trace(kBall15, 256, 2048));
  const auto& exact = t.at("exact_2x2_256");
  ASSERT_EQ(exact.size(), ours.size());
  // Behind the ball, outside its skin and two voxels of the paraxial focus. Inside it the axis also gathers the rays
  // that a soft skin carries around its rim: little power, but from all sides at once (docs/performance.md).
  std::vector<double> errors;
  double largest = 0, whereLargest = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const double depth = t.at("t")[i];
    if (depth < .3 + 5.0 / 256 || std::abs(depth - .45) < 2.0 / 256) continue;
    errors.push_back(std::abs(ours[i] / exact[i] - 1));
    if (errors.back() > largest) largest = errors.back(), whereLargest = depth;
  }
  std::sort(errors.begin(), errors.end());
  const auto peak = std::max_element(ours.begin(), ours.end()) - ours.begin();
  const auto exactPeak = std::max_element(exact.begin(), exact.end()) - exact.begin();
  std::printf("  axis: median %.2f %%, 90 %% under %.2f %%, largest %.1f %% at t=%.3f; brightest at t=%.4f (exact "
              "%.4f), %.0f (exact %.0f)\n",
              100 * errors[errors.size() / 2], 100 * errors[errors.size() * 9 / 10], 100 * largest, whereLargest,
              t.at("t")[peak], t.at("t")[exactPeak], ours[peak], exact[exactPeak]);
  EXPECT_LE(errors[errors.size() / 2], .06);
  EXPECT_NEAR(t.at("t")[peak], t.at("t")[exactPeak], 4.0 / 256);
}

TEST(BallLens, ErrorFallsWithTheVoxel) {
  const auto path = sharedPath("reference/sphere15_nofresnel_64.npy");
  VOLCAUSTIC_NEED_SHARED(path);
  const auto truth = readNpy(path, 64 * 64 * 64);
  // Over all voxels, the caustic included: sum of |difference| over the sum of the reference.
  const auto error = [&](int resolution) {
    const auto ours = reduced(trace(kBall15, resolution, 1024));
    double sum = 0, all = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
      sum += std::abs(ours[i] - truth[i]);
      all += truth[i];
    }
    return sum / all;
  };
  const double at64 = error(64), at128 = error(128), at256 = error(256);
  std::printf("  mean |difference| / mean: 64^3 %.4f, 128^3 %.4f, 256^3 %.4f\n", at64, at128, at256);
  EXPECT_LT(at128, .75 * at64);
  EXPECT_LT(at256, .75 * at128);
}

// What a camera sees of the light below the ball, through fog too thin to dim it: L = scattering/(4 pi) times the
// fluence along the line of sight, added up from the reference's own voxels.
TEST(BallLens, TheCameraIntegratesTheReferencesFluence) {
  const auto path = sharedPath("reference/sphere15_nofresnel_64.npy");
  VOLCAUSTIC_NEED_SHARED(path);
  const auto truth = readNpy(path, 64 * 64 * 64);
  constexpr double kFog = 1e-3;
  Ambient fog;
  fog.attenuation = fog.scattering = {kFog, kFog, kFog};
  Body body;
  body.mesh = ball(kBall15.centre, .3, 256);
  body.material.index = 1.5;
  body.material.attenuation = body.material.scattering = fog.attenuation;
  const Medium medium = buildMedium(std::span(&body, 1), fog, unitCube(256), sharpest());
  PhotonOptions photons;
  photons.grid = {1536, 1536};
  photons.smooth = false;
  const Light sun;
  const RadianceVolume light = tracePhotons(medium, std::span(&sun, 1), {}, photons).radiance;
  Camera far; // as good as parallel: rays are a voxel of the reference apart from front to back
  far.position = {.5, -400, .5};
  far.target = {.5, .5, .5};
  far.fieldOfView = 2 * std::atan(.5 / 400.5) * 180 / 3.14159265358979;
  far.resolution = {kReference, kReference};
  ViewOptions options;
  options.samples = 3;
  options.filter = PixelFilter::Box;
  Background black;
  black.bottom = black.top = {0, 0, 0};
  const Image image = renderView(medium, light, far, black, {}, options).image;
  const auto& red = image.planes[image.find("R")];
  std::vector<double> errors;
  double seen = 0, expected = 0;
  for (int z = 1; z < 18; ++z) // the ball begins at .35
    for (int x = 4; x < 60; ++x) {
      double fluence = 0;
      for (int y = 0; y < kReference; ++y) fluence += truth[(x * kReference + y) * kReference + z] / kReference;
      const double l = kFog / (4 * 3.14159265358979) * fluence, ours = red[(63 - z) * kReference + x];
      errors.push_back(std::abs(ours / l - 1));
      seen += ours;
      expected += l;
    }
  std::sort(errors.begin(), errors.end());
  std::printf("  camera: median %.2f %%, 90 %% under %.2f %%, all %.4f\n", 100 * errors[errors.size() / 2],
              100 * errors[errors.size() * 9 / 10], seen / expected);
  EXPECT_LT(errors[errors.size() / 2], .02);
  EXPECT_NEAR(seen / expected, 1, .03);
}

// Paraxial rays cross the axis at the effective focal length n D / (4 (n - 1)) behind the centre.
TEST(BallLens, ParaxialFocus) {
  Body body;
  body.mesh = ball({.5, .5, .5}, .2, 256);
  body.material.index = 1.5;
  const Medium medium = buildMedium(std::span(&body, 1), {}, unitCube(256), sharpest());
  std::vector<TracedRay> rays;
  for (int i = 0; i < 64; ++i) {
    const double angle = 2 * 3.14159265358979 * i / 64, b = .015 + .01 * (i % 4) / 4.0;
    TracedRay r;
    r.position = {.5 + b * std::cos(angle), .5 + b * std::sin(angle), 1};
    r.direction = {0, 0, -1};
    rays.push_back(r);
  }
  traceRays(medium, rays);
  const double focal = 1.5 * .4 / (4 * .5);
  double mean = 0;
  for (const TracedRay& r : rays) {
    // Where the ray is nearest to the axis.
    const double x = r.position[0] - .5, y = r.position[1] - .5, dx = r.direction[0], dy = r.direction[1];
    const double back = -(x * dx + y * dy) / (dx * dx + dy * dy);
    mean += (.5 - (r.position[2] + back * r.direction[2])) / 64;
  }
  std::printf("  paraxial rays cross the axis %.4f behind the centre (n D / (4 (n - 1)) = %.4f)\n", mean, focal);
  EXPECT_NEAR(mean, focal, .02 * focal);
}

} // namespace
} // namespace volcaustic::test
