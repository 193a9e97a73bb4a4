// Rigid bodies against what mechanics says of them, and against bad input.
#include "simulation/euler_angles.h"
#include "simulation/mass.h"
#include "support/solids.h"
#include "volcaustic/error.h"
#include "volcaustic/simulation.h"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace volcaustic::test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
using Frames = std::vector<std::vector<Placement>>;

std::shared_ptr<const Mesh> cuboidMesh(const Vec3d& size, const Vec3d& center = {0, 0, 0}) {
  auto mesh = std::make_shared<Mesh>();
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d p;
    for (int a = 0; a < 3; ++a) p[a] = center[a] + size[a] * ((corner >> a & 1) - .5);
    mesh->positions.push_back(p);
  }
  mesh->triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                     {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

std::shared_ptr<const Mesh> sheet() {
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

RigidBody movingBody(std::shared_ptr<const Mesh> mesh, const Vec3d& at) {
  RigidBody body;
  body.name = "body";
  body.mesh = std::move(mesh);
  body.placement.translate = at;
  return body;
}

RigidBody fixedFloor(double height, double size = 20) {
  RigidBody body = movingBody(sheet(), {0, 0, height});
  body.name = "floor";
  body.placement.scale = {size, size, 1};
  body.fixed = true;
  return body;
}

std::string messageOf(const std::vector<RigidBody>& bodies, ErrorKind kind, const RigidBodyOptions& options = {}) {
  try {
    simulateRigidBodies(bodies, 3, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

TEST(MassProperties, OfACuboidWhereverItIs) {
  const MassProperties mass = massProperties(*cuboidMesh({1, 2, 3}, {100, -50, 7}));
  EXPECT_NEAR(mass.mass, 6, 1e-9);
  EXPECT_NEAR((mass.center - Eigen::Vector3d(100, -50, 7)).norm(), 0, 1e-9);
  EXPECT_NEAR(mass.inertia[0], 6 * (1 + 4) / 12., 1e-8); // about the longest edge, least first
  EXPECT_NEAR(mass.inertia[1], 6 * (1 + 9) / 12., 1e-8);
  EXPECT_NEAR(mass.inertia[2], 6 * (4 + 9) / 12., 1e-8);
  EXPECT_NEAR(mass.axes.determinant(), 1, 1e-12);
}

TEST(EulerAngles, GiveTheRotationBackAndDoNotLeap) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> turn(-720, 720);
  for (int i = 0; i < 200; ++i) {
    const Vec3d degrees{turn(random), turn(random), turn(random)};
    const Eigen::Matrix3d m = rotationMatrix(degrees);
    const Vec3d same = anglesNear(m, degrees), other = anglesNear(m, {0, 0, 0});
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(same[a], degrees[a], 1e-6);
    EXPECT_LT((rotationMatrix(other) - m).norm(), 1e-9);
  }
  for (const double y : {90., -90., 450.}) {
    const Eigen::Matrix3d m = rotationMatrix({20, y, 50});
    EXPECT_LT((rotationMatrix(anglesNear(m, {15, y, 40})) - m).norm(), 1e-6);
  }
}

TEST(RigidBodies, FallAsGalileoSays) {
  RigidBody body = movingBody(cuboidMesh({.2, .3, .4}), {1, 2, 30});
  body.velocity = {1, -2, 3};
  const Frames frames = simulateRigidBodies(std::vector{body}, 25);
  ASSERT_EQ(frames.size(), 25u);
  for (int f = 0; f < 25; ++f) {
    const double t = f / 24.;
    const Vec3d expected{1 + t, 2 - 2 * t, 30 + 3 * t - .5 * 9.81 * t * t};
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(frames[f][0].translate[a], expected[a], 2e-4) << f;
  }
}

TEST(RigidBodies, MoveAlikeWhereverTheirMeshLies) {
  for (const double far : {0., 1e4, 1e6}) {
    RigidBody body = movingBody(cuboidMesh({1, 1, 1}, {far, -far, far}), {0, 0, 0});
    body.velocity = {1, 0, 0};
    const Frames frames = simulateRigidBodies(std::vector{body}, 25, {.gravity = {0, 0, 0}});
    EXPECT_NEAR(frames.back()[0].translate[0], 1, 1e-4) << far;
  }
}

TEST(RigidBodies, WholeTurnsWithinAFrameCount) {
  RigidBody body = movingBody(cuboidMesh({1, 1, 1}), {0, 0, 0});
  body.spin = {0, 0, 7200};
  const Frames frames = simulateRigidBodies(std::vector{body}, 4, {.gravity = {0, 0, 0}});
  for (int f = 0; f < 4; ++f) EXPECT_NEAR(frames[f][0].rotate[2], 300 * f, .5);
}

TEST(RigidBodies, MassesAreScaledWhateverTheOrder) {
  for (const bool floorFirst : {true, false}) {
    RigidBody light = movingBody(cuboidMesh({1e-3, 1e-3, 1e-3}), {0, 0, 1});
    light.density = 1e-4;
    std::vector<RigidBody> bodies{light, fixedFloor(0)};
    if (floorFirst) std::swap(bodies[0], bodies[1]);
    const Frames frames = simulateRigidBodies(bodies, 5);
    EXPECT_NEAR(frames[4][floorFirst ? 1 : 0].translate[2], 1 - .5 * 9.81 / 36, 1e-3) << floorFirst;
  }
}

TEST(RigidBodies, SmallOnesRestBesideLargeOnes) {
  std::vector<RigidBody> bodies{movingBody(cuboidMesh({2, 2, 2}), {5, 0, 1}),
                                movingBody(cuboidMesh({.02, .02, .02}), {0, 0, .01}), fixedFloor(0)};
  const Frames frames = simulateRigidBodies(bodies, 49);
  EXPECT_NEAR(frames.back()[0].translate[2], 1, .02);
  EXPECT_NEAR(frames.back()[1].translate[2], .01, .0005);
}

TEST(RigidBodies, TurnAboutTheirCentreAndKeepScaleAndShear) {
  RigidBody body = movingBody(cuboidMesh({1, 1, 1}, {.5, .5, .5}), {0, 0, 0});
  body.placement.scale = {2, 1, 1};
  body.placement.shear = {.3, 0, 0};
  body.spin = {0, 0, 90};
  const RigidBodyOptions still{.gravity = {0, 0, 0}};
  const Frames frames = simulateRigidBodies(std::vector{body}, 25, still);
  const Placement& last = frames.back()[0];
  EXPECT_EQ(last.scale, body.placement.scale);
  EXPECT_EQ(last.shear, body.placement.shear);
  // The centre (1.3, .5, .5) stays; a quarter of a turn about z brings the corner at the origin to (1.8, -.8, 0).
  EXPECT_NEAR(last.translate[0], 1.8, .02);
  EXPECT_NEAR(last.translate[1], -.8, .02);
  EXPECT_NEAR(last.translate[2], 0, .02);
  const Frames turns = simulateRigidBodies(std::vector{body}, 24 * 9 + 1, still);
  double angle = 0;
  for (const auto& frame : turns) {
    EXPECT_LT(std::abs(frame[0].rotate[2] - angle), 30);
    angle = frame[0].rotate[2];
  }
  EXPECT_NEAR(angle, 810, 25); // two turns and a quarter, not 90
}

TEST(RigidBodies, ABallRollsDownASlopeAtFiveSevenths) {
  constexpr double kSlope = 20, kRadius = .25;
  RigidBody slope = fixedFloor(0, 40);
  slope.placement.rotate = {0, kSlope, 0};
  slope.friction = 1;
  const double sine = std::sin(kSlope * kDegree), cosine = std::cos(kSlope * kDegree);
  RigidBody rolling = movingBody(ball({0, 0, 0}, kRadius, 24), {kRadius * sine, .3, kRadius * cosine});
  rolling.friction = 1;
  rolling.restitution = 0;
  const Frames frames = simulateRigidBodies(std::vector{slope, rolling}, 25);
  const double x = frames.back()[1].translate[0] - rolling.placement.translate[0];
  const double z = frames.back()[1].translate[2] - rolling.placement.translate[2];
  const double way = std::hypot(x, z), expected = .5 * 5 / 7 * 9.81 * sine;
  EXPECT_NEAR(way, expected, .04 * expected);
  EXPECT_NEAR(std::abs(frames.back()[1].rotate[1]), way / kRadius / kDegree, .05 * way / kRadius / kDegree);
}

TEST(RigidBodies, AnElasticHitPassesOnMomentumAndEnergy) {
  RigidBody light = movingBody(ball({0, 0, 0}, .5, 20), {-3, 0, 0}),
            heavy = movingBody(ball({0, 0, 0}, .5, 20), {0, 0, 0});
  light.velocity = {4, 0, 0};
  heavy.density = 3;
  for (RigidBody* body : {&light, &heavy}) {
    body->restitution = 1;
    body->friction = 0;
  }
  const Frames frames = simulateRigidBodies(std::vector{light, heavy}, 40, {.gravity = {0, 0, 0}});
  const auto speed = [&](int body) { return 24 * (frames[39][body].translate[0] - frames[38][body].translate[0]); };
  EXPECT_NEAR(speed(0), -2, .06); // (1 - 3) / (1 + 3) of the speed
  EXPECT_NEAR(speed(1), 2, .06);
  EXPECT_NEAR(speed(0) + 3 * speed(1), 4, .02);
}

TEST(RigidBodies, ComeToRestWithoutSinking) {
  for (const double size : {1e-3, 1., 1e3}) { // of any scale
    RigidBody box = movingBody(cuboidMesh({size, size, size}), {0, 0, 1.5 * size});
    box.placement.rotate = {10, 5, 0};
    box.restitution = .2;
    const RigidBodyOptions options{.gravity = {0, 0, -9.81 * size}};
    const Frames frames = simulateRigidBodies(std::vector{fixedFloor(0, 20 * size), box}, 97, options);
    const Placement &last = frames[96][1], &before = frames[84][1];
    double lowest = 1e30, moved = 0;
    for (const Vec3d& p : transformed(*box.mesh, affine(last)).positions) lowest = std::min(lowest, p[2]);
    for (int a = 0; a < 3; ++a) moved = std::max(moved, std::abs(last.translate[a] - before.translate[a]));
    EXPECT_NEAR(lowest, 0, .01 * size);
    EXPECT_LT(moved, .002 * size);
    EXPECT_EQ(frames[96][0].translate, frames[0][0].translate);
  }
}

TEST(RigidBodies, DoNotPassAThinFloorInAStep) {
  RigidBody bullet = movingBody(ball({0, 0, 0}, .1, 16), {.2, .1, 5.03});
  bullet.velocity = {0, 0, -150};
  const RigidBodyOptions coarse{.steps = 1}; // 6 world lengths a step
  const Frames frames = simulateRigidBodies(std::vector{fixedFloor(0), bullet}, 24, coarse);
  for (const auto& frame : frames) EXPECT_GT(frame[1].translate[2], 0);
}

TEST(RigidBodies, SameBitsForTheSameInput) {
  std::vector<RigidBody> bodies{fixedFloor(0)};
  for (int i = 0; i < 6; ++i) {
    bodies.push_back(
        movingBody(i % 2 ? cuboidMesh({.5, .4, .3}) : ball({0, 0, 0}, .25, 12), {.1 * i, .05 * i, .5 + .6 * i}));
    bodies.back().placement.rotate = {10. * i, 20, 0};
  }
  const Frames a = simulateRigidBodies(bodies, 30), b = simulateRigidBodies(bodies, 30);
  for (std::size_t f = 0; f < a.size(); ++f)
    for (std::size_t i = 0; i < bodies.size(); ++i) EXPECT_EQ(std::memcmp(&a[f][i], &b[f][i], sizeof(Placement)), 0);
  // The pile does not fall through itself or the floor.
  for (std::size_t i = 1; i < bodies.size(); ++i) EXPECT_GT(a.back()[i].translate[2], .1);
}

TEST(RigidBodies, MeshesOfManyPointsAreReduced) {
  auto bumpy = std::make_shared<Mesh>(ellipsoid({0, 0, 0}, {.6, .4, .3}, 60));
  const Frames frames = simulateRigidBodies(std::vector{fixedFloor(0), movingBody(bumpy, {0, 0, .5})}, 49);
  EXPECT_NEAR(frames.back()[1].translate[2], .3, .02); // on its broad side
}

TEST(RigidBodies, SayWhatIsWrong) {
  const RigidBody good = movingBody(cuboidMesh({1, 1, 1}), {0, 0, 0});
  RigidBody open = movingBody(sheet(), {0, 0, 0});
  EXPECT_NE(messageOf({open}, ErrorKind::Input).find("body: has 4 open edges"), std::string::npos);
  RigidBody empty = good;
  empty.mesh = nullptr;
  EXPECT_NE(messageOf({empty}, ErrorKind::Input).find("no triangles"), std::string::npos);
  RigidBody fast = good;
  fast.velocity[1] = std::nan("");
  EXPECT_NE(messageOf({fast}, ErrorKind::Usage).find("velocity"), std::string::npos);
  RigidBody flat = good;
  flat.placement.scale[2] = 0;
  EXPECT_NE(messageOf({flat}, ErrorKind::Usage).find("scale"), std::string::npos);
  RigidBody light = good;
  light.density = 0;
  EXPECT_NE(messageOf({light}, ErrorKind::Usage).find("density"), std::string::npos);
  RigidBody broken = fixedFloor(0);
  auto mesh = std::make_shared<Mesh>(*broken.mesh);
  mesh->triangles[0][1] = 99;
  broken.mesh = mesh;
  EXPECT_NE(messageOf({good, broken}, ErrorKind::Input).find("floor: mesh: triangle 0"), std::string::npos);
  mesh = std::make_shared<Mesh>(*fixedFloor(0).mesh);
  mesh->positions[2][0] = std::nan("");
  broken.mesh = mesh;
  EXPECT_NE(messageOf({good, broken}, ErrorKind::Input).find("not finite"), std::string::npos);
  EXPECT_NE(messageOf({good}, ErrorKind::Usage, {.steps = 0}).find("steps"), std::string::npos);
  EXPECT_THROW(simulateRigidBodies(std::vector{good}, 0), Error);
  std::atomic<bool> stop{true};
  RunContext ctx;
  ctx.cancel = &stop;
  EXPECT_THROW(simulateRigidBodies(std::vector{good}, 10, {}, ctx), Error);
}

} // namespace
} // namespace volcaustic::test
