#include "deform/handles.h"

#include "core/parallel.h"
#include "deform/rotation_fit.h"
#include "mesh/vector.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <numbers>

namespace volcaustic {

namespace {

constexpr std::int64_t kGrain = 256;

using Rotations = std::vector<Eigen::Matrix3d>;
using Vector3Map = Eigen::Map<const Eigen::Vector3d>;

/// Diagonal of weight sums, minus the weights, between points that take part.
Eigen::SparseMatrix<double> laplaceMatrix(const DeformSurface& surface, const std::vector<PointRole>& roles) {
  const auto count = static_cast<Eigen::Index>(roles.size());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(surface.weights.size() + roles.size());
  for (std::size_t i = 0; i < roles.size(); ++i) {
    if (roles[i] == PointRole::Outside) continue;
    double sum = 0;
    for (std::uint32_t e = surface.neighbours.start[i]; e < surface.neighbours.start[i + 1]; ++e) {
      entries.emplace_back(static_cast<int>(surface.neighbours.entries[e]), static_cast<int>(i), -surface.weights[e]);
      sum += surface.weights[e];
    }
    entries.emplace_back(static_cast<int>(i), static_cast<int>(i), sum);
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Of |D^-1 L x|^2, D the diagonal of L: differences from the mean of the neighbours, squared and summed.
Eigen::SparseMatrix<double> differenceMatrix(const Eigen::SparseMatrix<double>& laplace) {
  Eigen::VectorXd scale = laplace.diagonal();
  for (double& x : scale) x = x > 0 ? 1 / (x * x) : 0;
  const Eigen::SparseMatrix<double> scaled = scale.asDiagonal() * laplace;
  return laplace * scaled;
}

/// Axis times angle. About a single coordinate axis all turns count, so that a handle can wind a bar up.
Eigen::Vector3d rotationVector(const Placement& placement) {
  const Eigen::Vector3d angles = Vector3Map(placement.rotate.data()) * (std::numbers::pi / 180);
  const bool turnsOnly = placement.shear == Vec3d{0, 0, 0} && std::ranges::min(placement.scale) > 0;
  if (turnsOnly && std::ranges::count(placement.rotate, 0) >= 2) return angles;
  const Affine a = affine(placement);
  Eigen::Matrix3d linear;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) linear(i, j) = a[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  const Eigen::AngleAxisd turn(fittedRotation(linear.transpose()));
  return turn.angle() * turn.axis();
}

Eigen::Matrix3d rotationOf(const Vec3d& vector) {
  const Vector3Map v(vector.data());
  const double angle = v.norm();
  if (!(angle > 0)) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

/// A full turn does not: it winds up what other handles hold.
bool standsStill(const Placement& p) {
  constexpr Vec3d kZero{0, 0, 0};
  return p.translate == kZero && p.rotate == kZero && p.scale == Vec3d{1, 1, 1} && p.shear == kZero;
}

Vec3d placed(const Deformer& handle, const Affine& a, const Vec3d& p) {
  const Vec3d d = difference(p, handle.center);
  Vec3d result;
  for (std::size_t i = 0; i < 3; ++i)
    result[i] = handle.center[i] + a[i][3] + a[i][0] * d[0] + a[i][1] * d[1] + a[i][2] * d[2];
  return result;
}

/// Calls body(point) for all points that take part.
template <class Body>
void forPoints(const std::vector<PointRole>& roles, const RunContext& ctx, Body&& body) {
  parallelFor(static_cast<std::int64_t>(roles.size()), kGrain, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
      if (roles[i] != PointRole::Outside) body(i);
  });
}

/// Edges of the kept shape turned by the mean of the rotations at their ends: what the global step fits positions to.
Vec3d turnedEdges(std::size_t i, const std::vector<Vec3d>& points, const DeformSurface& surface,
                  const Rotations& rotations) {
  Eigen::Vector3d own = Eigen::Vector3d::Zero(), others = Eigen::Vector3d::Zero();
  const Vector3Map at(points[i].data());
  for (std::uint32_t e = surface.neighbours.start[i]; e < surface.neighbours.start[i + 1]; ++e) {
    const std::uint32_t j = surface.neighbours.entries[e];
    const Eigen::Vector3d edge = surface.weights[e] / 2 * (at - Vector3Map(points[j].data()));
    own += edge;
    others += rotations[j] * edge;
  }
  const Eigen::Vector3d sum = rotations[i] * own + others;
  return {sum[0], sum[1], sum[2]};
}

Eigen::Matrix3d localRotation(std::size_t i, const std::vector<Vec3d>& points, const std::vector<Vec3d>& moved,
                              const DeformSurface& surface) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double before = 0, after = 0; // squares
  const Vector3Map start(points[i].data()), end(moved[i].data());
  for (std::uint32_t e = surface.neighbours.start[i]; e < surface.neighbours.start[i + 1]; ++e) {
    const std::uint32_t j = surface.neighbours.entries[e];
    const Eigen::Vector3d edge = start - Vector3Map(points[j].data()), now = end - Vector3Map(moved[j].data());
    const Eigen::Vector3d weighted = surface.weights[e] * edge;
    covariance += weighted * now.transpose();
    before += weighted.dot(edge);
    after += surface.weights[e] * now.squaredNorm();
  }
  return fittedRotation(covariance, std::sqrt(before) * std::sqrt(after));
}

} // namespace

std::vector<PointRole> rolesUnder(const DeformSurface& surface, const std::vector<int>& handleOf) {
  std::vector<bool> held(surface.componentCount, false);
  for (std::size_t i = 0; i < handleOf.size(); ++i)
    if (handleOf[i] != kNoHandle) held[surface.component[i]] = true;
  std::vector<PointRole> roles(handleOf.size(), PointRole::Outside);
  for (std::size_t i = 0; i < handleOf.size(); ++i)
    if (held[surface.component[i]]) roles[i] = handleOf[i] == kNoHandle ? PointRole::Free : PointRole::Held;
  return roles;
}

void HandleSolver::solve(std::vector<Vec3d>& points, const DeformSurface& surface, std::span<const Deformer> handles,
                         const std::vector<int>& handleOf, int iterations, const RunContext& ctx) {
  std::vector<Affine> placements;
  for (const Deformer& handle : handles) placements.push_back(affine(handle.placement));
  std::vector<bool> moves(surface.componentCount, false);
  std::vector<Vec3d> moved = points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (handleOf[i] == kNoHandle) continue;
    const auto h = static_cast<std::size_t>(handleOf[i]);
    if (standsStill(handles[h].placement)) continue;
    moved[i] = placed(handles[h], placements[h], points[i]);
    moves[surface.component[i]] = true;
  }
  if (std::ranges::find(moves, true) == moves.end()) return;
  if (!mSystem) {
    const Eigen::SparseMatrix<double> laplace = laplaceMatrix(surface, mRoles);
    mSystem.emplace(mMethod == DeformMethod::AsRigidAsPossible ? laplace : differenceMatrix(laplace), mRoles);
    ctx.throwIfCancelled();
  }
  if (mMethod == DeformMethod::AsRigidAsPossible)
    followRigidly(moved, points, surface, handles, handleOf, iterations, ctx);
  else
    followSmoothly(moved, points, ctx);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (moves[surface.component[i]]) points[i] = moved[i];
}

void HandleSolver::followRigidly(std::vector<Vec3d>& moved, const std::vector<Vec3d>& points,
                                 const DeformSurface& surface, std::span<const Deformer> handles,
                                 const std::vector<int>& handleOf, int iterations, const RunContext& ctx) {
  std::vector<Vec3d> vectors(points.size(), Vec3d{0, 0, 0}), right(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (handleOf[i] == kNoHandle) continue;
    const Eigen::Vector3d v = rotationVector(handles[static_cast<std::size_t>(handleOf[i])].placement);
    vectors[i] = {v[0], v[1], v[2]};
  }
  mSystem->solve(vectors, {}, ctx);
  Rotations rotations(points.size(), Eigen::Matrix3d::Identity());
  forPoints(mRoles, ctx, [&](std::size_t i) { rotations[i] = rotationOf(vectors[i]); });
  for (int iteration = 0;; ++iteration) {
    forPoints(mRoles, ctx, [&](std::size_t i) { right[i] = turnedEdges(i, points, surface, rotations); });
    mSystem->solve(moved, right, ctx);
    if (iteration == iterations) return;
    forPoints(mRoles, ctx, [&](std::size_t i) { rotations[i] = localRotation(i, points, moved, surface); });
  }
}

void HandleSolver::followSmoothly(std::vector<Vec3d>& moved, const std::vector<Vec3d>& points, const RunContext& ctx) {
  std::vector<Vec3d> shift(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) shift[i] = difference(moved[i], points[i]);
  mSystem->solve(shift, {}, ctx);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (mRoles[i] == PointRole::Free)
      for (std::size_t k = 0; k < 3; ++k) moved[i][k] = points[i][k] + shift[i][k];
}

} // namespace volcaustic
