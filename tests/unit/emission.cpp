// Emission against plain geometry: every cell's ray meets its first bend where a test of all bending boxes in double
// precision says so, and all light is booked once.

#include "transport/emission.h"
#include "backends/lanes.h"
#include "kernels/photon.h"
#include "support/lights.h"
#include "transport/reach.h"
#include "volume/flatten.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace volcaustic::test {
namespace {

using kernels::Counter;
using kernels::Double3;
using kernels::EmissionFrame;
using kernels::Outcome;

constexpr double kPi = 3.14159265358979323846, kNowhere = 1e300;

struct Box {
  Double3 low, high;
};

/// A medium of which only the bends are told, and the boxes that they fill.
struct Bends {
  FlatMediumStorage flat;
  std::vector<Box> boxes;

  explicit Bends(const Vec3i& dims) {
    flat.dims = {dims[0], dims[1], dims[2]};
    flat.brickDims = {(dims[0] + 7) / 8, (dims[1] + 7) / 8, (dims[2] + 7) / 8};
    const std::size_t count = std::size_t(flat.brickDims.x) * flat.brickDims.y * flat.brickDims.z;
    flat.stepSlots = ZeroedTable<std::int32_t>(count);
    flat.bends = ZeroedTable<std::uint8_t>(count);
    flat.optics.resize(1);
    flat.ambientStep = 3;
    slot();
  }
  std::size_t brick(int x, int y, int z) const {
    return (std::size_t(x) * flat.brickDims.y + y) * flat.brickDims.z + z;
  }
  std::int32_t slot() {
    const std::size_t slots = flat.steps.size() / kernels::kStepVoxels;
    std::vector<std::uint8_t> steps(flat.steps.begin(), flat.steps.end());
    steps.resize(slots * kernels::kStepVoxels);
    steps.resize((slots + 1) * kernels::kStepVoxels, 3);
    steps.resize(steps.size() + kernels::kStepPadding);
    flat.steps.assign(steps.begin(), steps.end());
    return static_cast<std::int32_t>(slots);
  }
  void bendBrick(int x, int y, int z) {
    const std::size_t b = brick(x, y, z);
    flat.bends[b] = 1;
    flat.stepSlots[b] = ~std::int32_t{kernels::kStepBendsBit | 3};
    boxes.push_back({Double3(8 * x, 8 * y, 8 * z), Double3(8 * x + 8, 8 * y + 8, 8 * z + 8)});
  }
  void bendVoxel(int x, int y, int z) {
    const std::size_t b = brick(x / 8, y / 8, z / 8);
    if (flat.stepSlots[b] < 0) return;
    flat.bends[b] = 1;
    if (flat.stepSlots[b] == 0) flat.stepSlots[b] = slot();
    flat.steps[std::size_t(flat.stepSlots[b]) * kernels::kStepVoxels + (x & 7) * 64 + (y & 7) * 8 + (z & 7)] |=
        kernels::kStepBendsBit;
    boxes.push_back({Double3(x, y, z), Double3(x + 1, y + 1, z + 1)});
  }
};

/// Voxels far from each other, small clumps, a sheet one voxel thick, and whole bricks.
Bends scattered(const Vec3i& dims, std::uint64_t seed) {
  Bends bends(dims);
  std::mt19937_64 random(seed);
  const auto upTo = [&](int n) { return static_cast<int>(random() % static_cast<std::uint64_t>(n)); };
  for (int i = 0; i < 2; ++i) bends.bendBrick(upTo(dims[0] / 8), upTo(dims[1] / 8), upTo(dims[2] / 8));
  for (int i = 0; i < 60; ++i) bends.bendVoxel(upTo(dims[0]), upTo(dims[1]), upTo(dims[2]));
  for (int i = 0; i < 4; ++i) {
    const int x = upTo(dims[0] - 3), y = upTo(dims[1] - 3), z = upTo(dims[2] - 3);
    for (int k = 0; k < 27; ++k)
      if (upTo(3) > 0) bends.bendVoxel(x + k / 9, y + k / 3 % 3, z + k % 3);
  }
  const int axis = upTo(3), at = upTo(dims[axis]);
  for (int i = 3; i < 11; ++i)
    for (int k = 2; k < 14; ++k)
      bends.bendVoxel(axis == 0 ? at : i, axis == 1 ? at : axis == 0 ? i : k, axis == 2 ? at : k);
  return bends;
}

struct Span2 {
  double in, out;
};
Span2 cross(const Box& box, double grown, const kernels::EmissionRay& ray) {
  Span2 s{-kNowhere, kNowhere};
  for (int a = 0; a < 3; ++a) {
    const double low = box.low[a] - grown - ray.origin[a], high = box.high[a] + grown - ray.origin[a];
    if (ray.direction[a] == 0) {
      if (low > 0 || high < 0) return {1, -1};
      continue;
    }
    const double t0 = low / ray.direction[a], t1 = high / ray.direction[a];
    s = {std::max(s.in, std::min(t0, t1)), std::min(s.out, std::max(t0, t1))};
  }
  return s;
}

/// Distance to the first box, each grown by some of a voxel; kNowhere when the ray meets none in the domain.
double firstBox(const Bends& bends, const EmissionFrame& frame, const kernels::EmissionRay& ray, double grown) {
  const Box domain{Double3(0, 0, 0), Double3(bends.flat.dims)};
  Span2 inside = cross(domain, grown, ray);
  if (frame.point) inside.in = std::max(inside.in, 0.0);
  double first = kNowhere;
  for (const Box& box : bends.boxes) {
    const Span2 s = cross(box, grown, ray);
    const double in = std::max(s.in, inside.in);
    if (std::min(s.out, inside.out) > in) first = std::min(first, in);
  }
  return first;
}

struct Emission {
  std::vector<float> entry;
  PhotonTally tally;

