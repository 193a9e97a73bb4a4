// Irradiance on receivers against closed forms: light that comes straight, and photons whose landings are known.

#include "transport/receiver_light.h"

#include "support/csv.h"
#include "support/lights.h"
#include "support/shared_data.h"
#include "support/solids.h"
#include "transport/emission.h"

#include <cmath>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {
namespace {

using kernels::Double3;
using kernels::EmissionFrame;
using kernels::Landing;
using Random = std::mt19937_64;

constexpr double kPi = 3.14159265358979323846;
/// Voxels of a tenth, so that grid and world differ.
constexpr Domain kDomain{{-1, -1, 0}, 0.1, {20, 20, 30}};

Receiver square(double x, double y, double z, double width, double height, int resolution) {
  Receiver r;
  r.placement = {{{width, 0, 0, x}, {0, height, 0, y}, {0, 0, 1, z}}};
  r.resolution = resolution;
  return r;
}
Receiver meshReceiver(Mesh mesh, int resolution) {
  Receiver r;
  r.mesh = std::make_shared<const Mesh>(std::move(mesh));
  r.resolution = resolution;
  return r;
}

/// World place of a texel's middle.
struct Place {
  double x, y;
};
Place placeOf(const Receiver& r, const ReceiverSet& set, std::size_t texel) {
  const auto& s = set.surfaces()[0];
  const double u = (static_cast<double>(texel % s.columns) + 0.5) / s.columns - 0.5,
               v = 0.5 - (static_cast<double>(texel / s.columns) + 0.5) / s.rows;
  return {r.placement[0][3] + r.placement[0][0] * u, r.placement[1][3] + r.placement[1][1] * v};
}

LightPart partOf(const Light& light) { return partsOf({&light, 1})[0]; }
ReceivedLight directLight(const ReceiverSet& set, const std::vector<Light>& lights, const Ambient& ambient = {},
                          float entry = kernels::kNeverBends) {
  ReceiverLight light(set, kDomain, ambient, {});
  PhotonOptions options;
  options.grid = {64, 64};
  for (const LightPart& part : partsOf(lights)) {
    const auto frames = emissionFrames(part.light, part.number, kDomain, options, 1);
    for (const EmissionFrame& f : frames) light.addDirect(part, f, std::vector<float>(f.cells(), entry));
    if (frames.empty()) light.addDirect(part, {}, {});
  }
  return light.finish();
}

// --- light that comes straight -------------------------------------------------------------------------------------

TEST(ReceiverDirect, IsIrradianceTimesTheCosine) {
  const Receiver floor = square(0.1, -0.2, 0.35, 3, 2, 24);
  const ReceiverSet set({&floor, 1}, kDomain, {});
  for (const Vec3d& d : {Vec3d{0, 0, -1}, Vec3d{3, 0, -4}, Vec3d{0, 5, -12}}) {
    const ReceivedLight light = directLight(set, {sun(d)});
    const double cosine = -d[2] / std::hypot(d[0], d[1], d[2]);
    const Rgb power{1, 2, .5};
    for (std::size_t t = 0; t < light.direct.size() / 3; ++t)
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(light.direct[3 * t + c], cosine * power[c], 1e-5);
    EXPECT_EQ(light.irradiance, light.direct);
  }
  for (const float e : directLight(set, {sun({0.1, 0, 1})}).direct) ASSERT_EQ(e, 0) << "lit from behind";
}

// A lamp far away has one raster, one nearby six; what they see adds up to the lamp.
TEST(ReceiverDirect, OfALampFallsWithTheSquareAndTheCosine) {
  const Receiver floor = square(0, 0, 0.2, 4, 4, 80);
  const ReceiverSet set({&floor, 1}, kDomain, {});
  for (const Vec3d& at : {Vec3d{0.3, -0.2, 1.7}, Vec3d{4, 3, 9}, Vec3d{0, 0, 3.1}, Vec3d{-0.013, 0.02, 0.6}}) {
    const ReceivedLight light = directLight(set, {lamp(at)});
    for (std::size_t t = 0; t < light.direct.size() / 3; ++t) {
      const Place p = placeOf(floor, set, t);
      const double r = std::hypot(p.x - at[0], p.y - at[1], 0.2 - at[2]), exact = 50 * (at[2] - 0.2) / (r * r * r);
      ASSERT_NEAR(light.direct[3 * t + 1] / exact, 1, 0.02) << t;
    }
  }
}

TEST(ReceiverDirect, OfASpotEndsWithItsCone) {
  const Receiver floor = square(0, 0, 0, 6, 6, 60);
  const ReceiverSet set({&floor, 1}, kDomain, {});
  // The last one's cone misses the domain, but not the floor.
  for (const Vec3d& at : {Vec3d{0, 0, 4}, Vec3d{0.3, 0.1, 1.5}, Vec3d{2.5, 2.4, 1}}) {
    const ReceivedLight light = directLight(set, {spot(at, {0, 0, -1}, 10, 20)});
    double watts = 0;
    for (std::size_t t = 0; t < light.direct.size() / 3; ++t) {
      const Place p = placeOf(floor, set, t);
      const double angle = std::atan(std::hypot(p.x - at[0], p.y - at[1]) / at[2]) * 180 / kPi;
      if (angle < 6) {
        ASSERT_NEAR(light.direct[3 * t] / (100 * std::pow(std::cos(angle * kPi / 180), 3) / (at[2] * at[2])), 1, 0.02);
      }
      if (angle > 30) {
        ASSERT_EQ(light.direct[3 * t], 0);
      }
      watts += light.direct[3 * t] * set.texels()[t].area;
    }
    // The falloff is the square of a ramp in the cosine; its mean over that range of cosines is a third.
    const double inner = std::cos(10 * kPi / 180), outer = std::cos(20 * kPi / 180);
    EXPECT_NEAR(watts / (100 * 2 * kPi * (1 - inner + (inner - outer) / 3)), 1, 0.02);
  }
}

TEST(ReceiverDirect, DecaysInTheMediumOfTheBoxOnly) {
  Ambient fog;
  fog.attenuation = {0.2, 0.5, 1.5};
  const Receiver floor = square(0, 0, 0.5, 1, 1, 8), below = square(0, 0, -1, 1, 1, 8);
  const Rgb power{1, 2, .5};
  for (const auto& [receiver, way] : {std::pair{floor, 2.5}, {below, 3.0}}) {
    const ReceiverSet set({&receiver, 1}, kDomain, {});
    const ReceivedLight light = directLight(set, {sun({0, 0, -1})}, fog);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(light.direct[c], power[c] * std::exp(-fog.attenuation[c] * way), 1e-5);
  }
}

// Half a floor under another receiver, whichever side that shows.
TEST(ReceiverDirect, ReceiversShadowEachOther) {
  for (const double flip : {1.0, -1.0}) {
    Receiver roof = square(0.5, 0, 1, 1, 3, 16);
    roof.placement[2][2] = flip;
    const std::vector<Receiver> receivers{square(0, 0, 0, 2, 2, 40), roof};
    const ReceiverSet set(receivers, kDomain, {});
    const ReceivedLight light = directLight(set, {sun({0, 0, -1})});
    for (std::size_t t = 0; t < 1600; ++t) {
      const Place p = placeOf(receivers[0], set, t);
      ASSERT_NEAR(light.direct[3 * t], p.x < 0 ? 1 : 0, 1e-5) << t;
    }
    EXPECT_NEAR(light.direct[3 * 1600], flip > 0 ? 1 : 0, 1e-5);
  }
}

// A smooth ball has no patches of its own shadow on its lit side.
TEST(ReceiverDirect, AMeshIsLitLikeItsFacets) {
  const Receiver receiver = meshReceiver(ellipsoid({0, 0, 1}, {0.7, 0.7, 0.7}, 24), 256);
  const ReceiverSet set({&receiver, 1}, kDomain, {});
  const Double3 d = kernels::normalize(Double3(1, 2, -3));
  const ReceivedLight light = directLight(set, {sun({1, 2, -3})});
  double watts = 0, exact = 0;
  for (std::size_t t = 0; t < set.texels().size(); ++t) {
    watts += double(light.direct[3 * t]) * set.texels()[t].area;
    if (set.texels()[t].cover < 0.999f) continue;
    const double cosine = -dot(Double3(set.triangles()[set.texels()[t].triangle].normal), d);
    if (std::abs(cosine) > 0.1) {
      ASSERT_NEAR(light.direct[3 * t], std::max(cosine, 0.0), 1e-5);
    }
  }
  for (const auto& t : set.triangles()) {
    const Double3 a(t.corner[0]);
    const double facing = -dot(cross(Double3(t.corner[1]) - a, Double3(t.corner[2]) - a), d);
    exact += 0.5 * std::max(facing, 0.0) * 0.01;
  }
  EXPECT_NEAR(watts / exact, 1, 0.01);
}

// What bends before the floor is the photons'; what bends behind it is not.
TEST(ReceiverDirect, LeavesToPhotonsWhatBendsOnTheWay) {
  const Receiver floor = square(0, 0, 1, 4, 4, 64);
  const ReceiverSet set({&floor, 1}, kDomain, {});
  for (const Light& light : {sun({0, 0, -1}), lamp({0, 0, 40})}) {
    for (const auto& [entry, dark] : {std::pair{19.0f, true}, {21.5f, false}}) { // voxels from the top of the box
      const ReceivedLight received = directLight(set, {light}, {}, entry);
      for (std::size_t t = 0; t < received.direct.size() / 3; ++t) {
        const Place p = placeOf(floor, set, t);
        const double beside = std::max(std::abs(p.x), std::abs(p.y));
        if (beside > 0.93 && beside < 1.1) continue; // about the raster's end
        ASSERT_EQ(received.direct[3 * t] == 0, dark && beside < 1) << t;
      }
    }
  }
}

// --- photons that landed -------------------------------------------------------------------------------------------

EmissionFrame rasterOf(int side, bool jitter = false) {
  EmissionFrame f;
  f.columns = f.rows = side;
  f.jitter = jitter;
  f.seed = 7;
  return f;
}

/// Photons of one watt in all (green; red and blue 2 and 3) over [-1, 1]^2, landing where the map sends them on a
/// square of edge 2 with `texels` along a side; outside it they are lost.
struct Mapped {
  ReceivedLight light;
  double landed = 0, received = 0;
};
using Map = std::function<Place(Place)>;
Mapped mapped(const ReceiverSet& set, int side, bool jitter, const Map& map, const RunContext& ctx = {}) {
  const EmissionFrame frame = rasterOf(side, jitter);
  std::vector<Landing> landings(frame.cells());
  Mapped m;
  for (std::int64_t i = 0; i < frame.cells(); ++i) {
    const auto at = frame.pointOf(i);
    const Place p = map({2 * at.column / side - 1, 2 * at.row / side - 1});
    if (!(std::abs(p.x) < 1 && std::abs(p.y) < 1)) continue;
    const double n = set.surfaces()[0].columns, watt = 1.0 / static_cast<double>(frame.cells());
    const auto power = static_cast<float>(watt);
    landings[i] = {float((p.x + 1) / 2 * n), float((1 - p.y) / 2 * n), p.x + p.y > 0, {2 * power, power, 3 * power}};
    m.landed += power;
  }
  ReceiverLight light(set, kDomain, {}, ctx);
  light.addLandings(frame, landings);
  m.light = light.finish();
  for (std::size_t t = 0; t < set.texels().size(); ++t) {
    m.received += double(m.light.caustic[3 * t + 1]) * set.texels()[t].area;
    EXPECT_NEAR(m.light.caustic[3 * t], 2 * m.light.caustic[3 * t + 1], 1e-6 + 1e-5 * m.light.caustic[3 * t]);
  }
  return m;
}
ReceiverSet screen(int texels) {
  const Receiver r = square(0, 0, 0, 2, 2, texels);
  return ReceiverSet({&r, 1}, kDomain, {});
}

TEST(ReceiverLandings, NothingIsLostOrGained) {
  const ReceiverSet set = screen(50);
  Random random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  const Map maps[] = {[](Place p) { return p; },
                      [](Place) {
                        return Place{.3, .4};
                      }, // a point
                      [](Place p) {
                        return Place{p.x, .1};
                      }, // a line
                      [](Place p) {
                        return Place{1.7 * p.x, -2.3 * p.y};
                      }, // beyond the edges
                      [](Place p) {
                        return Place{p.x + (p.y > .2 ? .5 : -.3), p.y * p.x};
                      }, // torn
                      [](Place p) {
                        return Place{p.x * p.x * p.x - .4 * p.x, p.y * p.x};
                      }, // folded
                      [&](Place) {
                        return Place{u(random), u(random)};
                      }}; // chaos
  for (const bool jitter : {false, true})
    for (const Map& map : maps)
      for (const int side : {1, 2, 9, 64}) {
        const Mapped m = mapped(set, side, jitter, map);
        EXPECT_NEAR(m.received, m.landed, 1e-6 * m.landed + 1e-12);
      }
}

TEST(ReceiverLandings, EvenLightIsEven) {
  for (const bool jitter : {false, true})
    for (const int side : {40, 100}) {
      const ReceiverSet set = screen(64);
      const Mapped m = mapped(set, side, jitter, [](Place p) { return Place{1.2 * p.x, 1.2 * p.y}; });
      for (int row = 8; row < 56; ++row)
        for (int column = 8; column < 56; ++column)
          ASSERT_NEAR(m.light.caustic[3 * (row * 64 + column) + 1], 1 / (4 * 1.44), jitter ? 0.003 : 1e-5)
              << side << ' ' << row << ' ' << column;
    }
}

// Light that parts leaves the gap dark, and both sides are even up to it.
TEST(ReceiverLandings, NoBeamBridgesATear) {
  const ReceiverSet set = screen(100);
  for (const bool jitter : {false, true}) {
    const Mapped m = mapped(set, 60, jitter, [](Place p) { return Place{.5 * p.x + (p.x > 0 ? .3 : -.3), .9 * p.y}; });
    for (int row = 10; row < 90; ++row)
      for (int column = 15; column < 85; ++column) {
        const double x = (column + 0.5) / 50 - 1, e = m.light.caustic[3 * (row * 100 + column) + 1];
        if (std::abs(x) < 0.25) {
          ASSERT_EQ(e, 0) << column << ' ' << row;
        }
        if (std::abs(x) > 0.38 && std::abs(x) < 0.7) {
          ASSERT_NEAR(e / (1 / (4 * 0.45)), 1, jitter ? 0.05 : 0.01) << column << ' ' << row;
        }
      }
  }
}

TEST(ReceiverLandings, WhatIsNoLandingDoesNoHarm) {
  const ReceiverSet set = screen(20);
  const EmissionFrame frame = rasterOf(3);
  std::vector<Landing> landings(9, Landing{5, 5, 0, {1, 1, 1}});
  landings[1].triangle = 1 << 20;
  landings[2].column = std::nanf("");
  landings[3].row = -1e30f;
  landings[4].column = 1e30f;
  landings[5].triangle = -1;
  ReceiverLight light(set, kDomain, {}, {});
  light.addLandings(frame, landings);
  light.addLandings(rasterOf(1), std::vector<Landing>(1));
  const ReceivedLight received = light.finish();
  double sum = 0;
  for (std::size_t t = 0; t < set.texels().size(); ++t) sum += double(received.caustic[3 * t]) * set.texels()[t].area;
  EXPECT_NEAR(sum, 6, 1e-5);
}

TEST(ReceiverLandings, ThreadsChangeNoBit) {
  const ReceiverSet set = screen(100);
  const Map map = [](Place p) { return Place{p.x * p.x * p.x - .4 * p.x + (p.y > .2 ? .3 : 0), .8 * p.y}; };
  RunContext one, three;
  one.threads = 1;
  three.threads = 3;
  EXPECT_EQ(mapped(set, 150, true, map, one).light.caustic, mapped(set, 150, true, map, three).light.caustic);
}

/// The part of [-1, 1] that f, of which turns are the only turning points, sends below y.
double measureBelow(const std::function<double(double)>& f, const std::vector<double>& turns, double y) {
  double sum = 0;
  for (std::size_t i = 1; i < turns.size(); ++i) {
    double low = turns[i - 1], high = turns[i];
    const bool rising = f(high) > f(low);
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      ((f(middle) < y) == rising ? low : high) = middle;
    }
    sum += rising ? low - turns[i - 1] : turns[i] - low;
  }
  return sum / 2;
}

