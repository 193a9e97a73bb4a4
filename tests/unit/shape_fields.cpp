// Shapes by what they are: volumes in closed form, the paper's functions, and what operations make of them.

#include "shape_support.h"
#include "volcaustic/error.h"
#include "volcaustic/shape.h"

#include <gtest/gtest.h>
#include <numbers>

namespace volcaustic::test {
namespace {

constexpr double kPi = std::numbers::pi;

std::vector<double> valuesOf(const Shape& shape, const std::vector<Vec3d>& points) {
  std::vector<double> values(points.size());
  ShapeField(shape).values(points, values);
  return values;
}
double valueOf(const Shape& shape, const Vec3d& p) { return valuesOf(shape, {p})[0]; }

/// By the middles of cubic cells over the shape's own bounds, each as full as its value and a surface across the
/// middle say: values are distances there.
double volumeOf(const Shape& shape) {
  const ShapeField field(shape);
  const Box box = field.bounds();
  double whole = 1;
  for (int a = 0; a < 3; ++a) whole *= box.max[a] - box.min[a];
  const double edge = std::cbrt(whole) / 64;
  const auto cells = [&](int a) { return static_cast<int>(std::ceil((box.max[a] - box.min[a]) / edge)); };
  double volume = 0;
  std::vector<Vec3d> row(cells(2));
  std::vector<double> values(row.size());
  for (int i = 0; i < cells(0); ++i)
    for (int j = 0; j < cells(1); ++j) {
      for (int k = 0; k < cells(2); ++k)
        row[k] = {box.min[0] + (i + .5) * edge, box.min[1] + (j + .5) * edge, box.min[2] + (k + .5) * edge};
      field.values(row, values);
      for (const double v : values) volume += std::clamp(v / edge + .5, 0., 1.);
    }
  return volume * edge * edge * edge;
}
void expectVolume(const Shape& shape, double expected) {
  EXPECT_NEAR(volumeOf(shape) / expected, 1, 4e-3) << shape.node().kind.index();
}

Shape of(shapes::Kind kind, std::vector<Shape> parts = {}) {
  return Shape({"", std::move(kind), {}, {}, std::move(parts)});
}

} // namespace

TEST(ShapeFields, VolumesOfSolidsAreThoseInClosedForm) {
  expectVolume(Shape::sphere(.7), 4 * kPi / 3 * .343);
  expectVolume(Shape::ellipsoid({.5, .8, 1.1}), 4 * kPi / 3 * .5 * .8 * 1.1);
  expectVolume(of(shapes::Cylinder{{.5, .8}, 1.4}), kPi * .5 * .8 * 1.4);
  expectVolume(Shape::cone(.6, 1.5), kPi * .36 * 1.5 / 3);
  expectVolume(Shape::paraboloid(.6, 1.5), kPi * .36 * 1.5 / 2);
  expectVolume(Shape::hyperboloid(.4, 1, 1.6), kPi * 1.6 * (2 * .16 + 1) / 3);
  // Of two sheets: caps of height h = H/2 - waist, pi rim^2 h^2 (3 waist + h) / (3 (H^2/4 - waist^2)) each.
  const double h = .6;
  expectVolume(of(shapes::Hyperboloid{2, .2, .8, 1.6}), 2 * kPi * .64 * h * h * (.6 + h) / (3 * (.64 - .04)));
  expectVolume(Shape::cuboid({1, .7, .5}), .35);
  const double r = .15, a = 1 - 2 * r, b = .7 - 2 * r, c = .5 - 2 * r;
  expectVolume(Shape::cuboid({1, .7, .5}, r),
               a * b * c + 2 * r * (a * b + b * c + c * a) + kPi * r * r * (a + b + c) + 4 * kPi / 3 * r * r * r);
  expectVolume(Shape::torus(1, .25), 2 * kPi * kPi * .0625);
  expectVolume(Shape::capsule({0, 0, 0}, {1, 1, .5}, .3), kPi * .09 * 1.5 + 4 * kPi / 3 * .027);
}

TEST(ShapeFields, VolumesOfProfilesFollowPappus) {
  // A triangle whose middle is 1 from the axis, a square that lies on the axis, and discs.
  expectVolume(Shape::revolution({{{.7, 0}, {1.3, 0}, {1, .9}}, {}, false}), 2 * kPi * .27);
  expectVolume(Shape::revolution({{{0, 0}, {.8, 0}, {.8, 1.2}, {0, 1.2}}, {}, false}), kPi * .64 * 1.2);
  expectVolume(Shape::revolution({{{0, -1}, {0, 1}}, {1, 0}, false}), 4 * kPi / 3);
  expectVolume(Shape::revolution({{{1.2, 0}, {.8, 0}}, {1, 1}, false}), 2 * kPi * kPi * .04);
  expectVolume(Shape::extrusion({{{0, 0}, {1, 0}, {1, .5}, {0, 1}}, {}, false}, .8), .6);
  expectVolume(Shape::extrusion({{{0, -.5}, {0, .5}}, {1, 0}, false}, .8), .1 * kPi);
}

TEST(ShapeFields, AQuadricWithDeviationsIsInsideWhereThePapersFunctionIs) {
  Random random(1);
  // F = Q + sum of w max(0, q)^3, equations (1) and (2), all in the plainest form.
  const Shape shape = Shape::ellipsoid({1, .8, .6})
                          .bulge(Shape::sphere(.5).translated({.8, 0, .3}), 3)
                          .bulge(Shape::ellipsoid({.3, .6, .4}).translated({-.5, .2, 0}), -1.5);
  const auto cubed = [](double q) { return q > 0 ? q * q * q : 0; };
  int inside = 0;
  for (const Vec3d& p : random.points(cube(1.5), 4000)) {
    const auto [x, y, z] = p;
    const auto ball = [](double u, double v, double w) { return 1 - u * u - v * v - w * w; };
    const double f = ball(x, y / .8, z / .6) + 3 * cubed(ball((x - .8) / .5, y / .5, (z - .3) / .5)) -
                     1.5 * cubed(ball((x + .5) / .3, (y - .2) / .6, z / .4));
    EXPECT_TRUE(std::abs(f) < 1e-12 || (valueOf(shape, p) > 0) == (f > 0));
    inside += f > 0;
  }
  EXPECT_GT(inside, 300);
}

TEST(ShapeFields, ValuesAreDistancesNextToTheSurface) {
  Random random(2);
  const Shape ball = Shape::sphere(2).scaled(.5);
  EXPECT_NEAR(valueOf(ball, {0, 0, 0}), 1, 1e-12);
  for (int i = 0; i < 100; ++i) {
    Vec3d p = random.point(cube(1));
    const double depth = random.between(-.02, .02), r = length(p);
    for (double& c : p) c *= (1 - depth) / r;
    EXPECT_NEAR(valueOf(ball, p), depth, depth * depth);
  }
  EXPECT_NEAR(valueOf(Shape::plane({0, 0, 5}, .25).translated({0, 0, 1}), {3, 4, 1}), .25, 1e-12);
  EXPECT_NEAR(valueOf(Shape::cuboid({1, 1, 1}).rotated({0, 0, 45}), {0, 0, 2}), -1.5, 1e-12);
}

TEST(ShapeFields, OperationsMoveSurfacesAsFarAsTheySay) {
  expectVolume(Shape::sphere(.7).offset(.02), 4 * kPi / 3 * .373248); // a quadric: to first order
  EXPECT_NEAR(valueOf(Shape::cuboid({1, 1, 1}).offset(.25), {0, 0, .75}), 0, 1e-15);
  EXPECT_NEAR(valueOf(Shape::cuboid({1, 1, 1}).offset(-.25), {0, 0, .25}), 0, 1e-15);
  const Shape wall = Shape::cuboid({1, 1, 1}).shell(.1);
  EXPECT_NEAR(valueOf(wall, {.45, 0, 0}), .05, 1e-15);
  EXPECT_LT(valueOf(wall, {0, 0, 0}), 0);
  expectVolume(wall, 1 - .512);
  // Scales scale what is beneath them, lengths included.
  EXPECT_NEAR(valueOf(Shape::cuboid({1, 1, 1}).offset(.25).scaled(2), {0, 0, 1.5}), 0, 1e-15);
  shapes::WaveDisplacement waves{.1, .5, 0, {1, 0, 0}, false};
  EXPECT_NEAR(valueOf(Shape::plane({0, 0, 1}).displaced(waves), {1, 0, .1}), 0, 1e-12);
  EXPECT_NEAR(valueOf(Shape::plane({0, 0, 1}).displaced(waves), {.25, 0, -.1}), 0, 1e-12);
}

TEST(ShapeFields, CopiesAreWhereTheirPlacementsPutThem) {
  Placement step;
  step.translate = {1, 0, 0};
  step.rotate = {0, 0, 90};
  const Shape row = Shape::sphere(.2).translated({0, 2, 0}).repeated(3, step);
  // At once beyond the step's own placement: (0, 2), then 90 degrees and (1, 0), then the same again.
  for (const Vec3d& centre : {Vec3d{0, 2, 0}, {-1, 0, 0}, {1, -1, 0}}) EXPECT_NEAR(valueOf(row, centre), .2, 1e-12);
  EXPECT_LT(valueOf(row, {1, 1, 0}), 0);
  expectVolume(Shape::cuboid({.5, .5, .5}).copied({{{1, 0, 0}}, {{-1, 0, 0}}, {{0, 2, 0}}}), 3 * .125);
}

TEST(ShapeFields, PartsAreThoseThatMakeTheSurface) {
  const Shape shape = Shape::unite({Shape::sphere(1).named("ball"), Shape::cuboid({1, 1, 1}).translated({3, 0, 0})}) -
                      Shape::cylinder(.2, 9).named("bore");
  const ShapeField field(shape.named("all"));
  const std::vector<Vec3d> points{{1, 0, 0}, {3.5, 0, 0}, {.2, 0, .1}};
  std::vector<std::uint32_t> parts(3);
  field.parts(points, parts);
  std::vector<std::string> names;
  for (const std::uint32_t part : parts) names.push_back(field.partNames().at(part));
  EXPECT_EQ(names, (std::vector<std::string>{"ball", "all", "bore"}));
}

TEST(ShapeFields, BoundsAreClose) {
  const Box box = ShapeField(Shape::ellipsoid({1, 2, .5}).translated({10, -20, 30})).bounds();
  const Vec3d low{9, -22, 29.5}, high{11, -18, 30.5};
  for (int a = 0; a < 3; ++a) {
    EXPECT_LE(box.min[a], low[a]);
    EXPECT_GE(box.min[a], low[a] - .05);
    EXPECT_GE(box.max[a], high[a]);
    EXPECT_LE(box.max[a], high[a] + .05);
  }
  for (const Shape& endless : {Shape::plane({0, 0, 1}), ~Shape::sphere(1), of(shapes::Cylinder{{1, 1}, 1, true})})
    EXPECT_THROW((void)ShapeField(endless).bounds(), Error);
  const Shape nothing = Shape::sphere(1) & Shape::sphere(1).translated({3, 0, 0});
  EXPECT_EQ(ShapeField(nothing).bounds().max, (Vec3d{0, 0, 0}));
  EXPECT_LT(ShapeField(Shape()).bound(cube(1)).high, 0);
}

/// Far outside, where a slab's polynomial is a difference of huge numbers, its cube must not outweigh the quadric.
TEST(ShapeFields, DeviationsBySlabsHaveAnEnd) {
  const auto slab = [](const Vec3d& normal) { return Shape::slab(normal, .5).translated({.1, .2, .3}); };
  const Shape shape =
      Shape::sphere(1).bulge(slab({1, 2, .5}), .5).bulge(slab({0, 1, -1}), -.25).bulge(slab({1, 0, .1}), .25);
  const Box box = ShapeField(shape).bounds();
  for (int a = 0; a < 3; ++a) {
    EXPECT_LT(box.min[a], -.9);
    EXPECT_GT(box.min[a], -1.6);
    EXPECT_GT(box.max[a], .9);
    EXPECT_LT(box.max[a], 1.6);
  }
}

TEST(ShapeFields, BadNodesAreRefusedInOneLine) {
  const shapes::Profile axis{{{0, 0}, {0, 1}, {0, 2}}, {}, false}, left{{{-1, 0}, {1, 0}, {0, 1}}, {}, false},
      one{{{0, 0}}, {}, true}, twice{{{1, 0}, {1, 0}, {2, 1}}, {}, false}, fewer{{{1, 0}, {2, 0}, {2, 1}}, {1}, false};
  for (const shapes::Profile& p : {axis, left, one, twice, fewer}) {
    try {
      (void)Shape::revolution(p);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find("revolution: "), 0u) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
  EXPECT_THROW((void)Shape::sphere(std::nan("")), Error);
  EXPECT_THROW((void)Shape::sphere(-1), Error);
  EXPECT_THROW((void)Shape::cuboid({1, 1, 1}).bulge(Shape::sphere(1)), Error);
  EXPECT_THROW((void)Shape::sphere(1).bulge(Shape::torus(1, .2)), Error);
  EXPECT_THROW((void)Shape::sphere(1).scaled(0), Error);
}

} // namespace volcaustic::test
