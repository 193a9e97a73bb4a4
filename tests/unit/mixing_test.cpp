// The flow of two fluids: each part of a step against what is known of it, then the whole.
#include "simulation/mixing_state.h"
#include "volcaustic/error.h"
#include "volume/vdb_file.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <numbers>
#include <openvdb/openvdb.h>

namespace volcaustic::test {
namespace {

constexpr double kPi = std::numbers::pi;
const RunContext kContext;

template <class Value>
void fill(Lattice& lattice, const Value& value) {
  for (int k = 0; k < lattice.dims()[2]; ++k)
    for (int j = 0; j < lattice.dims()[1]; ++j)
      for (int i = 0; i < lattice.dims()[0]; ++i)
        lattice.at(i, j, k) = static_cast<float>(value(lattice.position(i, j, k)));
}

double sum(const Lattice& lattice) {
  double total = 0;
  for (const float v : lattice.values()) total += v;
  return total;
}

/// Without the layers below and above the box.
double sumInside(const Flow& flow) {
  double total = 0;
  for (int k = 1; k <= flow.cells[2]; ++k)
    for (int j = 0; j < flow.cells[1]; ++j)
      for (int i = 0; i < flow.cells[0]; ++i) total += flow.concentration.at(i, j, k);
  return total;
}

double sumOfCells(const MixingSimulation& flow) {
  const Vec3i n = flow.domain().dims;
  double total = 0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) total += flow.concentration({i, j, k});
  return total;
}

std::vector<float> cellsOf(const MixingSimulation& flow) {
  const Vec3i n = flow.domain().dims;
  std::vector<float> cells;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) cells.push_back(flow.concentration({i, j, k}));
  return cells;
}

/// Around the z axis through the middle of n cells: one radian a second.
StaggeredVelocity rotation(const Vec3i& n) {
  StaggeredVelocity velocity(n);
  fill(velocity.component[0], [&](const Vec3f& p) { return .5 * n[1] - p[1]; });
  fill(velocity.component[1], [&](const Vec3f& p) { return p[0] - .5 * n[0]; });
  return velocity;
}

TEST(Advection, AWholeTurnBringsABlobBack) {
  constexpr int kSteps = 96;
  constexpr float kStep = static_cast<float>(2 * kPi / kSteps);
  const Vec3i n{40, 40, 4};
  Flow flow(n);
  flow.velocity = rotation(n);
  fill(flow.concentration,
       [&](const Vec3f& p) { return std::exp(-((p[0] - 20) * (p[0] - 20) + (p[1] - 28) * (p[1] - 28)) / 18.); });
  const Lattice start = flow.concentration;
  const double amount = sumInside(flow);
  for (int step = 0; step < kSteps; ++step) {
    Flow next = flow;
    next.concentration = advected(flow.concentration, flow.velocity, kStep, kContext);
    EXPECT_NEAR(sumInside(next), amount, .005 * amount); // by itself
    balance(next, flow, kStep, kContext);
    flow = std::move(next);
  }
  EXPECT_NEAR(sumInside(flow), amount, 1e-3 * amount);
  double missed = 0;
  for (std::size_t i = 0; i < start.size(); ++i) {
    const float c = flow.concentration.values()[i];
    missed += std::abs(c - start.values()[i]);
    EXPECT_GE(c, 0);
    EXPECT_LE(c, 1);
  }
  EXPECT_LT(missed, .35 * sum(start));
  EXPECT_GT(flow.concentration.at(20, 28, 2), .72f); // semi-Lagrangian steps alone leave less than half
}

TEST(Advection, AConstantStaysAsItIs) {
  const Vec3i n{12, 9, 7};
  Lattice field = concentrationLattice(n);
  fill(field, [](const Vec3f&) { return .37f; });
  const Lattice later = advected(field, rotation(n), .4f, kContext);
  for (const float v : later.values()) EXPECT_EQ(v, .37f);
}

TEST(Diffusion, OfAnyLengthKeepsSumAndBounds) {
  const Vec3i n{11, 14, 9};
  constexpr auto kClosed = DiffusionEnds::Closed;
  for (const double amount : {.1, 10., 1e5}) {
    Lattice field(n, {.5f, .5f, .5f});
    field.at(3, 4, 5) = 1;
    diffuse(field, amount, {kClosed, kClosed, kClosed}, kContext);
    EXPECT_NEAR(sum(field), 1, 2e-3);
    for (const float v : field.values()) EXPECT_GE(v, 0);
  }
}