/// Mean difference from the exact irradiance over its mean, of an estimate and of a histogram. Photons go through the
/// same f along x and y, so exact powers of texels are products.
struct Errors {
  double estimate = 0, histogram = 0;
};
Errors errorsOf(const std::function<double(double)>& f, const std::vector<double>& turns, int side, bool jitter) {
  constexpr int kTexels = 48;
  const ReceiverSet set = screen(kTexels);
  const Mapped m = mapped(set, side, jitter, [&](Place p) { return Place{f(p.x), f(p.y)}; });
  std::vector<double> counts(kTexels * kTexels), along(kTexels);
  const EmissionFrame frame = rasterOf(side, jitter);
  const auto texel = [&](double x) { return std::clamp(static_cast<int>((x + 1) / 2 * kTexels), 0, kTexels - 1); };
  for (std::int64_t i = 0; i < frame.cells(); ++i) {
    const auto at = frame.pointOf(i);
    const double x = f(2 * at.column / side - 1), y = f(2 * at.row / side - 1);
    if (std::abs(x) < 1 && std::abs(y) < 1)
      counts[(kTexels - 1 - texel(y)) * kTexels + texel(x)] += 1.0 / static_cast<double>(frame.cells());
  }
  for (int i = 0; i < kTexels; ++i)
    along[i] = measureBelow(f, turns, 2.0 * (i + 1) / kTexels - 1) - measureBelow(f, turns, 2.0 * i / kTexels - 1);
  Errors e;
  double all = 0;
  const double area = 4.0 / (kTexels * kTexels);
  for (int row = 2; row < kTexels - 2; ++row)
    for (int column = 2; column < kTexels - 2; ++column) {
      const double exact = along[column] * along[kTexels - 1 - row];
      e.estimate += std::abs(m.light.caustic[3 * (row * kTexels + column) + 1] * area - exact);
      e.histogram += std::abs(counts[row * kTexels + column] - exact);
      all += exact;
    }
  return {e.estimate / all, e.histogram / all};
}