  [[nodiscard]] double power(Outcome o, int channel) const {
    return static_cast<double>(tally.power[static_cast<int>(o)][channel]);
  }
};
constexpr double kUnit = 0x1p36; ///< of the tallies, for a W; a sun over 2048² voxels stays within 63 bits

Emission emit(const Bends& bends, const EmissionFrame& frame, std::string_view lanes, int rows = 0, int threads = 0) {
  RunContext ctx;
  ctx.threads = threads;
  const auto tracer = makeCpuTracer({bends.flat.view(), {}, {1, kUnit}}, ctx, lanes);
  const ReachMap reach = reachOf(bends.flat, frame, ctx);
  Emission e{std::vector<float>(frame.cells(), -7), {}};
  if (rows <= 0) rows = frame.rows;
  for (int row = 0; row < frame.rows; row += rows)
    tracer->emit(frame, reach.view(), {row, std::min(row + rows, frame.rows)}, e.entry.data());
  e.tally = tracer->tally();
  return e;
}

Domain domainOf(const Bends& bends) {
  return {{0, 0, 0}, 1, {bends.flat.dims.x, bends.flat.dims.y, bends.flat.dims.z}};
}
std::vector<EmissionFrame> framesOf(const Bends& bends, const Light& light, int columns, int rows, bool jitter) {
  PhotonOptions options;
  options.grid = {columns, rows};
  options.jitter = jitter;
  return emissionFrames(light, 0, domainOf(bends), options, 11);
}

/// Holds every cell against the boxes: what a ray meets for more than `tolerance` it must have met, and nothing that it
/// passes by at more than that. Returns the number of cells that bend.
int expectFirstBends(const Bends& bends, const EmissionFrame& frame, const std::vector<float>& entry,
                     double tolerance) {
  int bending = 0, wrong = 0;
  for (std::int64_t cell = 0; cell < frame.cells(); ++cell) {
    const kernels::EmissionRay ray = frame.ray(cell);
    const double surely = firstBox(bends, frame, ray, -tolerance), maybe = firstBox(bends, frame, ray, tolerance);
    const bool meets = entry[cell] != kernels::kNeverBends;
    const double found = meets ? entry[cell] + frame.depth0 : kNowhere;
    // Along the ray a face may be met much earlier than a grown one where the ray hardly leans on it.
    const double early = maybe < kNowhere ? maybe - 2 * tolerance : kNowhere;
    bending += meets;
    if (found >= early && found <= (surely < kNowhere ? surely + 2 * tolerance : kNowhere)) continue;
    if (++wrong < 4)
      ADD_FAILURE() << "cell " << cell % frame.columns << ' ' << cell / frame.columns << " of " << frame.columns
                    << ": bend at " << found << " instead of between " << maybe << " and " << surely;
  }
  EXPECT_EQ(wrong, 0);
  return bending;
}

class EmissionOf : public testing::TestWithParam<std::string> {};

TEST_P(EmissionOf, ParallelLightMeetsTheFirstBends) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> n;
  int bending = 0;
  for (int i = 0; i < 26; ++i) {
    const Bends bends = scattered({45, 37, 58}, 100 + i);
    Vec3d d{n(random), n(random), n(random)};
    if (i < 6)
      d = {i / 2 == 0 ? 1 - i % 2 * 2.0 : 0, i / 2 == 1 ? 1 - i % 2 * 2.0 : 0, i / 2 == 2 ? 1 - i % 2 * 2.0 : 0};
    if (i == 6) d = {1, 1, 0};
    if (i == 7) d = {-1e-9, 1e-4, 1};
    SCOPED_TRACE(testing::Message() << i << ": " << d[0] << ' ' << d[1] << ' ' << d[2]);
    const int columns = i % 4 == 0 ? 11 : 90 + i;
    for (const EmissionFrame& frame : framesOf(bends, sun(d), columns, 61 + i, i % 3 == 0))
      bending += expectFirstBends(bends, frame, emit(bends, frame, GetParam()).entry, 2e-4);
  }
  EXPECT_GT(bending, 10000);
}

