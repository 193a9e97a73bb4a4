// The map of where rays can bend may only leave out what no ray meets: with it every cell's first bend is the one that
// a search along the whole ray finds. Where a ray touches an edge of a voxel, either side is right.

#include "transport/reach.h"
#include "backends/cpu_sink.h"
#include "support/solids.h"
#include "support/traverse.h"
#include "transport/emission.h"
#include "volume/flatten.h"

#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace volcaustic::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A tube around a (2, 3) torus knot, so thin that rays pass between its windings. World units are voxels.
Mesh knot(const Vec3d& centre, double size, double tube) {
  constexpr int kAlong = 240, kAround = 12;
  const auto at = [&](double t) {
    const double r = 2 + std::cos(3 * t);
    return kernels::Double3(centre[0] + size * r * std::cos(2 * t), centre[1] + size * r * std::sin(2 * t),
                            centre[2] + size * 1.4 * std::sin(3 * t));
  };
  Mesh m;
  for (int i = 0; i < kAlong; ++i) {
    const double t = 2 * kPi * i / kAlong;
    const kernels::Double3 tangent = kernels::normalize(at(t + 1e-4) - at(t - 1e-4)),
                           u = kernels::normalize(kernels::cross(tangent, kernels::Double3(0.1, 0.2, 1))),
                           v = kernels::cross(tangent, u);
    for (int j = 0; j < kAround; ++j) {
      const double a = 2 * kPi * j / kAround;
      const kernels::Double3 p = at(t) + u * (tube * std::cos(a)) + v * (tube * std::sin(a));
      m.positions.push_back({p.x, p.y, p.z});
    }
  }
  const auto vertex = [&](int i, int j) { return static_cast<std::uint32_t>(i % kAlong * kAround + j % kAround); };
  for (int i = 0; i < kAlong; ++i)
    for (int j = 0; j < kAround; ++j) {
      m.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      m.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  return m;
}

const Domain kDomain{{0, 0, 0}, 1, {77, 90, 61}};

FlatMediumStorage flatOf(std::vector<Body> bodies) {
  for (Body& b : bodies) b.material.index = 1.4;
  VoxeliseOptions options;
  options.blur = 3;
  options.fill = FillRule::Winding;
  options.supersample = 2;
  return flattenMedium(buildMedium(bodies, {}, kDomain, options), {}, {});
}
FlatMediumStorage knotMedium() {
  Body b;
  b.mesh = std::make_shared<const Mesh>(knot({38, 45, 30}, 11, 2));
  return flatOf({b});
}
FlatMediumStorage ballsMedium() {
  Body a, b;
  a.mesh = ball({20, 60, 40}, 9);
  b.mesh = ball({77, 0, 61}, 7); // around a corner of the box
  return flatOf({a, b});
}

/// First bends of a raster with some knowledge of where to look.
std::vector<float> entryMap(const FlatMediumStorage& flat, const kernels::EmissionFrame& frame,
                            const kernels::RasterReach& reach, PhotonTally& tally) {
  RunContext ctx;
  const auto tracer = makeCpuTracer({flat.view(), {}, {1, 1 << 20}}, ctx, "scalar");
  std::vector<float> entry(frame.cells(), -1);
  // Ranges that begin and end inside a row of tiles.
  tracer->emit(frame, reach, {0, std::min(21, frame.rows)}, entry.data());
  if (frame.rows > 21) tracer->emit(frame, reach, {21, frame.rows}, entry.data());
  tally = tracer->tally();
  return entry;
}

/// First bend on the way through a point of the raster, in double precision.
double firstBend(const FlatMediumStorage& flat, const kernels::EmissionFrame& frame, double column, double row) {
  const kernels::EmissionRay ray = frame.rayAt(column, row);
  const kernels::Span span = kernels::clipToBox(flat.dims, ray.origin, ray.direction);
  const double from = frame.point ? std::max(span.entry, 0.0) : span.entry;
  double found = kernels::kNeverBends;
  if (span.exit > from)
    traverse(ray.origin, ray.direction, from, span.exit, flat.dims, 0,
             [&](const kernels::Int3& voxel, double in, double) {
               const bool bends = flat.view().stepAt(voxel) & kernels::kStepBendsBit;
               if (bends) found = in - frame.depth0;
               return !bends;
             });
  return found;
}
/// Whether rays a thousandth of a cell away meet other bends.
bool touchesAnEdge(const FlatMediumStorage& flat, const kernels::EmissionFrame& frame, std::int64_t cell) {
  const kernels::RasterPoint p = frame.pointOf(cell);
  double least = 1e300, most = -1e300;
  for (const double a : {-1e-3, 1e-3})
    for (const double b : {-1e-3, 1e-3}) {
      const double t = firstBend(flat, frame, p.column + a, p.row + b);
      least = std::min(least, t);
      most = std::max(most, t);
    }
  return most - least > 0.1;
}

int expectSameBends(const FlatMediumStorage& flat, const kernels::EmissionFrame& frame) {
  const ReachMap map = reachOf(flat, frame);
  ReachMap everything = map;
  std::fill(everything.nearest.begin(), everything.nearest.end(), -1e30f);
  std::fill(everything.farthest.begin(), everything.farthest.end(), 1e30f);
  PhotonTally a, b;
  const std::vector<float> quick = entryMap(flat, frame, map.view(), a),
                           brute = entryMap(flat, frame, everything.view(), b);
  int bending = 0, different = 0, either = 0;
  for (std::size_t i = 0; i < brute.size(); ++i) {
    bending += brute[i] != kernels::kNeverBends;
    // The search starts elsewhere on the ray, so the last digit may differ.
    if (std::abs(quick[i] - brute[i]) > 1e-4f * std::max(1.0f, std::abs(brute[i]))) {
      if (touchesAnEdge(flat, frame, static_cast<std::int64_t>(i))) {
        ++either;
        continue;
      }
      if (++different < 4)
        ADD_FAILURE() << "cell " << i % frame.columns << ' ' << i / frame.columns << ": " << quick[i] << " instead of "
                      << brute[i];
    }
  }
  EXPECT_EQ(different, 0);
  for (const kernels::Counter c : {kernels::Counter::Emitted, kernels::Counter::Traced})
    EXPECT_LE(std::abs(a.counts[int(c)] - b.counts[int(c)]), either);
  EXPECT_LE(either, 2 + static_cast<int>(brute.size() / 100)); // lights at corners of voxels have many of them
  const double cellPower = 0x1p20 * kernels::maxComponent(frame.strength) * (frame.point ? frame.du * frame.dv : 1);
  // Blocks of cells are booked as a whole.
  for (const kernels::Outcome o : {kernels::Outcome::Emitted, kernels::Outcome::Escaped})
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(double(a.power[int(o)][c]), double(b.power[int(o)][c]),
                  1e-6 * double(b.power[int(o)][c]) + frame.cells() + either * cellPower);
  return bending;
}

/// Over all rasters of a light; the number of cells that bend.
int expectSameBends(const FlatMediumStorage& flat, const Light& light, int columns, int rows, bool jitter) {
  PhotonOptions options;
  options.grid = {columns, rows};
  options.jitter = jitter;
  int bending = 0;
  for (const kernels::EmissionFrame& frame : emissionFrames(light, 0, kDomain, options, 3))
    bending += expectSameBends(flat, frame);
  return bending;
}

class Reach : public testing::TestWithParam<bool> {
protected:
  const FlatMediumStorage mFlat = GetParam() ? knotMedium() : ballsMedium();
};

TEST_P(Reach, HidesNoBendFromParallelLight) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> n;
  int bending = 0;
  for (int i = 0; i < 24; ++i) {
    Light light;
    light.irradiance = {3, 3, 3};
    light.direction = {n(random), n(random), n(random)};
    if (i < 6)
      light.direction = {i / 2 == 0 ? 1 - i % 2 * 2.0 : 0, i / 2 == 1 ? 1 - i % 2 * 2.0 : 0,
                         i / 2 == 2 ? 1 - i % 2 * 2.0 : 0};
    if (i == 6) light.direction = {1, 1, 0};
    if (i == 7) light.direction = {1e-9, 1e-4, -1};
    SCOPED_TRACE(testing::Message() << light.direction[0] << ' ' << light.direction[1] << ' ' << light.direction[2]);
    bending += expectSameBends(mFlat, light, 150 + i, 97, i % 3 == 0);
  }
  EXPECT_GT(bending, 10000);
}

