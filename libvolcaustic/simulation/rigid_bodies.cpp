// Rigid bodies by Bullet (docs/algorithms/simulation.md). Bullet computes in 32-bit floats and its tolerances are
// lengths, so that it gets a world in which bodies are about two units wide and near the origin.
#include "core/range_check.h"
#include "mesh/validate.h"
#include "simulation/euler_angles.h"
#include "simulation/rigid_shape.h"

#include <cmath>
#include <limits>
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
    requireWithin(ErrorKind::Usage, "rigid bodies: " + body.name, name, value, least, most);
  };
  within("density", body.density, 1e-6, 1e9);
  within("friction", body.friction, 0, 1e3);
  within("restitution", body.restitution, 0, 1);
  try {
    requireValid(*body.mesh);
  } catch (const Error& error) { // which knows no body
    throw Error(error.kind(), "rigid bodies: " + body.name + ": " + error.what());
  }
}

/// What Bullet leaves out without a word: steps below its least, and turns of more than an eighth a step.
void checkSteps(std::span<const RigidBody> bodies, const RigidBodyOptions& options) {
  const double perSecond = options.framesPerSecond * options.steps;
  if (perSecond > 8e6)
    throw Error(ErrorKind::Usage, "rigid bodies: rate times steps is above 8000000 a second; lower one of them");
  for (const RigidBody& body : bodies) {
    const double spin = std::hypot(body.spin[0], body.spin[1], body.spin[2]);
    if (!body.fixed && spin > 45 * perSecond)
      throw Error(ErrorKind::Usage, "rigid bodies: " + body.name +
                                        ": turns by more than 45 degrees a step; raise steps, or lower its spin");
  }
}

void checkPlacement(const RigidBody& body, const Placement& now) {
  for (int a = 0; a < 3; ++a)
    if (!std::isfinite(now.translate[a]) || !std::isfinite(now.rotate[a]))
      throw Error(ErrorKind::Input,
                  "rigid bodies: " + body.name +
                      ": left the numbers that can be computed with; lower velocity, spin or gravity");
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
  /// `before`: of the same body a step earlier.
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
  double mMasses = 0; ///< world mass per simulation mass
  std::vector<MovingShape> mMoving;
  std::vector<FixedShape> mFixed;
  std::vector<std::unique_ptr<btRigidBody>> mBodies;
};

/// The least radius of what moves becomes 1, and the middle of what moves the origin.
Scale scaleOf(std::span<const RigidBody> bodies, std::span<const MovingShape> moving) {
  double radius = std::numeric_limits<double>::infinity(), count = 0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].fixed) continue;
    radius = std::min(radius, moving[i].radius);
    middle += eigen(bodies[i].placement.translate) + rotationMatrix(bodies[i].placement.rotate) * moving[i].mass.center;
    ++count;
  }
  if (count == 0) return {1, {0, 0, 0}};
  middle /= count;
  return {1 / radius, {middle[0], middle[1], middle[2]}};
}

RigidWorld::RigidWorld(std::span<const RigidBody> bodies, const RigidBodyOptions& options)
    : mMoving(bodies.size()), mFixed(bodies.size()) {
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (!bodies[i].fixed) mMoving[i] = movingShape(bodies[i]);
  mScale = scaleOf(bodies, mMoving);
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (!bodies[i].fixed) mMasses = std::max(mMasses, bodies[i].density * mMoving[i].mass.mass);
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
  // Faster than a fifth of its width a step: swept, so that it does not pass what is thin.
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
  RigidBodyOptions checked = options;
  describe(RangeCheck(ErrorKind::Usage, "rigid bodies"), checked);
  if (frames < 1 || frames > 1'000'000)
    throw Error(ErrorKind::Usage, "rigid bodies: " + std::to_string(frames) + " frames; give 1 to 1000000");
  for (const RigidBody& body : bodies) checkBody(body);
  checkSteps(bodies, options);
  ctx.requireMemory(static_cast<std::uint64_t>(frames) * bodies.size() * sizeof(Placement), "placements of all frames");
  RigidWorld world(bodies, options);
  std::vector<std::vector<Placement>> result(1);
  for (const RigidBody& body : bodies) result[0].push_back(body.placement);
  for (int frame = 1; frame < frames; ++frame) {
    std::vector<Placement> now = result.back();
    for (int step = 0; step < options.steps; ++step) {
      ctx.throwIfCancelled();
      world.step(1 / (options.framesPerSecond * options.steps));
      // Step by step, so that whole turns within a frame count.
      for (std::size_t i = 0; i < bodies.size(); ++i) now[i] = world.placement(i, now[i]);
    }
    for (std::size_t i = 0; i < bodies.size(); ++i) checkPlacement(bodies[i], now[i]);
    result.push_back(std::move(now));
    ctx.progress("rigid bodies", static_cast<double>(frame) / frames);
  }
  return result;
}

} // namespace volcaustic