TEST(Diffusion, DecaysAWaveAtItsRate) {
  const Vec3i n{64, 2, 2};
  Lattice wave(n, {.5f, .5f, .5f});
  fill(wave, [&](const Vec3f& p) { return std::cos(kPi * p[0] / 64); });
  constexpr double kAmount = 20;
  for (int step = 0; step < 20; ++step)
    diffuse(wave, kAmount / 20, {DiffusionEnds::Closed, DiffusionEnds::Closed, DiffusionEnds::Closed}, kContext);
  const double expected = std::exp(-kAmount * kPi * kPi / (64. * 64)) * std::cos(kPi * .5 / 64);
  EXPECT_NEAR(wave.at(0, 1, 1), expected, 1e-4);
}

TEST(Pressure, LeavesNoDivergenceOfAnyFlowInAnyBox) {
  for (const Vec3i& n : {Vec3i{32, 32, 32}, Vec3i{7, 19, 33}, Vec3i{48, 5, 4}}) {
    Flow flow(n);
    for (int a = 0; a < 3; ++a)
      fill(flow.velocity.component[a], [&](const Vec3f& p) {
        const bool wall = p[a] == 0 || (a < 2 && p[a] == static_cast<float>(n[a]));
        return wall ? 0 : std::sin(1.3 * p[0] + a) + std::cos(2.1 * p[1] * p[2]);
      });
    EXPECT_GT(largestDivergence(flow.velocity, n), 1);
    PressureSolver solver(n);
    const int iterations = solver.project(flow, kContext);
    EXPECT_LE(iterations, 40);
    EXPECT_LT(largestDivergence(flow.velocity, n), 3e-4 * flow.velocity.maxSpeed({}));
    for (int k = 0; k < n[2]; ++k) EXPECT_EQ(flow.velocity.component[0].at(0, 1, k), 0); // walls
    // What is free of divergence stays as it is.
    const Flow before = flow;
    solver.project(flow, kContext);
    for (std::size_t i = 0; i < flow.velocity.component[2].size(); ++i)
      EXPECT_NEAR(flow.velocity.component[2].values()[i], before.velocity.component[2].values()[i], 1e-2);
  }
}

TEST(Pressure, HoldsALayerOfFluidUp) {
  const Vec3i n{16, 16, 16};
  Flow flow(n);
  // As buoyancy adds to layers of equal concentration: gradients, which move nothing.
  fill(flow.velocity.component[2], [](const Vec3f& p) { return p[2] > 0 ? .1 * p[2] * p[2] : 0; });
  PressureSolver(n).project(flow, kContext);
  for (const Lattice& component : flow.velocity.component)
    for (const float v : component.values()) EXPECT_NEAR(v, 0, 5e-3);
}

TEST(Pressure, TaylorGreenVorticesTurnAndDecay) {
  constexpr int kCells = 32;
  const Vec3i n{kCells, kCells, 4};
  Flow flow(n);
  const auto at = [](float x) { return kPi * x / kCells; };
  fill(flow.velocity.component[0], [&](const Vec3f& p) { return std::sin(at(p[0])) * std::cos(at(p[1])); });
  fill(flow.velocity.component[1], [&](const Vec3f& p) { return -std::cos(at(p[0])) * std::sin(at(p[1])); });
  PressureSolver solver(n);
  constexpr double kViscosity = 4, kTime = 8; // cells^2/s, s; speeds are cells a second
  constexpr int kSteps = 16;
  const auto energy = [&] {
    double e = 0;
    for (const Lattice& component : flow.velocity.component)
      for (const float v : component.values()) e += static_cast<double>(v) * v;
    return e;
  };
  const double before = energy();
  for (int step = 0; step < kSteps; ++step) {
    Flow next = flow;
    for (int a = 0; a < 3; ++a) {
      std::array<DiffusionEnds, 3> ends{};
      ends[a] = DiffusionEnds::Held;
      next.velocity.component[a] = advected(flow.velocity.component[a], flow.velocity, kTime / kSteps, kContext);
      diffuse(next.velocity.component[a], kViscosity * kTime / kSteps, ends, kContext);
    }
    solver.project(next, kContext);
    flow = std::move(next);
  }
  // exp(-2 nu k^2 t) of the speed, k = pi / cells in both directions.
  const double expected = std::exp(-4 * kViscosity * kPi * kPi / (kCells * kCells) * kTime);
  EXPECT_NEAR(energy() / before, expected, .05 * expected);
}