// A lens with aberration before its focus: no caustic, and the error falls with the square of the raster's spacing.
TEST(ReceiverLandings, ConvergeWhereLightIsSmooth) {
  const auto f = [](double x) { return 0.75 * x + 0.5 * x * x * x; };
  const std::vector<double> turns{-1, 1};
  const Errors coarse = errorsOf(f, turns, 24, false), medium = errorsOf(f, turns, 48, false),
               fine = errorsOf(f, turns, 96, false);
  EXPECT_LT(medium.estimate, coarse.estimate / 3);
  EXPECT_LT(fine.estimate, medium.estimate / 3);
  EXPECT_LT(fine.estimate, fine.histogram / 20);
  const Errors random = errorsOf(f, turns, 96, true);
  EXPECT_LT(random.estimate, random.histogram / 8);
}

// Behind the focus: four folds, brightness without bound along them.
TEST(ReceiverLandings, ConvergeAcrossFolds) {
  const auto f = [](double x) { return 1.6 * x * x * x - 0.8 * x; };
  const double turn = std::sqrt(0.8 / 4.8);
  const std::vector<double> turns{-1, -turn, turn, 1};
  const Errors coarse = errorsOf(f, turns, 40, false), medium = errorsOf(f, turns, 120, false),
               fine = errorsOf(f, turns, 360, false);
  EXPECT_LT(medium.estimate, coarse.estimate / 2);
  EXPECT_LT(fine.estimate, medium.estimate / 2);
  EXPECT_LT(fine.estimate, coarse.estimate / 9);
  for (const Errors& e : {coarse, medium, fine}) EXPECT_LT(e.estimate, e.histogram / 6);
}

