// Random trees of shapes: what must hold of every one of them.

#include "shape_trees.h"
#include "shapes/program.h"
#include "volcaustic/error.h"

#include <gtest/gtest.h>

namespace volcaustic::test {
namespace {

constexpr int kTrees = 250;

std::vector<double> valuesOf(const ShapeField& field, const std::vector<Vec3d>& points) {
  std::vector<double> values(points.size());
  field.values(points, values);
  return values;
}
double valueOf(const ShapeField& field, const Vec3d& p) { return valuesOf(field, {p})[0]; }
std::vector<double> valuesOf(const Shape& shape, const std::vector<Vec3d>& points) {
  return valuesOf(ShapeField(shape), points);
}

/// What a program gives at points, to the bit.
struct Answers {
  std::vector<double> values;
  std::vector<Vec3d> gradients;
  std::vector<std::uint32_t> parts;
  bool operator==(const Answers&) const = default;
};
Answers answersOf(const ShapeProgram& program, const std::vector<Vec3d>& points) {
  const PointRows rows(points);
  ShapeScratch scratch;
  Answers answers{std::vector<double>(points.size()), std::vector<Vec3d>(points.size()),
                  std::vector<std::uint32_t>(points.size())};
  BatchNumbers value, x, y, z;
  for (std::size_t i = 0; i < points.size(); i += kShapeBatch) {
    const ShapePoints batch = rows.batch(i);
    program.values(batch, answers.values.data() + i, scratch);
    program.parts(batch, answers.parts.data() + i, scratch);
    program.gradients(batch, {value.data(), {x.data(), y.data(), z.data()}}, scratch);
    for (int k = 0; k < batch.count; ++k) {
      EXPECT_EQ(value[k], answers.values[i + k]); // with gradients or without
      answers.gradients[i + k] = {x[k], y[k], z[k]};
    }
  }
  return answers;
}

/// Whether the function is smooth about a point: steps forwards and backwards, long and short, tell the same slope.
bool isSmooth(const ShapeField& field, const Vec3d& p, double step) {
  for (int a = 0; a < 3; ++a) {
    double slopes[4];
    int i = 0;
    for (const double h : {step, -step, 8 * step, -8 * step}) {
      Vec3d q = p;
      q[a] += h;
      slopes[i++] = (valueOf(field, q) - valueOf(field, p)) / (q[a] - p[a]);
    }
    const auto [low, high] = std::minmax_element(slopes, slopes + 4);
    if (*high - *low > 1e-3 * (1 + std::abs(*low))) return false;
  }
  return true;
}

} // namespace

TEST(ShapeFuzz, BoundsHoldValues) {
  for (int seed = 0; seed < kTrees; ++seed) {
    Random random(seed);
    const ShapeField field(ShapeTrees(random).any());
    for (int i = 0; i < 12; ++i) {
      const Box box = random.box(cube(3));
      const Interval bound = field.bound(box);
      for (const double value : valuesOf(field, random.points(box, 60))) {
        ASSERT_LE(bound.low, value) << seed;
        ASSERT_GE(bound.high, value) << seed;
      }
    }
  }
}

TEST(ShapeFuzz, BoundsOfAPointAreItsValue) {
  for (int seed = 0; seed < kTrees; ++seed) {
    Random random(seed);
    const ShapeField field(ShapeTrees(random).any());
    for (const Vec3d& p : random.points(cube(3), 20)) {
      const Interval bound = field.bound({p, p});
      EXPECT_LE(bound.high - bound.low, 1e-8 * (1 + magnitude(bound))) << seed;
    }
  }
}

TEST(ShapeFuzz, ProgramsCutToABoxGiveTheSameBitsInIt) {
  std::size_t whole = 0, left = 0;
  for (int seed = 0; seed < kTrees; ++seed) {
    Random random(seed);
    const ShapeProgram program(ShapeTrees(random).any());
    ShapeScratch scratch;
    ShapeProgram cut, cutAgain;
    for (int i = 0; i < 8; ++i) {
      Box box = random.box(cube(3));
      const Interval bound = program.prune(box, cut, scratch), same = program.bound(box, scratch);
      EXPECT_EQ(bound.low, same.low);
      EXPECT_EQ(bound.high, same.high);
      std::vector<Vec3d> points = random.points(box, 40);
      EXPECT_TRUE(answersOf(cut, points) == answersOf(program, points)) << seed;
      whole += program.size();
      left += cut.size();
      // And once more, to a half of that box.
      box.max[i % 3] = .5 * (box.min[i % 3] + box.max[i % 3]);
      cut.prune(box, cutAgain, scratch);
      points = random.points(box, 20);
      EXPECT_TRUE(answersOf(cutAgain, points) == answersOf(program, points)) << seed;
      EXPECT_LE(cutAgain.size(), cut.size());
    }
  }
  EXPECT_LT(left, whole / 2);
}

TEST(ShapeFuzz, GradientsAreDifferences) {
  int smooth = 0, points = 0;
  for (int seed = 0; seed < kTrees; ++seed) {
    Random random(seed);
    const ShapeField field(ShapeTrees(random).any());
    const std::vector<Vec3d> at = random.points(cube(2), 20);
    std::vector<Vec3d> gradients(at.size());
    field.gradients(at, gradients);
    for (std::size_t i = 0; i < at.size(); ++i) {
      ++points;
      if (!isSmooth(field, at[i], 1e-5)) continue;
      ++smooth;
      const Vec3d expected = differences([&](const Vec3d& p) { return valueOf(field, p); }, at[i], 1e-5);
      EXPECT_NEAR(apart(gradients[i], expected), 0, 1e-3 * (1 + length(expected))) << seed;
    }
  }
  EXPECT_GT(smooth, points * 8 / 10);
}

TEST(ShapeFuzz, HashesTellShapesApart) {
  std::vector<std::uint64_t> hashes, programs;
  for (int seed = 0; seed < kTrees; ++seed) {
    Random first(seed), again(seed);
    const Shape shape = ShapeTrees(first).any(), same = ShapeTrees(again).any();
    EXPECT_EQ(shapeHash(shape), shapeHash(same));
    const ShapeProgram program(shape), sameProgram(same);
    EXPECT_EQ(program.hash(), sameProgram.hash());
    const std::vector<Vec3d> points = first.points(cube(2), 50);
    EXPECT_TRUE(answersOf(program, points) == answersOf(sameProgram, points));
    EXPECT_NE(shapeHash(shape), shapeHash(shape.translated({1e-12, 0, 0})));
    EXPECT_NE(shapeHash(shape), shapeHash(shape.named("another")));
    hashes.push_back(shapeHash(shape));
    programs.push_back(program.hash());
  }
  for (auto* list : {&hashes, &programs}) {
    std::sort(list->begin(), list->end());
    EXPECT_EQ(std::unique(list->begin(), list->end()), list->end());
  }
}

TEST(ShapeFuzz, BoundsOfAShapeHoldItsInside) {
  int bounded = 0, inside = 0;
  for (int seed = 0; seed < kTrees / 4; ++seed) {
    Random random(seed);
    const ShapeField field(ShapeTrees(random).any());
    Box box;
    try {
      box = field.bounds();
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("no end"), std::string::npos);
      continue;
    }
    ++bounded;
    const std::vector<Vec3d> points = random.points(cube(2), 2000);
    const std::vector<double> values = valuesOf(field, points);
    for (std::size_t i = 0; i < points.size(); ++i)
      if (values[i] > 0) {
        ++inside;
        for (int a = 0; a < 3; ++a) EXPECT_TRUE(points[i][a] >= box.min[a] && points[i][a] <= box.max[a]) << seed;
      }
  }
  EXPECT_GT(bounded, 15);
  EXPECT_GT(inside, 500);
}

