#include "simulation/rigid_shape.h"

#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>
#include <LinearMath/btConvexHullComputer.h>
#include <numbers>
#include <vector>

namespace volcaustic {

namespace {

constexpr int kHullPoints = 256;
/// Bullet keeps bodies this far apart, in simulation lengths; hulls shrink by as much, so that surfaces touch.
constexpr btScalar kMargin = .01f;

/// Points in all directions, evenly: the spiral of golden angles.
Eigen::Vector3d direction(int i, int count) {
  const double z = 1 - (2 * i + 1.) / count, angle = i * std::numbers::pi * (3 - std::sqrt(5.));
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// All of them, or those that are farthest in one of kHullPoints directions.
std::vector<btVector3> outermost(const std::vector<btVector3>& points) {
  if (points.size() <= kHullPoints) return points;
  std::vector<std::size_t> chosen;
  for (int i = 0; i < kHullPoints; ++i) {
    const Eigen::Vector3d d = direction(i, kHullPoints);
    const btVector3 towards(static_cast<btScalar>(d[0]), static_cast<btScalar>(d[1]), static_cast<btScalar>(d[2]));
    const auto farthest = std::max_element(
        points.begin(), points.end(), [&](const auto& a, const auto& b) { return a.dot(towards) < b.dot(towards); });
    chosen.push_back(farthest - points.begin());
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  std::vector<btVector3> result;
  for (const std::size_t i : chosen) result.push_back(points[i]);
  return result;
}

/// About the centre, along the principal axes.
std::vector<btVector3> ownPoints(const MassProperties& mass, const Mesh& mesh, double lengths) {
  std::vector<btVector3> points;
  points.reserve(mesh.positions.size());
  for (const Vec3d& p : mesh.positions) {
    const Eigen::Vector3d own = lengths * (mass.axes.transpose() * (Eigen::Vector3d(p[0], p[1], p[2]) - mass.center));
    points.emplace_back(static_cast<btScalar>(own[0]), static_cast<btScalar>(own[1]), static_cast<btScalar>(own[2]));
  }
  return points;
}

/// The radius of points that are all as far from the centre and enclose a ball's volume; 0 for others.
btScalar roundRadius(const std::vector<btVector3>& points, double volume) {
  btScalar least = SIMD_INFINITY, most = 0;
  for (const btVector3& p : points) {
    least = std::min(least, p.length());
    most = std::max(most, p.length());
  }
  const double ball = 4. / 3 * std::numbers::pi * std::pow(static_cast<double>(most), 3);
  return least > .995f * most && volume > .95 * ball ? most : 0;
}

Mesh withoutStrayVertices(const Mesh& mesh) {
  Mesh used;
  std::vector<std::uint32_t> number(mesh.positions.size(), ~std::uint32_t{0});
  used.triangles = mesh.triangles;
  for (auto& triangle : used.triangles)
    for (std::uint32_t& corner : triangle) {
      if (number[corner] == ~std::uint32_t{0}) {
        number[corner] = static_cast<std::uint32_t>(used.positions.size());
        used.positions.push_back(mesh.positions[corner]);
      }
      corner = number[corner];
    }
  return used;
}

} // namespace

Mesh scaledMesh(const RigidBody& body) {
  return withoutStrayVertices(
      transformed(*body.mesh, affine({.scale = body.placement.scale, .shear = body.placement.shear})));
}

MovingShape movingShape(const RigidBody& body) {
  const MeshReport report = checkMesh(*body.mesh);
  if (!report.closedAndConsistent())
    throw Error(ErrorKind::Input, "rigid bodies: " + body.name + ": has " + describeDefects(report) +
                                      ", and so no mass; close the mesh, or let the body be fixed");
  MovingShape moving;
  const Mesh mesh = scaledMesh(body);
  moving.mass = massProperties(mesh);
  const Box box = bounds(mesh);
  const double longest = std::max({box.max[0] - box.min[0], box.max[1] - box.min[1], box.max[2] - box.min[2]});
  if (!(moving.mass.mass > 1e-9 * std::pow(longest, 3)))
    throw Error(ErrorKind::Input,
                "rigid bodies: " + body.name + ": encloses no volume; give a mesh with an inside, or let it be fixed");
  moving.radius = std::cbrt(moving.mass.mass * 3 / (4 * std::numbers::pi));
  return moving;
}

void makeShape(MovingShape& moving, const Mesh& mesh, double lengths) {
  const std::vector<btVector3> points = ownPoints(moving.mass, mesh, lengths);
  if (const btScalar radius = roundRadius(points, moving.mass.mass * std::pow(lengths, 3)); radius > 0) {
    moving.shape = std::make_unique<btSphereShape>(radius);
    return;
  }
  const std::vector<btVector3> few = outermost(points);
  btConvexHullComputer hull;
  hull.compute(few.front().m_floats, sizeof(btVector3), static_cast<int>(few.size()), kMargin, .5f);
  auto shape = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < hull.vertices.size(); ++i) shape->addPoint(hull.vertices[i], false);
  shape->setMargin(kMargin);
  shape->recalcLocalAabb();
  moving.shape = std::move(shape);
}

FixedShape fixedShape(const RigidBody& body, const Vec3d& origin, double lengths) {
  const Mesh mesh = transformed(*body.mesh, affine(body.placement));
  FixedShape fixed;
  fixed.triangles = std::make_unique<btTriangleMesh>();
  for (const auto& triangle : mesh.triangles) {
    std::array<btVector3, 3> corner;
    for (int c = 0; c < 3; ++c) {
      const Vec3d& p = mesh.positions[triangle[c]];
      for (int a = 0; a < 3; ++a) corner[c][a] = static_cast<btScalar>(lengths * (p[a] - origin[a]));
    }
    fixed.triangles->addTriangle(corner[0], corner[1], corner[2]);
  }
  // Compressed nodes have 21 bits for the number of a triangle.
  const bool fits = fixed.triangles->getNumTriangles() < 1 << 21;
  fixed.shape = std::make_unique<btBvhTriangleMeshShape>(fixed.triangles.get(), fits);
  fixed.shape->setMargin(0);
  return fixed;
}

} // namespace volcaustic