/// Where parallel light at distance b from the axis of a ball of index 1.5 and radius R goes through the plane at t
/// behind its centre, by Snell's law twice.
double behindBall(double b, double radius, double t) {
  const double in = std::asin(b / radius), inside = std::asin(b / radius / 1.5), exit = 2 * inside - in;
  return radius * std::sin(exit) - (t - radius * std::cos(exit)) * std::tan(2 * (in - inside));
}

TEST(ReceiverLandings, BehindABallLensAreTheGroundTruth) {
  const auto csv = sharedPath("reference/ball_sphere15_R0.3.csv");
  VOLCAUSTIC_NEED_SHARED(csv);
  constexpr double kRadius = 0.3, kPlane = 0.38;
  Table table = readCsv(csv);
  std::vector<double> b = table["b"], r;
  for (std::size_t i = 0; i < b.size(); ++i) { // straight from the exit to where the axis is crossed
    const double t0 = table["t_exit"][i], t1 = table["t_axis_crossing"][i];
    r.push_back(table["r_exit_signed"][i] * (t1 - kPlane) / (t1 - t0));
    ASSERT_NEAR(r.back(), behindBall(b[i], kRadius, kPlane), 1e-6);
  }
  constexpr int kSide = 400, kTexels = 201;
  const Receiver screen = square(0, 0, 0, 0.08, 0.08, kTexels);
  const ReceiverSet set({&screen, 1}, kDomain, {});
  const EmissionFrame frame = rasterOf(kSide);
  std::vector<Landing> landings(frame.cells());
  for (std::int64_t i = 0; i < frame.cells(); ++i) {
    const auto at = frame.pointOf(i);
    const double x = 0.2 * (at.column / kSide - 0.5), y = 0.2 * (at.row / kSide - 0.5), h = std::hypot(x, y);
    const double scale = h > 0 ? behindBall(h, kRadius, kPlane) / h : 0;
    const double column = (x * scale / 0.08 + 0.5) * kTexels, row = (y * scale / 0.08 + 0.5) * kTexels;
    if (!(column > 0 && column < kTexels && row > 0 && row < kTexels)) continue;
    const auto power = static_cast<float>(0.04 / (kSide * kSide)); // 1 W/m2
    landings[i] = {float(column), float(row), 0, {power, power, power}};
  }
  ReceiverLight light(set, kDomain, {}, {});
  light.addLandings(frame, landings);
  const ReceivedLight received = light.finish();
  const auto at = [&](double x) {
    const kernels::TexelPoint<float> p{static_cast<float>((x / 0.08 + 0.5) * kTexels), 0.5f * kTexels};
    return kernels::irradianceAt<float>(set.scene(received.irradiance.data()), 0, p).x;
  };
  EXPECT_NEAR(at(0) / std::pow(b[0] / r[0], 2), 1, 0.01);
  for (std::size_t i = 3; i + 1 < b.size() && b[i] < 0.09; i += 2) {
    const double exact = b[i] * (b[i + 1] - b[i - 1]) / (r[i] * (r[i + 1] - r[i - 1]));
    EXPECT_NEAR(at(r[i]) / exact, 1, 0.02) << "b " << b[i];
  }
}