TEST(ShapeFuzz, SetsObeyTheirLaws) {
  for (int seed = 0; seed < kTrees / 2; ++seed) {
    Random random(seed);
    ShapeTrees trees(random);
    const Shape a = trees.tree(3), b = trees.tree(3);
    const std::vector<Vec3d> points = random.points(cube(2), 100);
    EXPECT_EQ(valuesOf(~(a | b), points), valuesOf(~a & ~b, points));
    EXPECT_EQ(valuesOf(~(a & b), points), valuesOf(~a | ~b, points));
    EXPECT_EQ(valuesOf(a - b, points), valuesOf(a & ~b, points));
    EXPECT_EQ(valuesOf(~~a, points), valuesOf(a, points));
    EXPECT_EQ(valuesOf(Shape::subtract({a, b}, .2), points), valuesOf(Shape::intersect({a, ~b}, .2), points));
    const std::vector<double> ofA = valuesOf(a, points), ofB = valuesOf(b, points), joined = valuesOf(a | b, points);
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(joined[i], std::max(ofA[i], ofB[i]));
  }
}

TEST(ShapeFuzz, SmoothUnionsAddOnlyWhereSurfacesAreNear) {
  constexpr double kBlend = .3;
  int near = 0;
  for (int seed = 0; seed < kTrees / 2; ++seed) {
    Random random(seed);
    ShapeTrees trees(random);
    const Shape a = trees.tree(3), b = trees.tree(3);
    const std::vector<Vec3d> points = random.points(cube(2), 100);
    const std::vector<double> ofA = valuesOf(a, points), ofB = valuesOf(b, points),
                              blended = valuesOf(Shape::unite({a, b}, kBlend), points),
                              swapped = valuesOf(Shape::unite({b, a}, kBlend), points);
    EXPECT_EQ(blended, swapped);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double sharp = std::max(ofA[i], ofB[i]), distance = std::abs(ofA[i] - ofB[i]);
      EXPECT_GE(blended[i], sharp);
      EXPECT_LE(blended[i], sharp + kBlend / 6 + 1e-15);
      if (distance >= kBlend)
        EXPECT_EQ(blended[i], sharp);
      else
        near += blended[i] > sharp;
    }
  }
  EXPECT_GT(near, 500);
}

TEST(ShapeFuzz, GradientsHaveLengthOneOnSurfacesOfSolids) {
  int found = 0;
  for (int seed = 0; seed < 400; ++seed) {
    Random random(seed);
    const Shape solid = ShapeTrees(random).solid(); // where it is; scales of functions that are no quadrics are even
    const ShapeField field(solid);
    for (int i = 0; i < 20; ++i) {
      Vec3d in = random.point(cube(1.5)), out = random.point(cube(1.5));
      if (valueOf(field, in) <= 0) std::swap(in, out);
      if (valueOf(field, in) <= 0 || valueOf(field, out) > 0) continue;
      Vec3d middle = in;
      for (int k = 0; k < 60; ++k) {
        for (int a = 0; a < 3; ++a) middle[a] = .5 * (in[a] + out[a]);
        (valueOf(field, middle) > 0 ? in : out) = middle;
      }
      if (!isSmooth(field, middle, 1e-7)) continue; // an edge
      ++found;
      Vec3d g;
      field.gradients(std::span(&middle, 1), std::span(&g, 1));
      EXPECT_NEAR(length(g), 1, 1e-6) << seed << ": type " << solid.node().kind.index();
    }
  }
  EXPECT_GT(found, 1000);
}

} // namespace volcaustic::test
