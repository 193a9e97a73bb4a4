#include "simulation/mass.h"

namespace volcaustic {

namespace {

Eigen::Vector3d vec(const Vec3d& v) { return {v[0], v[1], v[2]}; }

} // namespace

MassProperties massProperties(const Mesh& mesh) {
  const Box box = bounds(mesh);
  // Far from the origin the tetrahedra's volumes would cancel.
  const Eigen::Vector3d middle = .5 * (vec(box.min) + vec(box.max));
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const auto& triangle : mesh.triangles) {
    Eigen::Matrix3d corners;
    for (int c = 0; c < 3; ++c) corners.col(c) = vec(mesh.positions[triangle[c]]) - middle;
    const double part = corners.determinant() / 6;
    const Eigen::Vector3d sum = corners.rowwise().sum();
    volume += part;
    first += part / 4 * sum;
    second += part / 20 * (corners * corners.transpose() + sum * sum.transpose());
  }
  MassProperties result;
  result.mass = std::abs(volume); // faces may point inwards
  if (volume == 0) return result;
  const Eigen::Vector3d center = first / volume;
  second = second / volume * result.mass - result.mass * center * center.transpose();
  const Eigen::Matrix3d tensor = second.trace() * Eigen::Matrix3d::Identity() - second;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(tensor);
  result.center = middle + center;
  result.axes = solver.eigenvectors();
  if (result.axes.determinant() < 0) result.axes.col(2) *= -1;
  result.inertia = solver.eigenvalues();
  return result;
}

} // namespace volcaustic