// --- maps ----------------------------------------------------------------------------------------------------------

Mesh soup(int triangles) {
  Random random(5);
  std::uniform_real_distribution<double> u(-1, 1), size(-0.1, 0.1);
  Mesh mesh;
  for (int i = 0; i < triangles; ++i) {
    const Vec3d p{u(random), u(random), u(random)};
    for (int k = 0; k < 3; ++k)
      mesh.positions.push_back({p[0] + size(random), p[1] + size(random), p[2] + size(random)});
    const auto n = static_cast<std::uint32_t>(3 * i);
    mesh.triangles.push_back({n, n + 1, n + 2});
  }
  return mesh;
}
/// A ramp that winds over itself twice, shallow enough to be projected.
Mesh spiral() {
  Mesh mesh;
  constexpr std::uint32_t kSteps = 60;
  for (std::uint32_t i = 0; i <= kSteps; ++i)
    for (const double r : {0.4, 1.0}) {
      const double phi = 4 * kPi * i / kSteps;
      mesh.positions.push_back({r * std::cos(phi), r * std::sin(phi), 0.01 * i});
    }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  }
  return mesh;
}
Mesh withDefects(Mesh mesh) {
  mesh.triangles.push_back(mesh.triangles[0]);
  mesh.triangles.push_back({0, 0, 1});
  mesh.positions.push_back(mesh.positions[0]);
  mesh.triangles.push_back({0, static_cast<std::uint32_t>(mesh.positions.size() - 1), 1});
  return mesh;
}
double areaOf(const Mesh& mesh) {
  double area = 0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const auto at = [&](std::uint32_t v) {
      return Double3(mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]);
    };
    area += 0.5 * kernels::length(cross(at(j) - at(i), at(k) - at(i)));
  }
  return area;
}