TEST(Mixing, StillFluidStaysStill) {
  MixingOptions options;
  options.resolution = 12;
  options.inflow = 0;
  MixingSimulation flow(options);
  for (int f = 0; f < 3; ++f) flow.advance();
  EXPECT_EQ(flow.frame(), 3);
  EXPECT_EQ(sumOfCells(flow), 0);
  EXPECT_EQ(flow.divergence(), 0);
}

TEST(Mixing, HoldsWhatFlowedInBetweenZeroAndOne) {
  MixingOptions options;
  options.size = {1, .8, 1.2};
  options.resolution = 30;
  options.disturbance = 0;
  options.diffusion = options.viscosity = 1e-4;
  MixingSimulation flow(options);
  EXPECT_EQ(flow.domain().dims, (Vec3i{25, 20, 30}));
  for (int f = 0; f < 12; ++f) {
    flow.advance();
    EXPECT_LT(flow.divergence(), 3e-4);
  }
  for (const float c : cellsOf(flow)) {
    EXPECT_GE(c, 0);
    EXPECT_LE(c, 1);
  }
  const double cell = flow.domain().voxelSize, inside = sumOfCells(flow) * cell * cell * cell;
  const double expected = options.inflow * kPi * options.inflowRadius * options.inflowRadius * 12 / 24;
  EXPECT_NEAR(inside, expected, .02 * expected);
  // Undiluted in the middle of the jet, and not there yet above.
  EXPECT_GT(flow.concentration({12, 10, 3}), .85f);
  EXPECT_LT(flow.concentration({12, 10, 25}), .01f);
}

TEST(Mixing, SameBitsForAnyNumberOfThreadsAndOtherOnesForAnotherSeed) {
  MixingOptions options;
  options.resolution = 34; // large enough for several pieces
  const auto run = [&](int threads, std::uint64_t seed) {
    RunContext ctx;
    ctx.threads = threads;
    ctx.seed = seed;
    MixingSimulation flow(options, ctx);
    for (int f = 0; f < 3; ++f) flow.advance();
    return cellsOf(flow);
  };
  const auto one = run(1, 0);
  EXPECT_EQ(std::memcmp(one.data(), run(3, 0).data(), one.size() * sizeof(float)), 0);
  EXPECT_NE(one, run(0, 1));
}

TEST(Mixing, GoesOnAfterItWasStopped) {
  MixingOptions options;
  options.resolution = 24;
  options.inflow = 3; // so that a frame takes several steps
  std::atomic<bool> stop{false}, stopping{false};
  RunContext ctx;
  ctx.cancel = &stop;
  ctx.onProgress = [&](std::string_view, double part) { stop = stopping && part > 0 && part < 1; };
  MixingSimulation stopped(options, ctx), other(options);
  stopped.advance();
  stopping = true;
  try {
    stopped.advance();
    ADD_FAILURE() << "not stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Cancelled);
  }
  EXPECT_TRUE(stop) << "within the frame";
  EXPECT_EQ(stopped.frame(), 1);
  stop = stopping = false;
  stopped.advance();
  other.advance();
  other.advance();
  EXPECT_EQ(cellsOf(stopped), cellsOf(other));
}

/// What diffuses stays in the box, also next to its walls.
TEST(Mixing, DiffusionKeepsWhatFlowedIn) {
  MixingOptions options;
  options.resolution = 24;
  options.buoyancy = 0;
  options.disturbance = 0;
  const auto held = [&](double diffusion) {
    options.diffusion = diffusion;
    MixingSimulation flow(options);
    for (int f = 0; f < 6; ++f) flow.advance();
    double sum = 0;
    for (const float c : cellsOf(flow)) sum += c;
    return sum;
  };
  EXPECT_NEAR(held(.02), held(0), .01 * held(0));
}