TEST_P(Reach, HidesNoBendFromPoints) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> u(-0.6, 1.6);
  std::vector<Vec3d> places{{38, 45, 200},   {38, 45, 61.01}, {38, 45, 60.99}, {38, 45, 61}, {0, 0, 0},
                            {-0.01, 45, 30}, {76.99, 45, 30}, {40, 48, 32},    {20, 60, 40}, {-300, 500, 90}};
  for (int i = 0; i < 20; ++i) places.push_back({77 * u(random), 90 * u(random), 61 * u(random)});
  int bending = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    Light light;
    light.type = LightType::Point;
    light.position = places[i];
    SCOPED_TRACE(testing::Message() << places[i][0] << ' ' << places[i][1] << ' ' << places[i][2]);
    bending += expectSameBends(mFlat, light, 150, 140, i % 3 == 0);
  }
  EXPECT_GT(bending, 10000);
}

TEST_P(Reach, OfCoarseRasters) {
  for (const auto& [columns, rows] : {std::pair{1, 1}, {3, 2}, {8, 8}, {9, 17}}) {
    Light light;
    light.direction = {.2, .5, -1};
    expectSameBends(mFlat, light, columns, rows, false);
    light.type = LightType::Point;
    light.position = {30, 40, 70};
    expectSameBends(mFlat, light, columns, rows, true);
  }
}

// It would be no use if it covered everything.
TEST_P(Reach, LeavesMostTilesOut) {
  PhotonOptions options;
  options.grid = {512, 512};
  Light light;
  light.direction = {0, 0, -1};
  const ReachMap map = reachOf(mFlat, emissionFrames(light, 0, kDomain, options, 0).front());
  int covered = 0;
  for (std::size_t i = 0; i < map.nearest.size(); ++i) {
    covered += map.nearest[i] <= map.farthest[i];
    if (map.nearest[i] > map.farthest[i]) {
      EXPECT_EQ(map.nearest[i], kernels::kNeverBends);
    }
  }
  EXPECT_LT(covered, 0.9 * double(map.nearest.size()));
  EXPECT_GT(covered, 0);
}

INSTANTIATE_TEST_SUITE_P(Media, Reach, testing::Bool(), [](const auto& knot) { return knot.param ? "Knot" : "Balls"; });

} // namespace
} // namespace volcaustic::test
