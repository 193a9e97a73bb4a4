// Rigid bodies by Bullet (docs/algorithms/simulation.md). Bullet computes in 32-bit floats and its tolerances are
// lengths, so that it gets a world in which bodies are about two units wide and near the origin.
#include "simulation/checked_options.h"
#include "simulation/euler_angles.h"
#include "simulation/rigid_shape.h"

#include <cmath>
#include <memory>

namespace volcaustic {

namespace {

constexpr int kSolverIterations = 50;
constexpr double kDegree = 3.14159265358979323846 / 180;

void requireFinite(const Vec3d& v, const std::string& what) {
  for (const double x : v)
    if (!std::isfinite(x))
      throw Error(ErrorKind::Usage, "rigid bodies: " + what + " is not finite; give three numbers");
}

void checkBody(const RigidBody& body) {
  if (!body.mesh || body.mesh->empty())
    throw Error(ErrorKind::Input, "rigid bodies: " + body.name + ": has no triangles; give it a mesh");
  requireFinite(body.velocity, body.name + ": velocity");
  requireFinite(body.spin, body.name + ": spin");
  const Placement& p = body.placement;
  for (const Vec3d& v : {p.translate, p.rotate, p.scale, p.shear}) requireFinite(v, body.name + ": placement");
  if (p.scale[0] * p.scale[1] * p.scale[2] == 0)
    throw Error(ErrorKind::Usage,
                "rigid bodies: " + body.name + ": scale flattens it; give three numbers other than 0");
  const auto within = [&](const char* name, double value, double least, double most) {
    if (!(value >= least && value <= most))
      throw Error(ErrorKind::Usage, "rigid bodies: " + body.name + ": " + name + " is " + std::to_string(value) +
                                        "; give a number from " + std::to_string(least) + " to " +
                                        std::to_string(most));
  };
  within("density", body.density, 1e-6, 1e9);
  within("friction", body.friction, 0, 1e3);
  within("restitution", body.restitution, 0, 1);
}

btVector3 bullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v[0]), static_cast<btScalar>(v[1]), static_cast<btScalar>(v[2])};
}
btMatrix3x3 bullet(const Eigen::Matrix3d& m) {
  btMatrix3x3 result;
  for (int r = 0; r < 3; ++r) result[r] = bullet(Eigen::Vector3d(m.row(r).transpose()));
  return result;
}
Eigen::Vector3d eigen(const Vec3d& v) { return {v[0], v[1], v[2]}; }

/// Length and origin of Bullet's world in ours.
struct Scale {
  double lengths; ///< simulation lengths per world length
  Vec3d origin;
};

/// A world of bodies; result placements are what Bullet says of them.
class RigidWorld {
public:
  RigidWorld(std::span<const RigidBody> bodies, const RigidBodyOptions& options);
  ~RigidWorld() {
    for (auto& body : mBodies) mWorld.removeRigidBody(body.get());
  }
  RigidWorld(const RigidWorld&) = delete;
  RigidWorld& operator=(const RigidWorld&) = delete;

  void step(double time) { mWorld.stepSimulation(static_cast<btScalar>(time), 0); }
  /// `before`: of the same body a frame earlier.
  [[nodiscard]] Placement placement(std::size_t body, const Placement& before) const;

private:
  void addMoving(const RigidBody& body, std::size_t i, double time, const Vec3d& gravity);
  void addFixed(const RigidBody& body, std::size_t i);
  void add(const RigidBody& body, const btRigidBody::btRigidBodyConstructionInfo& info);

  btDefaultCollisionConfiguration mConfiguration;
  btCollisionDispatcher mDispatcher{&mConfiguration};
  btDbvtBroadphase mPairs;
  btSequentialImpulseConstraintSolver mSolver;
  btDiscreteDynamicsWorld mWorld{&mDispatcher, &mPairs, &mSolver, &mConfiguration};
  Scale mScale{};
  double mMasses = 1; ///< world mass per simulation mass
  std::vector<MovingShape> mMoving;
  std::vector<FixedShape> mFixed;
  std::vector<std::unique_ptr<btRigidBody>> mBodies;
};

/// The mean radius of what moves becomes 1, and the middle of what moves the origin.
Scale scaleOf(std::span<const RigidBody> bodies, std::span<const MovingShape> moving) {
  double radius = 0, count = 0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].fixed) continue;
    radius += moving[i].radius;
    middle += eigen(bodies[i].placement.translate);
    ++count;
  }
  if (count == 0) return {1, {0, 0, 0}};
  middle /= count;
  return {count / radius, {middle[0], middle[1], middle[2]}};
}

RigidWorld::RigidWorld(std::span<const RigidBody> bodies, const RigidBodyOptions& options)
    : mMoving(bodies.size()), mFixed(bodies.size()) {
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (!bodies[i].fixed) mMoving[i] = movingShape(bodies[i]);
  mScale = scaleOf(bodies, mMoving);
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (!bodies[i].fixed) mMasses = std::max(i == 0 ? 0 : mMasses, bodies[i].density * mMoving[i].mass.mass);
  mWorld.setGravity(bullet(Eigen::Vector3d(mScale.lengths * eigen(options.gravity))));
  mWorld.getSolverInfo().m_numIterations = kSolverIterations;
  // Bodies that overlap are pushed apart without speed, however little they do: else every bounce would gain energy.
  mWorld.getSolverInfo().m_splitImpulsePenetrationThreshold = 0;
  const double time = 1 / (options.framesPerSecond * options.steps);
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i].fixed)
      addFixed(bodies[i], i);
    else
      addMoving(bodies[i], i, time, options.gravity);
}

