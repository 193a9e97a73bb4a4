// Budgets, sequences, threads, parts, limits and hostile shapes.
#include "unit/polygonise_support.h"

#include <atomic>
#include <random>

namespace volcaustic::test {
namespace {

bool operator==(const Mesh& a, const Mesh& b) {
  return a.positions == b.positions && a.triangles == b.triangles && a.triangleGroup == b.triangleGroup &&
         a.groupNames == b.groupNames;
}

/// A chain of blended and sharp solids with names; `lift` moves one of them.
Shape machine(double lift) {
  const Shape base = (Shape::cuboid({2, 2, .4}) - Shape::cylinder(.3, 2)).named("base");
  const Shape knob = Shape::unite({Shape::sphere(.3), Shape::capsule({0, 0, 0}, {0, 0, .6}, .12)}, .1).named("knob");
  return base | knob.translated({.6, .6, .5 + lift}) | Shape::torus(.4, .1).translated({-.5, -.5, .4});
}

TEST(PolygoniseRuns, BudgetsAreReachedFromBelow) {
  const Shape shapes[] = {Shape::sphere(1), Shape::torus(1, .3), machine(0), Shape::ellipsoid({1, .2, .3})};
  for (const Shape& shape : shapes)
    for (const int budget : {3000, 20000}) {
      PolygoniseOptions options;
      options.triangles = budget;
      const std::size_t count = polygonise(shape, options, threads(2)).triangles.size();
      EXPECT_LE(count, static_cast<std::size_t>(budget));
      // Of flat faces along the lattice counts do not come in small steps.
      EXPECT_GE(count, static_cast<std::size_t>((&shape == &shapes[2] ? .9 : .98) * budget)) << &shape - shapes;
    }
}

TEST(PolygoniseRuns, SameBitsForAnyNumberOfThreads) {
  shapes::NoiseDisplacement noise;
  noise.amplitude = .1;
  noise.size = .3;
  const Shape shape = machine(0).displaced(noise);
  const Mesh one = polygonise(shape, cells(.05), threads(1));
  EXPECT_TRUE(one == polygonise(shape, cells(.05), threads(2)));
  EXPECT_TRUE(one == polygonise(shape, cells(.05), threads(5)));
}

TEST(PolygoniseRuns, SequencesGiveWhatFreshRunsGive) {
  Polygoniser polygoniser;
  for (int frame = 0; frame < 4; ++frame) {
    const Shape shape = machine(.03 * frame);
    PolygoniseReport fresh;
    const Mesh mesh = polygonise(shape, cells(.02), threads(2), &fresh);
    EXPECT_TRUE(mesh == polygoniser.polygonise(shape, cells(.02), threads(2)));
    const PolygoniseReport& report = polygoniser.report();
    EXPECT_EQ(report.blocks, fresh.blocks);
    EXPECT_EQ(report.deviation, fresh.deviation);
    if (frame == 0) continue;
    // Of base, knob and ring only the knob moves.
    EXPECT_GT(report.reusedBlocks, report.blocks / 2);
    EXPECT_LT(report.reusedBlocks, report.blocks);
    EXPECT_LT(report.evaluations, fresh.evaluations * 2 / 3);
  }
  // The same once more costs no evaluation of the lattice at all.
  polygoniser.polygonise(machine(.09), cells(.02));
  EXPECT_EQ(polygoniser.report().reusedBlocks, polygoniser.report().blocks);
  // Other names for the same solids are other groups.
  const Mesh renamed = polygoniser.polygonise(machine(.09).named("all") | Shape::sphere(.2).named("ball"), cells(.02));
  EXPECT_NE(std::find(renamed.groupNames.begin(), renamed.groupNames.end(), "ball"), renamed.groupNames.end());
}

TEST(PolygoniseRuns, TrianglesKnowTheirParts) {
  const Mesh mesh = polygonise(machine(0), cells(.05));
  ASSERT_EQ(mesh.triangleGroup.size(), mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vec3d& p = mesh.positions[mesh.triangles[i][0]];
    const std::string& name = mesh.groupNames[mesh.triangleGroup[i]];
    const bool isRing = p[0] < -.1 && p[1] < -.1 && p[2] > .35;
    if (p[2] < .19 || p[2] > .6 || isRing) {
      EXPECT_EQ(name, isRing ? "" : p[2] > .6 ? "knob" : "base");
    }
  }
  EXPECT_TRUE(polygonise(Shape::sphere(1), cells(.1)).triangleGroup.empty());
}

TEST(PolygoniseRuns, CostGoesByTheSurface) {
  PolygoniseReport coarse, fine;
  polygonise(machine(0), cells(.02), threads(2), &coarse);
  polygonise(machine(0), cells(.01), threads(2), &fine);
  const double ratio = static_cast<double>(fine.evaluations) / static_cast<double>(coarse.evaluations);
  EXPECT_GT(ratio, 3);
  EXPECT_LT(ratio, 4.6);
}

TEST(PolygoniseRuns, TouchingAndDegenerateShapesAreManifold) {
  const Shape unit = Shape::cuboid({1, 1, 1});
  std::vector<Shape> board;
  for (int i = 0; i < 27; ++i)
    if ((i + i / 3 + i / 9) % 2 == 0)
      board.push_back(unit.translated({double(i % 3), double(i / 3 % 3), double(i / 9)}));
  shapes::NoiseDisplacement noise;
  noise.amplitude = .4;
  noise.size = .3;
  noise.octaves = 3;
  const std::pair<const char*, Shape> cases[] = {
      {"touching spheres", Shape::sphere(1) | Shape::sphere(1).translated({2, 0, 0})},
      {"checkerboard", Shape::unite(board)},
      {"turned checkerboard", Shape::unite(board).rotated({10, 20, 30})},
      {"noise", Shape::sphere(1).displaced(noise)},
      {"two cones", Shape::cone(1, 1) | Shape::cone(1, 1).rotated({180, 0, 0}).translated({0, 0, 2})},
      {"thin sheet", Shape::cuboid({2, 2, .01})},
      {"a point of the lattice", Shape::sphere(1e-9) | Shape::sphere(.5).translated({1, 0, 0})}};
  for (const auto& [name, shape] : cases) {
    SCOPED_TRACE(name);
    const Mesh mesh = polygonise(shape, cells(.125), threads(2));
    expectManifold(mesh);
    const MeshReport r = checkMesh(mesh);
    EXPECT_TRUE(r.closedAndConsistent()) << describeDefects(r);
    EXPECT_EQ(r.nonManifoldEdges, 0u);
  }
}

class RandomTrees {
public:
  explicit RandomTrees(unsigned seed) : mRandom(seed) {}