TEST_P(EmissionOf, PointsMeetTheFirstBends) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> u(-0.7, 1.7);
  const Vec3i dims{45, 37, 58};
  std::vector<Vec3d> places{{20, 18, 200}, {22, 18, 58.01}, {22, 18, 57.99}, {22, 18, 58},    {0, 0, 0},
                            {-.01, 9, 30}, {24, 16, 32},    {24.5, 16.5, 8}, {300, -500, 90}, {20, 1e5, 3e4}};
  for (int i = 0; i < 16; ++i) places.push_back({45 * u(random), 37 * u(random), 58 * u(random)});
  int bending = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Bends bends = scattered(dims, 200 + i);
    SCOPED_TRACE(testing::Message() << places[i][0] << ' ' << places[i][1] << ' ' << places[i][2]);
    const int columns = i % 4 == 0 ? 13 : 110;
    for (const EmissionFrame& frame : framesOf(bends, lamp(places[i]), columns, 97, i % 3 == 0))
      bending += expectFirstBends(bends, frame, emit(bends, frame, GetParam()).entry, 2e-4);
  }
  EXPECT_GT(bending, 10000);
}

// Rays run thousands of voxels, and positions have four digits before the point.
TEST_P(EmissionOf, StaysAccurateInALargeDomain) {
  Bends bends({2048, 2048, 2048});
  std::mt19937_64 random(3);
  for (int i = 0; i < 1200; ++i) {
    const int x = static_cast<int>(random() % 256), y = static_cast<int>(random() % 256);
    if (const int z = static_cast<int>(random() % 256); bends.flat.stepSlots[bends.brick(x, y, z)] == 0)
      bends.bendBrick(x, y, z);
  }
  int bending = 0;
  for (const Light& light :
       {sun({.3, -.7, -1}), sun({0, 1, 0}), lamp({300, 900, 5000}), lamp({1e6, 2e6, -3e6}), lamp({1000, 1100, 900})})
    for (const EmissionFrame& frame : framesOf(bends, light, 100, 100, true))
      bending += expectFirstBends(bends, frame, emit(bends, frame, GetParam()).entry, 1e-3);
  EXPECT_GT(bending, 500);
}

