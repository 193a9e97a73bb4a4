// Profiles: distances from closed curves of lines and arcs, and the solids made of them.

#include "shape_support.h"
#include "shapes/profile.h"
#include "shapes/revolution.h"
#include "shapes/solids.h"

#include <gtest/gtest.h>
#include <numbers>

namespace volcaustic::test {
namespace {

using shapes::Profile;
constexpr double kPi = std::numbers::pi;

double valueAt(const ProfileCurve& curve, const Vec2d& p) {
  double value;
  curve.evaluate(&p[0], &p[1], 1, {&value, {nullptr, nullptr}});
  return value;
}
Vec2d gradientAt(const ProfileCurve& curve, const Vec2d& p) {
  double value;
  Vec2d g;
  curve.evaluate(&p[0], &p[1], 1, {&value, {&g[0], &g[1]}});
  return g;
}

Profile circle(const Vec2d& centre, double radius) {
  return {{{centre[0], centre[1] - radius}, {centre[0], centre[1] + radius}}, {1, 1}, false};
}
Profile rectangle(double width, double height) {
  return {{{0, -.5 * height}, {width, -.5 * height}, {width, .5 * height}, {0, .5 * height}}, {}, false};
}

/// A star of lines and arcs that do not cross as long as arcs are flat.
Profile star(Random& random, int points, double mostBulge) {
  Profile p;
  for (int i = 0; i < points; ++i) {
    const double angle = 2 * kPi * (i + random.between(-.3, .3)) / points, radius = random.between(.5, 1.5);
    p.points.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    p.bulges.push_back(random.chance(.4) ? 0 : random.between(-mostBulge, mostBulge));
  }
  return p;
}

/// Points along the curve that a profile stands for, by the meaning of a bulge alone.
std::vector<Vec2d> traced(const Profile& p, int steps) {
  std::vector<Vec2d> curve;
  for (std::size_t i = 0; i < p.points.size(); ++i) {
    const Vec2d &a = p.points[i], &b = p.points[(i + 1) % p.points.size()];
    const double angle = 4 * std::atan(p.bulges.empty() ? 0 : p.bulges[i]), dx = b[0] - a[0], dy = b[1] - a[1];
    for (int k = 0; k < steps; ++k) {
      const double t = double(k) / steps;
      if (angle == 0) {
        curve.push_back({a[0] + t * dx, a[1] + t * dy});
        continue;
      }
      // The centre is left of the way, half the chord by the cotangent of half the angle from its middle.
      const double h = .5 / std::tan(.5 * angle);
      const Vec2d c{.5 * (a[0] + b[0]) - h * dy, .5 * (a[1] + b[1]) + h * dx};
      const double x = a[0] - c[0], y = a[1] - c[1], cosine = std::cos(t * angle), sine = std::sin(t * angle);
      curve.push_back({c[0] + cosine * x - sine * y, c[1] + sine * x + cosine * y});
    }
  }
  return curve;
}

struct Nearest {
  double distance;
  bool inside;
};
Nearest byBrute(const std::vector<Vec2d>& curve, const Vec2d& p) {
  Nearest n{1e9, false};
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Vec2d &a = curve[i], &b = curve[(i + 1) % curve.size()];
    n.distance = std::min(n.distance, std::hypot(p[0] - a[0], p[1] - a[1]));
    if ((a[1] <= p[1]) != (b[1] <= p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
      n.inside = !n.inside;
  }
  return n;
}

} // namespace

TEST(ShapeProfile, ACircleOfArcsHasTheDistancesOfACircle) {
  Random random(1);
  const Vec2d centre{.3, -.2};
  // As two half circles either way round, and as one arc of nearly a whole circle and the rest of it.
  Profile backwards = circle(centre, .7), uneven = backwards;
  backwards.bulges = {-1, -1};
  const double small = .02, angle = 4 * std::atan(small);
  uneven.points[1] = {centre[0] + .7 * std::sin(angle), centre[1] - .7 * std::cos(angle)};
  uneven.bulges = {small, 1 / small};
  for (const Profile& p : {circle(centre, .7), backwards, uneven}) {
    const ProfileCurve curve(p, ProfileUse::Extruded);
    for (int i = 0; i < 500; ++i) {
      const Vec2d at{random.between(-2, 2), random.between(-2, 2)};
      const double dx = at[0] - centre[0], dy = at[1] - centre[1], r = std::hypot(dx, dy);
      EXPECT_NEAR(valueAt(curve, at), .7 - r, 1e-13);
      const Vec2d g = gradientAt(curve, at);
      EXPECT_NEAR(g[0], -dx / r, 1e-11);
      EXPECT_NEAR(g[1], -dy / r, 1e-11);
    }
  }
}

TEST(ShapeProfile, AgreesWithPointsAlongTheCurve) {
  Random random(2);
  for (int round = 0; round < 30; ++round) {
    const Profile p = star(random, 3 + random.below(9), round < 15 ? .3 : 2.5); // the latter cross themselves
    const ProfileCurve curve(p, ProfileUse::Extruded);
    const std::vector<Vec2d> points = traced(p, 400);
    for (int i = 0; i < 60; ++i) {
      const Vec2d at{random.between(-2.5, 2.5), random.between(-2.5, 2.5)};
      const Nearest expected = byBrute(points, at);
      const double value = valueAt(curve, at);
      EXPECT_LE(std::abs(value), expected.distance + 1e-12);
      EXPECT_GE(std::abs(value), expected.distance - .02);
      EXPECT_TRUE(expected.distance < .02 || (value > 0) == expected.inside) << round << ' ' << at[0] << ' ' << at[1];
    }
  }
}

TEST(ShapeProfile, AValueDoesNotDependOnItsBatch) {
  Random random(3);
  for (int round = 0; round < 20; ++round) {
    const Profile p = star(random, 40, round % 2 ? .4 : 0);
    const ProfileCurve curve(p, ProfileUse::Extruded);
    // Also corners of the curve, and what is level with them.
    std::vector<double> x, y;
    for (int i = 0; i < kShapeBatch; ++i) {
      const Vec2d& corner = p.points[i % p.points.size()];
      x.push_back(i % 3 == 0 ? corner[0] : random.between(-2, 2));
      y.push_back(i % 3 < 2 ? corner[1] : random.between(-2, 2));
    }
    BatchNumbers together, gx, gy;
    curve.evaluate(x.data(), y.data(), kShapeBatch, {together.data(), {gx.data(), gy.data()}});
    for (int i = 0; i < kShapeBatch; ++i) {
      EXPECT_EQ(together[i], valueAt(curve, {x[i], y[i]}));
      const Vec2d g = gradientAt(curve, {x[i], y[i]});
      EXPECT_EQ(gx[i], g[0]);
      EXPECT_EQ(gy[i], g[1]);
    }
  }
}

TEST(ShapeProfile, LevelWithItsCornersInsideIsInside) {
  // A square on its corner: rays through corners pass one, two or none.
  const ProfileCurve diamond({{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}, {}, false}, ProfileUse::Extruded);
  EXPECT_NEAR(valueAt(diamond, {0, 0}), std::sqrt(.5), 1e-15);
  EXPECT_NEAR(valueAt(diamond, {-2, 0}), -1, 1e-15);
  EXPECT_NEAR(valueAt(diamond, {-3, 1}), -std::sqrt(5), 1e-15);
  EXPECT_NEAR(valueAt(diamond, {-3, -1}), -std::sqrt(5), 1e-15);
  // Half a disc upon a level chord, drawn either way: on the chord's line, left of it, on it and right of it.
  for (const double bulge : {1., -1.}) {
    const double way = bulge > 0 ? 1 : -1;
    const ProfileCurve half({{{way, 0}, {-way, 0}}, {bulge, 0}, false}, ProfileUse::Extruded);
    EXPECT_NEAR(valueAt(half, {-3, 0}), -2, 1e-15);
    EXPECT_NEAR(valueAt(half, {3, 0}), -2, 1e-15);
    EXPECT_NEAR(valueAt(half, {0, .25}), .25, 1e-15);
    EXPECT_NEAR(valueAt(half, {0, -.25}), -.25, 1e-15);
    EXPECT_NEAR(gradientAt(half, {.5, .0})[1], 1, 1e-15);
  }
}

TEST(ShapeProfile, FlatArcsGoOverIntoLines) {
  Random random(4);
  const Profile p = star(random, 7, 0);
  const ProfileCurve straight(p, ProfileUse::Extruded);
  for (const double bulge : {1e-6, 1e-9, 1e-12, 1e-16, 1e-200}) {
    Profile bent = p;
    bent.bulges.assign(p.points.size(), bulge);
    const ProfileCurve curve(bent, ProfileUse::Extruded);
    for (int i = 0; i < 200; ++i) {
      const Vec2d at{random.between(-2, 2), random.between(-2, 2)};
      EXPECT_NEAR(valueAt(curve, at), valueAt(straight, at), 2 * bulge + 1e-14);
    }
  }
}

TEST(ShapeProfile, SmoothCurvesThroughPointsOfACircleAreThatCircle) {
  Random random(5);
  Profile p{{}, {}, true};
  for (double angle = 0; angle < 6; angle += random.between(.1, 1.2))
    p.points.push_back({2 + std::cos(angle), std::sin(angle)});
  const ProfileCurve curve(p, ProfileUse::Extruded);
  const ProfileCurve two({{{1, 0}, {3, 0}}, {}, true}, ProfileUse::Extruded);
  for (int i = 0; i < 500; ++i) {
    const Vec2d at{random.between(0, 4), random.between(-2, 2)};
    EXPECT_NEAR(valueAt(curve, at), 1 - std::hypot(at[0] - 2, at[1]), 1e-13);
    EXPECT_NEAR(valueAt(two, at), 1 - std::hypot(at[0] - 2, at[1]), 1e-13);
  }
}

TEST(ShapeProfile, SmoothCurvesHaveOneTangentWhereTheirArcsMeet) {
  Random random(6);
  for (int round = 0; round < 20; ++round) {
    Profile p = star(random, 3 + random.below(8), 0);
    p.smooth = true;
    const std::vector<ChainLink> chain = chainOf(p, ProfileUse::Extruded);
    for (const Vec2d& point : p.points)
      EXPECT_TRUE(std::any_of(chain.begin(), chain.end(), [&](const ChainLink& l) { return l.from == point; }));
    const auto headings = [&](std::size_t i) { // at the beginning of a link and at its end
      const Vec2d &a = chain[i].from, &b = chain[(i + 1) % chain.size()].from;
      const double way = std::atan2(b[1] - a[1], b[0] - a[0]), half = 2 * std::atan(chain[i].bulge);
      return std::array{way - half, way + half};
    };
    for (std::size_t i = 0; i < chain.size(); ++i)
      EXPECT_NEAR(std::remainder(headings((i + 1) % chain.size())[0] - headings(i)[1], 2 * kPi), 0, 1e-9) << round;
  }
}

TEST(ShapeProfile, GradientsAreDifferencesOfLengthOne) {
  Random random(7);
  const ProfileCurve curve(star(random, 9, .5), ProfileUse::Extruded);
  int smooth = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec2d at{random.between(-2, 2), random.between(-2, 2)}, g = gradientAt(curve, at);
    EXPECT_NEAR(std::hypot(g[0], g[1]), 1, 1e-12);
    const double h = 1e-6, x = (valueAt(curve, {at[0] + h, at[1]}) - valueAt(curve, {at[0] - h, at[1]})) / (2 * h),
                 y = (valueAt(curve, {at[0], at[1] + h}) - valueAt(curve, {at[0], at[1] - h})) / (2 * h);
    smooth += std::hypot(g[0] - x, g[1] - y) < 1e-4;
  }
  EXPECT_GE(smooth, 1990); // but where two pieces are as near as each other
}

TEST(ShapeProfile, BoundsHoldAllValuesAndShrink) {
  Random random(8);
  for (int round = 0; round < 300; ++round) {
    const ProfileCurve curve(star(random, 3 + random.below(20), round % 3 ? .8 : 2.5), ProfileUse::Extruded);
    const Box box = random.box(cube(2));
    const Rectangle r{{box.min[0], box.min[1]}, {box.max[0], box.max[1]}};
    const Interval bound = curve.bound(r);
    Interval seen{1e9, -1e9};
    for (const Vec3d& p : random.points(box, 200)) {
      const double value = valueAt(curve, {p[0], p[1]});
      ASSERT_LE(bound.low, value);
      ASSERT_GE(bound.high, value);
      seen = united(seen, {value, value});
    }
    const double diagonal = std::hypot(r.max[0] - r.min[0], r.max[1] - r.min[1]);
    EXPECT_LE(bound.high - bound.low, diagonal + 1e-12);
    // Away from the curve hardly more than what is there; samples miss little of it.
    const double spare = .35 * diagonal + 1e-12;
    EXPECT_TRUE(bound.low <= 0 || bound.low >= seen.low - spare);
    EXPECT_TRUE(bound.high >= 0 || bound.high <= seen.high + spare);
  }
}

TEST(ShapeProfile, AnythingThatIsACurveCanBeEvaluated) {
  const std::vector<Profile> odd{
      {{{0, 0}, {1, 0}, {0, 0}, {1, 0}}, {}, false}, // there and back
      {{{0, 0}, {1, 0}, {0, 0}, {1, 0}}, {}, true},
      {{{-1, -1}, {1, 1}, {1, -1}, {-1, 1}}, {}, false}, // crosses itself
      {{{0, 0}, {1e-300, 0}, {0, 1e-310}}, {.5, 1, -1}, true},
      {{{0, 0}, {1e-300, 0}, {0, 1e-310}}, {.5, 100, -1}, false},
      {{{1e9, 1e9}, {-1e9, 1e9}, {std::nextafter(-1e9, 0), 1e9}}, {100, -100, 1}, false},
      {{{0, 0}, {1, 0}}, {}, true},
  };
  for (const Profile& p : odd)
    for (const ProfileUse use : {ProfileUse::Extruded, ProfileUse::Revolved}) {
      const ProfileCurve curve(p, use);
      for (const Vec2d& at : {Vec2d{0, 0}, {.5, 0}, {.5, .5}, {3, -1e8}, {1e12, 1e12}}) {
        EXPECT_FALSE(std::isnan(valueAt(curve, at)));
        EXPECT_TRUE(std::isfinite(gradientAt(curve, at)[0]));
      }
      const double huge = 1e300;
      for (const Rectangle& r : {Rectangle{{0, 0}, {1, 1}}, {{-huge, -huge}, {huge, huge}}}) {
        const Interval bound = curve.bound(r);
        EXPECT_LE(bound.low, valueAt(curve, {.5, .5}));
        EXPECT_GE(bound.high, valueAt(curve, {.5, .5}));
      }
    }
}

TEST(ShapeRevolution, OfACircleIsATorus) {
  Random random(9);
  const auto ring = makeRevolution({circle({1, 0}, .25)});
  const auto torus = makeTorus({1, .25});
  const std::vector<Vec3d> points = random.points(cube(1.5), 2000);
  const std::vector<double> expected = valuesOf(*torus, points), values = valuesOf(*ring, points);
  const std::vector<Vec3d> gradients = gradientsOf(*ring, points), slopes = gradientsOf(*torus, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(values[i], expected[i], 1e-14);
    EXPECT_NEAR(apart(gradients[i], slopes[i]), 0, 1e-10);
  }
}

TEST(ShapeRevolution, TheAxisIsNoSurface) {
  const auto cylinder = makeRevolution({rectangle(1, 3)});
  EXPECT_NEAR(valueOf(*cylinder, {0, 0, 0}), 1, 1e-15);
  EXPECT_NEAR(valueOf(*cylinder, {.25, 0, .1}), .75, 1e-15);
  EXPECT_NEAR(valueOf(*cylinder, {0, 0, 1.25}), .25, 1e-15);
  EXPECT_NEAR(valueOf(*cylinder, {0, 0, 2}), -.5, 1e-15);
  EXPECT_NEAR(valueOf(*cylinder, {0, 1 + 3, 1.5 + 4}), -5, 1e-14);
  const Interval bound = cylinder->bound({{-.1, -.1, -.1}, {.1, .1, .1}});
  EXPECT_GT(bound.low, .85);
}

TEST(ShapeRevolution, SmoothProfilesStandUprightOnTheAxis) {
  Random random(10);
  // A ball of points of half a circle, both ends of which are on the axis.
  Profile p{{}, {}, true};
  for (const double t : {0., .1, .25, .4, .7, .85, 1.})
    p.points.push_back({t == 0 || t == 1 ? 0 : std::sin(kPi * t), -std::cos(kPi * t)});
  const auto ball = makeRevolution({p});
  for (const Vec3d& at : random.points(cube(1.5), 1000)) EXPECT_NEAR(valueOf(*ball, at), 1 - length(at), 1e-13);
  // A drop: its normal at both ends is the axis.
  const auto drop = makeRevolution({{{{0, -1}, {.8, -.3}, {.1, 1}, {0, 1.5}}, {}, true}});
  const std::vector<Vec3d> ends = gradientsOf(*drop, {{1e-7, 0, -1}, {0, 1e-7, 1.5}});
  EXPECT_NEAR(ends[0][2], 1, 1e-5);
  EXPECT_NEAR(ends[1][2], -1, 1e-5);
}

TEST(ShapeRevolution, GradientsAreDifferencesAndBoundsHold) {
  Random random(11);
  Profile goblet{{{0, 0}, {.5, .05}, {.1, .2}, {.1, .8}, {.6, 1.4}, {.5, 2}, {.45, 2}, {.5, 1.4}, {0, .9}}, {}, true};
  for (const auto& f : {makeRevolution({goblet}), makeExtrusion({star(random, 6, .5), 1})}) {
    int smooth = 0;
    for (const Vec3d& p : random.points(cube(2), 1000)) {
      const Vec3d g = gradientsOf(*f, {p})[0];
      EXPECT_NEAR(length(g), 1, 1e-11);
      smooth += apart(g, differences([&](const Vec3d& q) { return valueOf(*f, q); }, p, 1e-6)) < 1e-4;
    }
    EXPECT_GE(smooth, 985);
    for (int i = 0; i < 200; ++i) {
      const Box box = random.box(cube(2));
      const Interval bound = f->bound(box);
      EXPECT_LE(bound.high - bound.low, apart(box.min, box.max) + 1e-12);
      for (const double value : valuesOf(*f, random.points(box, 200))) {
        ASSERT_LE(bound.low, value);
        ASSERT_GE(bound.high, value);
      }
    }
  }
}

TEST(ShapeExtrusion, OfARectangleIsACuboid) {
  Random random(12);
  const Profile p{{{-1, -.5}, {-1, .5}, {1, .5}, {1, -.5}}, {}, false};
  const auto prism = makeExtrusion({p, 1.5});
  const auto cuboid = makeCuboid({{2, 1, 1.5}, 0});
  const std::vector<Vec3d> points = random.points(cube(2), 2000);
  const std::vector<double> expected = valuesOf(*cuboid, points), values = valuesOf(*prism, points);
  const std::vector<Vec3d> gradients = gradientsOf(*prism, points), slopes = gradientsOf(*cuboid, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(values[i], expected[i], 1e-15);
    EXPECT_NEAR(apart(gradients[i], slopes[i]), 0, 1e-13);
  }
}

} // namespace volcaustic::test