TEST(ReceiverAtlas, EveryTriangleHasTexelsOfItsArea) {
  const Mesh whole = ellipsoid({0, 0, 1}, {0.7, 0.7, 0.7}, 8), damaged = withDefects(whole);
  const std::pair<const char*, Mesh> meshes[] = {
      {"ball", ellipsoid({0, 0, 1}, {0.7, 0.7, 0.7}, 24)},
      {"needle", ellipsoid({0, 0, 1}, {0.01, 0.01, 5}, 24)},
      {"soup", soup(300)},
      {"spiral", spiral()},
      {"tiny", {{{0, 0, 0}, {1e-3, 0, 0}, {0, 1e-3, 0}}, {{0, 1, 2}}, {}, {}}},
      {"defects", damaged}};
  for (const auto& [name, mesh] : meshes)
    for (const int resolution : {16, 256}) {
      const Receiver receiver = meshReceiver(mesh, resolution);
      const ReceiverSet set({&receiver, 1}, kDomain, {});
      double area = 0;
      for (const auto& t : set.texels()) {
        area += t.area;
        ASSERT_EQ(t.area > 0, t.triangle >= 0);
      }
      EXPECT_NEAR(area / areaOf(mesh.triangles.size() == damaged.triangles.size() ? whole : mesh), 1, 1e-3) << name;
      std::vector<int> owner(set.texels().size(), -1);
      for (std::size_t i = 0; i < set.charts().size(); ++i) {
        const TexelRange& r = set.charts()[i].texels;
        ASSERT_TRUE(r.column >= 0 && r.row >= 0 && r.column + r.columns <= set.surfaces()[0].columns &&
                    r.row + r.rows <= set.surfaces()[0].rows);
        for (int y = r.row; y < r.row + r.rows; ++y)
          for (int x = r.column; x < r.column + r.columns; ++x) {
            int& o = owner[set.texelAt(0, x, y)];
            ASSERT_EQ(o, -1) << name << ": charts overlap";
            o = static_cast<int>(i);
          }
      }
      for (std::size_t k = 0; k < set.triangles().size(); ++k) {
        const TexelRange& r = set.charts()[set.chartOf(static_cast<std::int32_t>(k))].texels;
        for (const auto& [column, row] : set.triangles()[k].texel) {
          ASSERT_TRUE(column >= r.column + 0.999 && column <= r.column + r.columns - 0.999) << name;
          ASSERT_TRUE(row >= r.row + 0.999 && row <= r.row + r.rows - 0.999) << name;
        }
      }
    }
}

