#include "deform/held_system.h"

namespace volcaustic {

namespace {

std::vector<std::uint32_t> pointsOf(const std::vector<PointRole>& roles, PointRole role) {
  std::vector<std::uint32_t> points;
  for (std::uint32_t i = 0; i < roles.size(); ++i)
    if (roles[i] == role) points.push_back(i);
  return points;
}

} // namespace

HeldSystem::HeldSystem(const Eigen::SparseMatrix<double>& matrix, const std::vector<PointRole>& roles)
    : mFree(pointsOf(roles, PointRole::Free)), mFactor(freePart(matrix, roles)), mRows(mFree.size()) {
  for (std::size_t row = 0; row < mFree.size(); ++row)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(matrix, mFree[row]); entry; ++entry)
      if (roles[static_cast<std::size_t>(entry.row())] == PointRole::Held)
        mCouplings.push_back({row, static_cast<std::uint32_t>(entry.row()), entry.value()});
}

Eigen::SparseMatrix<double> HeldSystem::freePart(const Eigen::SparseMatrix<double>& matrix,
                                                 const std::vector<PointRole>& roles) {
  std::vector<int> number(roles.size(), 0);
  int count = 0;
  for (std::size_t i = 0; i < roles.size(); ++i)
    if (roles[i] == PointRole::Free) number[i] = count++;
  Eigen::SparseMatrix<double> part(count, count);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    if (roles[i] != PointRole::Free) continue;
    for (Eigen::SparseMatrix<double>::InnerIterator entry(matrix, static_cast<Eigen::Index>(i)); entry; ++entry) {
      const auto row = static_cast<std::size_t>(entry.row());
      if (row >= i && roles[row] == PointRole::Free) entries.emplace_back(number[row], number[i], entry.value());
    }
  }
  part.setFromTriplets(entries.begin(), entries.end());
  return part;
}

void HeldSystem::solve(std::vector<Vec3d>& x, const std::vector<Vec3d>& right, const RunContext& ctx) {
  for (std::size_t row = 0; row < mFree.size(); ++row) {
    const Vec3d value = right.empty() ? Vec3d{} : right[mFree[row]];
    mRows[row] = {value[0], value[1], value[2], 0};
  }
  for (const Coupling& c : mCouplings)
    for (std::size_t k = 0; k < 3; ++k) mRows[c.row][k] -= c.entry * x[c.held][k];
  mFactor.solve(mRows, ctx);
  for (std::size_t row = 0; row < mFree.size(); ++row) x[mFree[row]] = {mRows[row][0], mRows[row][1], mRows[row][2]};
}

} // namespace volcaustic