TEST(Mixing, AHoleLetsInWhatItsAreaDoes) {
  MixingOptions options;
  options.resolution = 32;
  options.buoyancy = options.disturbance = 0;
  for (const double radius : {.012, .05, .2}) {
    options.inflowRadius = radius;
    MixingSimulation flow(options);
    for (int f = 0; f < 4; ++f) flow.advance();
    double sum = 0;
    for (const float c : cellsOf(flow)) sum += c;
    const double cell = flow.domain().voxelSize,
                 expected = std::numbers::pi * radius * radius * options.inflow * 4 / 24;
    EXPECT_NEAR(sum * cell * cell * cell, expected, .02 * expected) << radius;
  }
  options.inflowRadius = 1e-4;
  EXPECT_THROW(MixingSimulation{options}, Error);
}

TEST(Mixing, FilesHoldWhatTheCellsHold) {
  MixingOptions options;
  options.resolution = 16;
  options.center = {1, 2, 3};
  options.disturbance = 0;
  MixingSimulation flow(options);
  for (int f = 0; f < 8; ++f) flow.advance();
  const auto file = std::filesystem::temp_directory_path() / "volcaustic-mixing-values.vdb";
  flow.write(file);
  initialiseOpenVdb();
  openvdb::io::File in(file.string());
  in.open();
  const auto amount = openvdb::gridPtrCast<openvdb::FloatGrid>(in.readGrid("concentration"));
  const auto velocity = openvdb::gridPtrCast<openvdb::Vec3SGrid>(in.readGrid("velocity"));
  in.close();
  std::filesystem::remove(file);
  const Domain& domain = flow.domain();
  for (int k = 0; k < 16; ++k)
    for (int j = 0; j < 16; ++j)
      for (int i = 0; i < 16; ++i) {
        const openvdb::Coord at(i, j, k);
        ASSERT_EQ(amount->tree().getValue(at), flow.concentration({i, j, k}));
        const openvdb::Vec3d middle = amount->transform().indexToWorld(at);
        const Vec3i cell{i, j, k};
        for (int a = 0; a < 3; ++a)
          ASSERT_NEAR(middle[a], domain.minCorner[a] + (cell[a] + .5) * domain.voxelSize, 1e-6);
      }
  // The faces of the hole: upwards, at the speed of the jet.
  EXPECT_NEAR(velocity->tree().getValue({8, 8, 0})[2], options.inflow, 2e-3);
  EXPECT_EQ(velocity->tree().getValue({1, 1, 0})[2], 0);
  EXPECT_EQ(velocity->tree().getValue({0, 8, 8})[0], 0) << "a wall";
  EXPECT_EQ(velocity->tree().getValue({8, 0, 8})[1], 0) << "a wall";
}

TEST(Mixing, WritesTheSameBytes) {
  MixingOptions options;
  options.resolution = 16;
  const auto folder = std::filesystem::temp_directory_path() / "volcaustic-mixing-test";
  std::filesystem::create_directories(folder);
  std::array<std::string, 2> bytes;
  for (std::string& file : bytes) {
    MixingSimulation flow(options);
    flow.advance();
    flow.write(folder / "mix.vdb");
    std::ifstream in(folder / "mix.vdb", std::ios::binary);
    file.assign(std::istreambuf_iterator<char>(in), {});
  }
  std::filesystem::remove_all(folder);
  EXPECT_GT(bytes[0].size(), 1000u);
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST(Mixing, SaysWhatIsWrong) {
  const auto failing = [](const MixingOptions& options, ErrorKind kind, const RunContext& ctx = {}) {
    try {
      MixingSimulation flow(options, ctx);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), kind) << error.what();
      return;
    }
    ADD_FAILURE() << "no error";
  };
  failing({.resolution = 4}, ErrorKind::Usage);
  failing({.size = {1, 1, .01}}, ErrorKind::Usage);
  failing({.inflow = std::nan("")}, ErrorKind::Usage);
  failing({.disturbance = 2}, ErrorKind::Usage);
  RunContext small;
  small.memoryLimit = 1 << 20;
  failing({}, ErrorKind::Input, small);
}

} // namespace
} // namespace volcaustic::test