  Shape tree(int depth) {
    const int kind = number(0, depth > 0 ? 11 : 5);
    if (kind <= 5) return solid(kind).placed(placement());
    if (kind == 6) return Shape::unite({tree(depth - 1), tree(depth - 1)}, blend());
    if (kind == 7) return Shape::intersect({tree(depth - 1), tree(depth - 1)}, blend());
    if (kind == 8) return Shape::subtract({tree(depth - 1), tree(depth - 1)}, blend());
    if (kind == 9) return tree(depth - 1).shell(.1 + .2 * real());
    if (kind == 10) return tree(depth - 1).offset(.1 * real() - .05).named("offset");
    return tree(depth - 1).repeated(3, placement(), blend());
  }

private:
  double real() { return std::uniform_real_distribution<double>(0, 1)(mRandom); }
  int number(int low, int high) { return std::uniform_int_distribution<int>(low, high)(mRandom); }
  double blend() { return number(0, 1) * .3 * real(); }
  Shape solid(int kind) {
    const double a = .3 + real(), b = .3 + real(), c = .3 + real();
    if (kind == 0) return Shape::sphere(a);
    if (kind == 1) return Shape::ellipsoid({a, b, c});
    if (kind == 2) return Shape::cuboid({a, b, c});
    if (kind == 3) return Shape::cylinder(a, b);
    if (kind == 4) return Shape::cone(a, b);
    return Shape::torus(a, .2 * a);
  }
  Placement placement() {
    // Now and then on the lattice, where faces and points of it meet.
    if (number(0, 2) == 0) return {{.125 * number(-8, 8), .125 * number(-8, 8), .125 * number(-8, 8)}, {0, 0, 0}};
    return {{real() - .5, real() - .5, real() - .5}, {360 * real(), 360 * real(), 360 * real()}, {1, 1, .5 + real()}};
  }

  std::mt19937 mRandom;
};

TEST(PolygoniseRuns, RandomTreesAreClosedManifolds) {
  int meshes = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    Mesh mesh;
    try {
      mesh = polygonise(RandomTrees(seed).tree(3), cells(.125), threads(2));
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Input) << error.what();
      continue;
    }
    ++meshes;
    expectManifold(mesh);
    EXPECT_TRUE(checkMesh(mesh).closedAndConsistent());
    if (HasFailure()) return;
  }
  EXPECT_GT(meshes, 40);
}

TEST(PolygoniseRuns, WhatCannotBeDoneIsSaid) {
  const auto kindOf = [](const Shape& shape, const PolygoniseOptions& options, const RunContext& ctx = {}) {
    try {
      polygonise(shape, options, ctx);
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.kind();
    }
    return ErrorKind::Internal;
  };
  EXPECT_EQ(kindOf({}, {}), ErrorKind::Input);
  EXPECT_EQ(kindOf(Shape::plane({0, 0, 1}), {}), ErrorKind::Input);
  EXPECT_EQ(kindOf(Shape::sphere(1) & Shape::sphere(1).translated({3, 0, 0}), {}), ErrorKind::Input);
  EXPECT_EQ(kindOf(Shape::sphere(1), cells(1e-5)), ErrorKind::Input);
  EXPECT_EQ(kindOf(Shape::sphere(1).translated({1e9, 0, 0}), cells(.1)), ErrorKind::Input);
  EXPECT_EQ(kindOf(Shape::sphere(.01).translated({.05, .05, .05}), cells(1)), ErrorKind::Input);
  EXPECT_EQ(kindOf(Shape::sphere(1), cells(std::nan(""))), ErrorKind::Usage);
  PolygoniseOptions options;
  options.resolution = -1;
  EXPECT_EQ(kindOf(Shape::sphere(1), options), ErrorKind::Usage);
  RunContext small;
  small.memoryLimit = 1 << 20;
  EXPECT_EQ(kindOf(Shape::sphere(1), cells(.005), small), ErrorKind::Input);
  const std::atomic<bool> cancel = true;
  RunContext cancelled;
  cancelled.cancel = &cancel;
  EXPECT_EQ(kindOf(Shape::sphere(1), cells(.05), cancelled), ErrorKind::Cancelled);
}

} // namespace
} // namespace volcaustic::test