// One scale for all charts, and no triangle squeezed by more than the steepest of a chart may be.
TEST(ReceiverAtlas, TexelsStandForLikeAreas) {
  const Receiver receiver = meshReceiver(ellipsoid({0, 0, 1}, {0.7, 0.4, 0.9}, 24), 256);
  const ReceiverSet set({&receiver, 1}, kDomain, {});
  double least = 1e300, most = 0, used = 0;
  for (const auto& t : set.triangles()) {
    const Double3 a(t.corner[0]);
    const double onMap = std::abs(doubleArea(mapTriangle(t))),
                 ratio = kernels::length(cross(Double3(t.corner[1]) - a, Double3(t.corner[2]) - a)) / onMap;
    least = std::min(least, ratio);
    most = std::max(most, ratio);
    used += 0.5 * onMap;
  }
  EXPECT_LT(most / least, 1 / 0.6 + 0.01);
  EXPECT_GT(used / (256 * 256), 0.35);
  EXPECT_LT(set.charts().size(), 30u);
}

// Light that falls evenly on all of a ball's texels is even where charts meet, too.
TEST(ReceiverAtlas, ABilinearLookupNeverLeavesTheSurface) {
  const Receiver receiver = meshReceiver(ellipsoid({0, 0, 1}, {0.7, 0.7, 0.7}, 24), 128);
  const ReceiverSet set({&receiver, 1}, kDomain, {});
  ReceiverLight light(set, kDomain, {}, {});
  const EmissionFrame frame = rasterOf(1);
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(set.texels().size()); ++i) {
    const auto& texel = set.texels()[i];
    if (texel.triangle < 0) continue;
    const float power = texel.area;
    const std::vector<Landing> one{
        {float(i % 128) + 0.5f, float(i / 128) + 0.5f, texel.triangle, {power, power, power}}};
    if (i % 5 == 0) light.addLandings(frame, one);
  }
  light.addDirect(partOf(lamp({0, 0, 1})), {}, {}); // the ball's inside is dark
  const ReceivedLight received = light.finish();
  EXPECT_EQ(received.direct, std::vector<float>(received.direct.size(), 0.0f));
  // One more time with all texels at 1: what a lookup on the surface reads is 1 everywhere.
  std::vector<float> even(received.caustic.size(), 0.0f);
  ReceiverLight sunlit(set, kDomain, {}, {});
  for (const Vec3d& d : {Vec3d{0, 0, -1}, Vec3d{0, 0, 1}}) sunlit.addDirect(partOf(sun(d)), {}, {});
  const ReceivedLight z = sunlit.finish();
  const kernels::ReceiverScene scene = set.scene(z.irradiance.data());
  Random random(6);
  std::normal_distribution<double> n;
  for (int i = 0; i < 20000; ++i) {
    const Double3 d = kernels::normalize(Double3(n(random), n(random), n(random)));
    if (std::abs(d.z) < 0.3) continue;
    const Double3 from = Double3(10, 10, 10) - d * 20;
    const auto hit = kernels::nearestHit<float>(scene, kernels::Float3(from), kernels::Float3(d), 0, 100, true);
    ASSERT_GE(hit.triangle, 0);
    const double e = kernels::irradianceAt<float>(scene, 0, kernels::texelOf<float>(scene, hit)).x;
    ASSERT_NEAR(e, std::abs(d.z), 0.12);
  }
}

