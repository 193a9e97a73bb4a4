// Coverage of functional objects without triangles: against closed forms, against plain sampling, and against the
// coverage of meshes of the same bodies.
#include "unit/voxelise_support.h"
#include "volcaustic/error.h"
#include "volcaustic/polygonise.h"
#include "volcaustic/shape.h"
#include "volume/voxelise_shape.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace volcaustic::test {
namespace {

constexpr double kPi = std::numbers::pi;

Domain cube(const Vec3d& corner, double edge, int dims) { return {corner, edge / dims, {dims, dims, dims}}; }

Body bodyOf(const Shape& shape) { return {nullptr, {}, 0, "body", shape}; }

template <class Visit>
void forEachVoxel(const CoveragePatch& patch, const Vec3i& dims, Visit&& visit) {
  const Vec3i first{patch.firstBrick[0] * 8, patch.firstBrick[1] * 8, patch.firstBrick[2] * 8};
  const Vec3i& own = patch.coverage.dims();
  for (int x = 0; x < dims[0]; ++x)
    for (int y = 0; y < dims[1]; ++y)
      for (int z = 0; z < dims[2]; ++z) {
        const Vec3i at{x - first[0], y - first[1], z - first[2]};
        bool within = true;
        for (int a = 0; a < 3; ++a) within = within && at[a] >= 0 && at[a] < own[a];
        visit(x, y, z, within ? patch.coverage.at(at[0], at[1], at[2]) : 0.0f);
      }
}

double coveredVolume(const Shape& shape, const Domain& domain, int supersample = 4) {
  const CoveragePatch patch = voxeliseShape(bodyOf(shape), domain, supersample);
  double sum = 0;
  forEachVoxel(patch, domain.dims, [&](int, int, int, float c) { sum += c; });
  return sum * std::pow(domain.voxelSize, 3);
}

TEST(VoxeliseShape, VolumesAreThoseOfClosedForms) {
  const Domain domain = cube({-1.5, -1.5, -1.5}, 3, 80);
  const auto expect = [&](const char* name, const Shape& shape, double volume) {
    EXPECT_NEAR(coveredVolume(shape.rotated({20, -35, 50}), domain) / volume, 1, 4e-4) << name;
  };
  expect("ellipsoid", Shape::ellipsoid({1.1, .8, .6}), 4. / 3 * kPi * 1.1 * .8 * .6);
  expect("cone", Shape::cone(.8, 1.2), kPi / 3 * .64 * 1.2);
  expect("cylinder", Shape::cylinder(.7, 1.4), kPi * .49 * 1.4);
  expect("paraboloid", Shape::paraboloid(.8, 1), .5 * kPi * .64);
  // Of one sheet: the mean of the sections' areas is 2/3 of the waist's and 1/3 of the rim's.
  expect("hyperboloid", Shape::hyperboloid(.5, .9, 1.6), 1.6 * kPi * (2 * .25 + .81) / 3);
  expect("cuboid", Shape::cuboid({1.2, .9, .7}), 1.2 * .9 * .7);
  expect("torus", Shape::torus(.8, .3), 2 * kPi * kPi * .8 * .09);
  expect("capsule", Shape::capsule({-.5, 0, 0}, {.4, .3, .2}, .4),
         kPi * .16 * std::sqrt(.81 + .09 + .04) + 4. / 3 * kPi * .064);
  const double cap = kPi / 3 * .25 * (3 - .5); // of a unit sphere, half the radius high
  expect("lens", Shape::sphere(1).translated({0, 0, -.5}) & Shape::sphere(1).translated({0, 0, .5}), 2 * cap);
}

TEST(VoxeliseShape, EveryVoxelIsWhatPlainSamplingGives) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int round = 0; round < 6; ++round) {
    std::vector<Shape> parts;
    for (int i = 0; i < 5; ++i) {
      const Vec3d at{number(random), number(random), number(random)};
      const Vec3d turn{180 * number(random), 180 * number(random), 180 * number(random)};
      const Shape solid = i % 3 == 0   ? Shape::ellipsoid({.6, .3, .4}).bulge(Shape::sphere(.4), .5)
                          : i % 3 == 1 ? Shape::cuboid({.6, .4, .5}, .05)
                                       : Shape::torus(.5, .2);
      parts.push_back(solid.rotated(turn).translated(at));
    }
    const Shape shape = Shape::unite(parts, .1 * round) - Shape::cylinder(.3, 3).rotated({30, 10, 0});
    const Domain domain = cube({-1.7, -1.3, -1.6}, 3, 30);
    const int s = 1 << (round % 4);
    SubLattice lattice{domain.minCorner, s / domain.voxelSize, round % 4, {0, 0, 0}, {30 * s, 30 * s, 30 * s}};
    const ShapeField field(shape);
    const CoveragePatch patch = voxeliseShape(bodyOf(shape), domain, s);
    int mixed = 0;
    forEachVoxel(patch, domain.dims, [&](int x, int y, int z, float coverage) {
      if ((x * 7 + y * 3 + z) % 5 != 0) return; // a fifth of them
      std::vector<Vec3d> points;
      for (int i = 0; i < s; ++i)
        for (int j = 0; j < s; ++j)
          for (int k = 0; k < s; ++k) {
            const Vec3d at{x * s + i + .5, y * s + j + .5, z * s + k + .5};
            Vec3d p;
            for (int a = 0; a < 3; ++a) p[a] = lattice.corner[a] + at[a] / lattice.scale;
            points.push_back(p);
          }
      std::vector<double> values(points.size());
      field.values(points, values);
      double inside = 0;
      for (const double v : values) inside += std::clamp(.5 + v * lattice.scale, 0.0, 1.0);
      EXPECT_NEAR(coverage, inside / (s * s * s), 1e-6) << x << " " << y << " " << z;
      mixed += coverage > 0 && coverage < 1;
    });
    if (s > 1) {
      EXPECT_GT(mixed, 100);
    }
  }
}