void RigidWorld::addMoving(const RigidBody& body, std::size_t i, double time, const Vec3d& gravity) {
  MovingShape& moving = mMoving[i];
  makeShape(moving, scaledMesh(body), mScale.lengths);
  const Eigen::Matrix3d rotation = rotationMatrix(body.placement.rotate);
  const Eigen::Vector3d center = eigen(body.placement.translate) + rotation * moving.mass.center;
  btDefaultMotionState* const noState = nullptr;
  const double mass = body.density * moving.mass.mass / mMasses;
  const Eigen::Vector3d inertia = moving.mass.inertia * (body.density / mMasses * mScale.lengths * mScale.lengths);
  btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), noState, moving.shape.get(),
                                                bullet(inertia));
  info.m_startWorldTransform = btTransform(bullet(Eigen::Matrix3d(rotation * moving.mass.axes)),
                                           bullet(Eigen::Vector3d(mScale.lengths * (center - eigen(mScale.origin)))));
  add(body, info);
  btRigidBody& added = *mBodies.back();
  // Bullet moves a body with the speed at the end of a step. Half a step of gravity less at the start makes positions
  // in free fall exact at the end of each.
  added.setLinearVelocity(
      bullet(Eigen::Vector3d(mScale.lengths * (eigen(body.velocity) - .5 * time * eigen(gravity)))));
  added.setAngularVelocity(bullet(Eigen::Vector3d(kDegree * eigen(body.spin))));
  added.setActivationState(DISABLE_DEACTIVATION);
  // Faster than half its width a step: swept, so that it does not pass what is thin.
  const double inner = mScale.lengths * moving.radius * .4;
  added.setCcdMotionThreshold(static_cast<btScalar>(inner));
  added.setCcdSweptSphereRadius(static_cast<btScalar>(.5 * inner));
}

void RigidWorld::addFixed(const RigidBody& body, std::size_t i) {
  mFixed[i] = fixedShape(body, mScale.origin, mScale.lengths);
  add(body, btRigidBody::btRigidBodyConstructionInfo(0, nullptr, mFixed[i].shape.get()));
}

void RigidWorld::add(const RigidBody& body, const btRigidBody::btRigidBodyConstructionInfo& info) {
  auto made = std::make_unique<btRigidBody>(info);
  made->setFriction(static_cast<btScalar>(body.friction));
  made->setRestitution(static_cast<btScalar>(body.restitution));
  mWorld.addRigidBody(made.get());
  mBodies.push_back(std::move(made));
}

Placement RigidWorld::placement(std::size_t body, const Placement& before) const {
  if (mBodies[body]->isStaticObject()) return before;
  const btTransform& at = mBodies[body]->getWorldTransform();
  const btMatrix3x3 turned(at.getRotation().normalized());
  Eigen::Matrix3d turn;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) turn(r, c) = turned[r][c];
  const MassProperties& mass = mMoving[body].mass;
  const Eigen::Matrix3d rotation = turn * mass.axes.transpose();
  const btVector3& c = at.getOrigin();
  const Eigen::Vector3d center = Eigen::Vector3d(c.x(), c.y(), c.z()) / mScale.lengths + eigen(mScale.origin);
  const Eigen::Vector3d origin = center - rotation * mass.center;
  Placement now = before;
  now.translate = {origin[0], origin[1], origin[2]};
  now.rotate = anglesNear(rotation, before.rotate);
  return now;
}

} // namespace

std::vector<std::vector<Placement>> simulateRigidBodies(std::span<const RigidBody> bodies, int frames,
                                                        const RigidBodyOptions& options, const RunContext& ctx) {
  checkRanges("rigid bodies", options);
  if (frames < 1 || frames > 1'000'000)
    throw Error(ErrorKind::Usage, "rigid bodies: " + std::to_string(frames) + " frames; give 1 to 1000000");
  for (const RigidBody& body : bodies) checkBody(body);
  ctx.requireMemory(static_cast<std::uint64_t>(frames) * bodies.size() * sizeof(Placement), "placements of all frames");
  RigidWorld world(bodies, options);
  std::vector<std::vector<Placement>> result(1);
  for (const RigidBody& body : bodies) result[0].push_back(body.placement);
  for (int frame = 1; frame < frames; ++frame) {
    for (int step = 0; step < options.steps; ++step) world.step(1 / (options.framesPerSecond * options.steps));
    std::vector<Placement> now;
    for (std::size_t i = 0; i < bodies.size(); ++i) now.push_back(world.placement(i, result.back()[i]));
    result.push_back(std::move(now));
    ctx.progress("rigid bodies", static_cast<double>(frame) / frames);
  }
  return result;
}

} // namespace volcaustic
