// Bodies as Bullet collides them.
#pragma once

#include "simulation/mass.h"
#include "volcaustic/simulation.h"

#include <btBulletDynamicsCommon.h>
#include <memory>

namespace volcaustic {

/// Where a moving body's own space and Bullet's differ: Bullet turns a body about its centre, along its principal axes.
struct MovingShape {
  std::unique_ptr<btConvexShape> shape; ///< in simulation lengths, about the centre, along the axes
  MassProperties mass;                  ///< of the scaled and sheared mesh, world lengths
  double radius = 0;                    ///< of the ball of its volume, world
};

/// A fixed body's triangles.
struct FixedShape {
  std::unique_ptr<btTriangleMesh> triangles;
  std::unique_ptr<btBvhTriangleMeshShape> shape;
};

/// The mesh with scale and shear, which a Placement applies before it rotates.
Mesh scaledMesh(const RigidBody& body);

/// \throws Error(Input) for a mesh that is not closed or encloses nothing.
MovingShape movingShape(const RigidBody& body);
/// Makes its `shape`: a ball of what is as round as a ball, else the convex hull. `lengths` are simulation lengths per
/// world length.
void makeShape(MovingShape& moving, const Mesh& mesh, double lengths);
FixedShape fixedShape(const RigidBody& body, const Vec3d& origin, double lengths);

} // namespace volcaustic