TEST(VoxeliseShape, AgreesWithTheMeshOfTheSameBall) {
  const Domain domain = cube({-1.2, -1.2, -1.2}, 2.4, 48);
  const auto mesh = std::make_shared<const Mesh>(icosphere({.1, .05, 0}, 1, 6));
  const Body triangles{mesh, {}, 0, "mesh"};
  const CoveragePatch one = voxeliseBody(triangles, domain, 4, FillRule::Exact);
  const CoveragePatch other =
      voxeliseBody(bodyOf(Shape::sphere(1).translated({.1, .05, 0})), domain, 4, FillRule::Auto);
  std::vector<float> coverage;
  forEachVoxel(one, domain.dims, [&](int, int, int, float c) { coverage.push_back(c); });
  std::size_t i = 0, mixed = 0;
  double worst = 0, difference = 0;
  forEachVoxel(other, domain.dims, [&](int, int, int, float c) {
    const double off = std::abs(double(c) - coverage[i++]);
    worst = std::max(worst, off);
    difference += off;
    mixed += c > 0 && c < 1;
  });
  // The mesh's coverage is a count of 64 samples, and off by a fiftieth in the mean.
  EXPECT_LE(worst, 8. / 64);
  EXPECT_LE(difference, .025 * double(mixed));
}

TEST(VoxeliseShape, AgreesWithItsOwnTriangles) {
  const Domain domain = cube({-1.5, -1.5, -1.5}, 3, 64);
  const Shape shape = (Shape::unite({Shape::ellipsoid({.9, .6, .5}).bulge(Shape::sphere(.5).translated({.6, .3, 0}), 1),
                                     Shape::torus(.8, .2).rotated({60, 20, 0})},
                                    .2) -
                       Shape::cylinder(.25, 3).rotated({20, 0, 0}))
                          .rotated({10, 20, 30});
  const double tolerance = .03 * domain.voxelSize;
  const auto mesh = std::make_shared<const Mesh>(polygonise(shape, {.tolerance = tolerance}));
  const CoveragePatch triangles = voxeliseBody({mesh, {}, 0, "mesh"}, domain, 4, FillRule::Exact);
  const CoveragePatch direct = voxeliseShape(bodyOf(shape), domain, 4);
  std::vector<float> coverage;
  forEachVoxel(triangles, domain.dims, [&](int, int, int, float c) { coverage.push_back(c); });
  std::size_t i = 0, mixed = 0;
  double sum = 0, difference = 0, worst = 0;
  forEachVoxel(direct, domain.dims, [&](int, int, int, float c) {
    const double off = std::abs(double(c) - coverage[i++]);
    worst = std::max(worst, off);
    difference += off;
    sum += c;
    mixed += c > 0 && c < 1;
  });
  // The triangles' count of samples, and a layer of three hundredths of a voxel over the surface.
  EXPECT_LE(worst, 12. / 64);
  EXPECT_LE(difference, .03 * double(mixed));
  EXPECT_GT(sum, 5000);
}