// A light may stand in what bends: its rays bend at once.
TEST_P(EmissionOf, BeginsInsideWhatBends) {
  Bends bends({48, 48, 48});
  for (int i = 0; i < 125; ++i) bends.bendBrick(i / 25, i / 5 % 5, i % 5);
  for (const Vec3d& p : {Vec3d{20, 20, 20}, Vec3d{16, 16, 16}, Vec3d{3, 17, 22}})
    for (const EmissionFrame& frame : framesOf(bends, lamp(p), 40, 40, false))
      for (const float e : emit(bends, frame, GetParam()).entry) ASSERT_EQ(e, 0);
}

/// What a raster's cells hold, cell by cell in double precision.
struct Book {
  Double3 emitted{0, 0, 0}, carriedOn{0, 0, 0};
  std::int64_t seen = 0, bending = 0;
};
Book bookOf(const Bends& bends, const EmissionFrame& frame, const std::vector<float>& entry) {
  Book book;
  for (std::int64_t cell = 0; cell < frame.cells(); ++cell) {
    const kernels::EmissionRay ray = frame.ray(cell);
    Span2 s = cross({Double3(0, 0, 0), Double3(bends.flat.dims)}, 0, ray);
    if (frame.point) s.in = std::max(s.in, 0.0);
    if (!(s.out > s.in)) continue;
    const auto column = static_cast<int>(cell % frame.columns), row = static_cast<int>(cell / frame.columns);
    const Double3 power = frame.power(std::int64_t{row} * frame.columns + column);
    book.emitted += power;
    ++book.seen;
    if (entry[cell] == kernels::kNeverBends) continue;
    ++book.bending;
    book.carriedOn += power * kernels::transmittance(bends.flat.optics[0], entry[cell] + frame.depth0 - s.in);
  }
  return book;
}

TEST_P(EmissionOf, BooksAllLightOnce) {
  for (const bool fog : {false, true})
    for (const bool jitter : {false, true})
      for (const Light& light :
           {sun({0, 0, -1}), sun({.4, .2, -1}), lamp({20, 18, 150}), lamp({50, 40, 60}), lamp({20, 12, 32}),
            spot({20, 18, 150}, {.02, 0, -1}, 5, 12), spot({20, 12, 32}, {1, .3, -.2}, 20, 80)}) {
        Bends bends = scattered({45, 37, 58}, 7);
        if (fog) bends.flat.optics[0] = {{.02f, .01f, 0}, {.015f, .01f, 0}, 0};
        for (const EmissionFrame& frame : framesOf(bends, light, 130, 101, jitter)) {
          const Emission e = emit(bends, frame, GetParam());
          const Book book = bookOf(bends, frame, e.entry);
          // A ray that touches an edge of the box may be counted or not.
          EXPECT_NEAR(double(e.tally.counts[int(Counter::Emitted)]), double(book.seen), 2);
          EXPECT_EQ(e.tally.counts[int(Counter::Traced)], book.bending);
          for (int c = 0; c < 3; ++c) {
            // The ramp of a narrow cone loses digits of its cosines.
            const double emitted = book.emitted[c] * kUnit, slack = frame.cone.isSphere() ? 0 : 1e-5 * emitted,
                         all = 1e-6 * emitted + slack + double(frame.cells()) +
                               2 * kernels::maxComponent(frame.power(0)) * kUnit * (e.tally.counts[0] != book.seen);
            EXPECT_NEAR(e.power(Outcome::Emitted, c), emitted, all);
            const double absorbed = e.power(Outcome::Absorbed, c), scattered = e.power(Outcome::Scattered, c);
            EXPECT_NEAR(absorbed + scattered + e.power(Outcome::Escaped, c) + book.carriedOn[c] * kUnit,
                        e.power(Outcome::Emitted, c),
                        (fog ? 1e-5 : 2e-7) * emitted + slack + 4 * double(frame.cells()));
            const double albedo[3] = {.75, 1, 0};
            EXPECT_NEAR(scattered, albedo[c] * (absorbed + scattered), 1e-5 * emitted);
            EXPECT_EQ(scattered > 0, fog && c < 2 && emitted > 0);
          }
        }
      }
}

