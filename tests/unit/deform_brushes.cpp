// Brushes: push, pull, inflate, twist, smooth.
#include "unit/deform_support.h"

#include <random>

namespace volcaustic::test {
namespace {

double falloff(double distance, double radius) {
  const double rest = 1 - (distance / radius) * (distance / radius);
  return distance < radius ? rest * rest : 0;
}

/// Deviation of the distances from the origin from their mean.
double roughness(const Mesh& mesh) {
  double sum = 0, squares = 0;
  for (const Vec3d& p : mesh.positions) {
    const double r = distance(p, {0, 0, 0});
    sum += r;
    squares += r * r;
  }
  const double count = static_cast<double>(mesh.positions.size());
  return std::sqrt(squares / count - sum * sum / (count * count));
}

Mesh noisyBall(double noise) {
  Mesh mesh = *ball({0, 0, 0}, 1, 24);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-noise, noise);
  for (Vec3d& p : mesh.positions)
    for (double& x : p) x += uniform(random);
  return mesh;
}

TEST(DeformBrushes, PushAndPullAlongADirectionWithTheirFalloff) {
  const Mesh rest = *ball({0, 0, 0}, 1, 24);
  const Vec3d center{0, 0, 1};
  const Mesh pushed = deformed(rest, std::vector{brush(DeformerType::Push, center, .8, .25, {0, 0, -7})});
  const Mesh back = deformed(pushed, std::vector{brush(DeformerType::Pull, center, 1e6, .25, {0, 0, -1e-9})});
  for (std::size_t v = 0; v < rest.positions.size(); ++v) {
    const Vec3d& p = rest.positions[v];
    const double moved = .25 * falloff(distance(p, center), .8);
    EXPECT_NEAR(pushed.positions[v][2], p[2] - moved, 1e-15);
    EXPECT_EQ(pushed.positions[v][0], p[0]);
    EXPECT_NEAR(back.positions[v][2], p[2] - moved + .25, 1e-10);
  }
}

TEST(DeformBrushes, PushAgainstTheMeanNormalAndPullAlongIt) {
  const Mesh rest = *ball({0, 0, 0}, 1, 24);
  const Mesh pushed = deformed(rest, std::vector{brush(DeformerType::Push, {0, 0, 1}, .5, .2)});
  const Mesh pulled = deformed(rest, std::vector{brush(DeformerType::Pull, {0, 0, 1}, .5, .2)});
  EXPECT_NEAR(pushed.positions[0][2], .8, 1e-12); // the pole
  EXPECT_NEAR(pulled.positions[0][2], 1.2, 1e-12);
  EXPECT_NEAR(pulled.positions[0][0], 0, 1e-12);
}

TEST(DeformBrushes, InflateABallByTheirStrength) {
  const Mesh rest = *ball({0, 0, 0}, 1, 32);
  // Every vertex is as far from the centre: the falloff is that of a third of the radius.
  const double grown = .3 * falloff(1, 3);
  const Mesh mesh = deformed(rest, std::vector{brush(DeformerType::Inflate, {0, 0, 0}, 3, .3)});
  for (const Vec3d& p : mesh.positions) EXPECT_NEAR(distance(p, {0, 0, 0}), 1 + grown, 2e-4);
}

TEST(DeformBrushes, TwistAboutTheirAxis) {
  const Mesh rest = bar(4, 3);
  const Mesh mesh = deformed(rest, std::vector{brush(DeformerType::Twist, {2, 0, 0}, 2, 90, {5, 0, 0})});
  for (std::size_t v = 0; v < rest.positions.size(); ++v) {
    const Vec3d &p = rest.positions[v], &q = mesh.positions[v];
    EXPECT_NEAR(q[0], p[0], 1e-12);
    EXPECT_NEAR(std::hypot(q[1], q[2]), std::hypot(p[1], p[2]), 1e-12);
    if (std::hypot(p[1], p[2]) < .1) continue;
    const double turned = (std::atan2(q[2], q[1]) - std::atan2(p[2], p[1])) * 180 / std::numbers::pi;
    EXPECT_NEAR(std::remainder(turned - 90 * falloff(distance(p, {2, 0, 0}), 2), 360), 0, 1e-9);
  }
}

TEST(DeformBrushes, SmoothNoiseAwayAndKeepTheVolume) {
  const Mesh rough = noisyBall(.01);
  const Mesh mesh = deformed(rough, std::vector{brush(DeformerType::Smooth, {0, 0, 0}, 100, 1)});
  EXPECT_LT(roughness(mesh), roughness(rough) / 2);
  EXPECT_NEAR(checkMesh(mesh).signedVolume, checkMesh(rough).signedVolume, .01 * checkMesh(rough).signedVolume);
  const Mesh half = deformed(rough, std::vector{brush(DeformerType::Smooth, {0, 0, 0}, 1e6, .5)});
  for (std::size_t v = 0; v < rough.positions.size(); ++v) // half of the way that a whole one goes
    EXPECT_NEAR(half.positions[v][0] - rough.positions[v][0], (mesh.positions[v][0] - rough.positions[v][0]) / 2, 1e-5);
}

TEST(DeformBrushes, SmoothFlatSheetsToThemselvesAndHoldTheirBorders) {
  Mesh sheet;
  for (std::uint32_t j = 0; j <= 8; ++j)
    for (std::uint32_t i = 0; i <= 8; ++i) sheet.positions.push_back({i / 8., j / 8., 0});
  for (std::uint32_t j = 0; j < 8; ++j)
    for (std::uint32_t i = 0; i < 8; ++i) {
      const std::uint32_t a = 9 * j + i;
      sheet.triangles.push_back({a, a + 1, a + 10});
      sheet.triangles.push_back({a, a + 10, a + 9});
    }
  const std::vector steps{brush(DeformerType::Smooth, {.5, .5, 0}, 10, 1)};
  const Mesh flat = deformed(sheet, steps);
  for (std::size_t v = 0; v < sheet.positions.size(); ++v)
    EXPECT_LT(distance(flat.positions[v], sheet.positions[v]), 1e-12);
  sheet.positions[4 * 9 + 4][2] = .1; // a spike in the middle
  const Mesh mesh = deformed(sheet, steps);
  EXPECT_LT(std::abs(mesh.positions[4 * 9 + 4][2]), .03);
  for (std::size_t v = 0; v < 9; ++v) EXPECT_EQ(mesh.positions[v], sheet.positions[v]);
}

TEST(DeformBrushes, ActInOrderWithBallsOfTheMeshAtRest) {
  const Mesh rest = *ball({0, 0, 0}, 1, 16);
  const Deformer push = brush(DeformerType::Push, {0, 0, 1}, .5, .7, {0, 0, 1});
  const Deformer back = brush(DeformerType::Pull, {0, 0, 1}, .5, .7, {0, 0, 1});
  const Mesh mesh = deformed(rest, std::vector{push, back}); // the ball still finds what has left it
  for (std::size_t v = 0; v < rest.positions.size(); ++v)
    EXPECT_LT(distance(mesh.positions[v], rest.positions[v]), 1e-15);
  // A handle keeps the shape that the brushes before it made.
  const Deformer lift = handle({0, 0, -1}, .4, {.translate = {0, 0, 2}});
  const Mesh lifted = deformed(rest, std::vector{push, lift}), pushed = deformed(rest, std::vector{push});
  for (std::size_t v = 0; v < rest.positions.size(); ++v)
    EXPECT_NEAR(lifted.positions[v][2], pushed.positions[v][2] + 2, 1e-9);
}

TEST(DeformBrushes, LeaveAloneWhatTheyDoNotReach) {
  const Mesh rest = noisyBall(.01);
  for (const DeformerType type :
       {DeformerType::Push, DeformerType::Pull, DeformerType::Inflate, DeformerType::Twist, DeformerType::Smooth}) {
    EXPECT_EQ(deformed(rest, std::vector{brush(type, {5, 0, 0}, 1, .5, {1, 2, 3})}).positions, rest.positions);
    EXPECT_EQ(deformed(rest, std::vector{brush(type, {1, 0, 0}, 1, 0, {1, 2, 3})}).positions, rest.positions);
    const Mesh mesh = deformed(rest, std::vector{brush(type, {0, 0, 1}, .5, .5, {1, 2, 3})});
    EXPECT_NE(mesh.positions, rest.positions);
    for (std::size_t v = 0; v < rest.positions.size(); ++v)
      if (distance(rest.positions[v], {0, 0, 1}) >= .5) {
        EXPECT_EQ(mesh.positions[v], rest.positions[v]);
      }
  }
}

TEST(DeformBrushes, SayWhatIsWrong) {
  const Mesh mesh = *ball({0, 0, 0}, 1, 8);
  EXPECT_EQ(complaint(mesh, {brush(DeformerType::Twist, {0, 0, 0}, 2, 10)}),
            "deform[0]: the direction has no length; give the axis of the twist, as 0, 0, 1");
  EXPECT_EQ(complaint(mesh, {brush(DeformerType::Smooth, {0, 0, 0}, 2, 1.5)}),
            "deform[0]: the strength is a part of smooth; give 0 to 1");
  EXPECT_EQ(
      complaint(mesh, {brush(DeformerType::Inflate, {0, 0, 5}, 1, .1), brush(DeformerType::Push, {0, 0, 0}, 9, 1)}),
      "deform[1]: the normals in the ball cancel out; give a direction, or a smaller radius");
  EXPECT_TRUE(complaint(mesh, {brush(DeformerType::Inflate, {0, 0, 0}, -1, .1)}).starts_with("deform[0]: the radius"));
  EXPECT_TRUE(complaint(mesh, {brush(DeformerType::Push, {0, 0, 1}, 1, INFINITY, {1, 0, 0})})
                  .starts_with("deform[0]: center, direction and strength"));
}

} // namespace
} // namespace volcaustic::test