TEST(VoxeliseShape, IsTrueOnACurvedSurface) {
  const Domain domain = cube({-1.2, -1.2, -1.2}, 2.4, 48);
  const CoveragePatch patch = voxeliseShape(bodyOf(Shape::sphere(1).translated({.1, .05, 0})), domain, 4);
  double sum = 0, worst = 0;
  int mixed = 0;
  forEachVoxel(patch, domain.dims, [&](int x, int y, int z, float coverage) {
    if (coverage == 0 || coverage == 1 || (x * 7 + y * 5 + z * 3) % 16 != 0) return;
    constexpr int kFine = 32;
    int inside = 0;
    for (int i = 0; i < kFine; ++i)
      for (int j = 0; j < kFine; ++j)
        for (int k = 0; k < kFine; ++k) {
          const auto at = [&](int voxel, int part) { return -1.2 + domain.voxelSize * (voxel + (part + .5) / kFine); };
          inside += std::hypot(at(x, i) - .1, at(y, j) - .05, at(z, k)) <= 1;
        }
    const double off = std::abs(coverage - double(inside) / (kFine * kFine * kFine));
    sum += off;
    worst = std::max(worst, off);
    ++mixed;
  });
  ASSERT_GT(mixed, 300);
  EXPECT_LE(sum, .0015 * mixed);
  EXPECT_LE(worst, .015);
}

TEST(VoxeliseShape, IsExactForFacesAlongTheAxes) {
  const Domain domain = cube({0, 0, 0}, 32, 32);
  for (const double shift : {0.0, .3, .5, .77}) { // beside borders of bricks, and on them
    const Shape shape = Shape::cuboid({8, 8, 8}).translated({12 + shift, 20, 12});
    const CoveragePatch patch = voxeliseShape(bodyOf(shape), domain, 4);
    forEachVoxel(patch, domain.dims, [&](int x, int y, int z, float coverage) {
      const double low = std::max(8 + shift, double(x)), high = std::min(16 + shift, x + 1.0);
      const bool across = y >= 16 && y < 24 && z >= 8 && z < 16;
      ASSERT_NEAR(coverage, across ? std::max(0.0, high - low) : 0, 1e-6) << shift << ": " << x << " " << y << " " << z;
    });
  }
}

TEST(VoxeliseShape, SubVoxelsBesideABorderOfBricksCount) {
  // A sheet of which half a sub-voxel lies in the next brick.
  const Domain domain = cube({0, 0, 0}, 32, 32);
  const double h = .125;
  EXPECT_NEAR(coveredVolume(Shape::cuboid({8, 8, 8 + 2 * h}).translated({12, 12, 12}), domain), 64 * (8 + 2 * h), 1e-3);
  EXPECT_NEAR(coveredVolume(Shape::cuboid({6, 6, 8 - .02}).translated({12, 12, 12}), domain), 36 * (8 - .02), 1e-3);
}

TEST(VoxeliseShape, DoesNotDependOnThreads) {
  const Shape shape = Shape::torus(.8, .2).repeated(12, {{0, 0, 0}, {0, 15, 5}, {1, 1, 1}, {0, 0, 0}}, .05);
  const Domain domain = cube({-1.5, -1.5, -1.5}, 3, 64);
  RunContext one, two;
  one.threads = 1;
  two.threads = 4;
  const CoveragePatch a = voxeliseShape(bodyOf(shape), domain, 4, one),
                      b = voxeliseShape(bodyOf(shape), domain, 4, two);
  std::vector<float> values;
  forEachVoxel(a, domain.dims, [&](int, int, int, float c) { values.push_back(c); });
  std::size_t i = 0;
  forEachVoxel(b, domain.dims, [&](int, int, int, float c) { ASSERT_EQ(c, values[i++]); });
}

TEST(VoxeliseShape, WhatLiesInPartOutsideTheDomainIsCut) {
  const Domain domain = cube({0, 0, 0}, 1, 32);
  EXPECT_NEAR(coveredVolume(Shape::sphere(.8), domain), 4. / 3 * kPi * .512 / 8, 2e-4);
  EXPECT_EQ(coveredVolume(Shape::sphere(.8).translated({5, 0, 0}), domain), 0);
}

TEST(VoxeliseShape, EndlessAndEmptyShapesAreNamed) {
  const Domain domain = cube({0, 0, 0}, 1, 16);
  try {
    voxeliseShape(bodyOf(Shape::plane({0, 0, 1})), domain, 4);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Input);
    EXPECT_NE(std::string(error.what()).find("body: shape: has no end"), std::string::npos) << error.what();
  }
  std::string warning;
  RunContext ctx;
  ctx.onLog = [&](LogLevel, std::string_view line) { warning = line; };
  voxeliseShape(bodyOf((Shape::sphere(.1) & Shape::sphere(.1).translated({.25, 0, 0})).translated({.5, .5, .5})),
                domain, 4, ctx);
  EXPECT_NE(warning.find("nothing of the domain"), std::string::npos) << warning;
}

} // namespace
} // namespace volcaustic::test