TEST_P(EmissionOf, GivesTheSameBitsForAnyThreadsAndRows) {
  for (const bool fog : {false, true})
    for (const Light& light :
         {sun({.4, .2, -1}), lamp({20, 18, 150}), lamp({20, 12, 32}), spot({20, 18, 150}, {0, .03, -1}, 3, 12)}) {
      Bends bends = scattered({45, 37, 58}, 9);
      if (fog) bends.flat.optics[0] = {{.02f, .01f, 0}, {.015f, .01f, 0}, 0};
      for (const EmissionFrame& frame : framesOf(bends, light, 133, 117, true)) {
        const Emission whole = emit(bends, frame, GetParam(), 0, 1);
        for (const auto& [rows, threads] : {std::pair{0, 3}, {1, 1}, {5, 2}, {8, 2}, {13, 3}, {64, 1}}) {
          const Emission parts = emit(bends, frame, GetParam(), rows, threads);
          EXPECT_EQ(parts.entry, whole.entry);
          EXPECT_EQ(parts.tally.power, whole.tally.power) << rows;
          EXPECT_EQ(parts.tally.counts, whole.tally.counts);
        }
      }
    }
}

std::vector<std::string> names() {
  std::vector<std::string> n;
  for (const LaneSet& set : laneSets()) n.emplace_back(set.name);
  return n;
}
INSTANTIATE_TEST_SUITE_P(All, EmissionOf, testing::ValuesIn(names()), [](const auto& set) { return set.param; });

TEST(SolidAngle, OfCellsIsThatOfTheirSum) {
  for (const int cells : {1, 2, 7, 64}) {
    const double size = 2.0 / cells;
    double whole = 0, single = 0;
    for (int i = 0; i < cells; ++i)
      for (int k = 0; k < cells; ++k) {
        const double u = -1 + i * size, v = -1 + k * size, angle = kernels::solidAngle(u, v, size, size);
        const float f = kernels::solidAngle(float(u), float(v), float(size), float(size));
        EXPECT_NEAR(f / angle, 1, 1e-6);
        whole += angle;
        single += f;
      }
    EXPECT_NEAR(whole, 4 * kPi / 6, 1e-12 * cells * cells);
    EXPECT_NEAR(single, 4 * kPi / 6, 1e-6);
  }
}

// Small cells far off the axis: a difference of corner terms would have lost all digits in single precision.
TEST(SolidAngle, OfSmallCellsIsAccurate) {
  for (const double size : {1e-2, 1e-3, 1e-4, 1e-5})
    for (const double u : {0.0, .3, -1.7}) {
      const double v = .8, r = std::sqrt(1 + (u + size / 2) * (u + size / 2) + (v + size / 2) * (v + size / 2));
      EXPECT_NEAR(kernels::solidAngle(u, v, size, size) / (size * size / (r * r * r)), 1, size * size);
      EXPECT_NEAR(kernels::solidAngle(float(u), float(v), float(size), float(size)) /
                      kernels::solidAngle(u, v, size, size),
                  1, 1e-6);
    }
}

} // namespace
} // namespace volcaustic::test