TEST(ReceiverMaps, AreWrittenWithTheirSurface) {
  Receiver ballReceiver = meshReceiver(ellipsoid({0, 0, 1}, {0.7, 0.7, 0.7}, 8), 64);
  ballReceiver.name = "ball";
  Receiver floor = square(0, 0, 0, 2, 1, 32);
  floor.name = "floor";
  const std::vector<Receiver> receivers{floor, ballReceiver};
  const ReceiverSet set(receivers, kDomain, {});
  const ReceivedLight light = directLight(set, {sun({0, 0, -1})});
  const std::vector<ReceiverMap> maps = set.maps(light.caustic, light.direct);
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[0].image.width, 32);
  EXPECT_EQ(maps[0].image.height, 16);
  const TemporaryFolder folder;
  for (const ReceiverMap& map : maps) {
    const auto path = folder / (map.name + ".exr");
    ImageWriteOptions floats;
    floats.half = false;
    writeReceiverMap(path, map, floats);
    const Image back = readImage(path);
    const int r = back.find("R"), direct = back.find("direct.R"), caustic = back.find("caustic.R");
    ASSERT_TRUE(r >= 0 && direct >= 0 && caustic >= 0);
    EXPECT_EQ(back.planes[r], map.image.planes[0]);
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "floor.obj"));
  const Mesh surface = readMesh(folder / "ball.obj");
  EXPECT_EQ(surface.triangles, ballReceiver.mesh->triangles);
  EXPECT_EQ(surface.positions, ballReceiver.mesh->positions);
  std::ifstream file(folder / "ball.obj");
  std::string word;
  std::vector<double> texture;
  for (double u, v; file >> word;)
    if (word == "vt" && file >> u >> v) {
      texture.push_back(u);
      texture.push_back(v);
    }
  ASSERT_EQ(texture.size(), 6 * surface.triangles.size());
  for (const double t : texture) ASSERT_TRUE(t >= 0 && t <= 1);
}

} // namespace
} // namespace volcaustic::test
