// A linear system over the points of a surface, some of which are held where they are.
#pragma once

#include "deform/factor.h"
#include "volcaustic/types.h"

#include <cstdint>
#include <vector>

namespace volcaustic {

enum class PointRole : std::uint8_t {
  Outside, ///< takes no part
  Free,    ///< unknown
  Held     ///< given
};

class HeldSystem {
public:
  /// \param matrix symmetric, a row for each point, none between points outside and others; positive definite once the
  /// rows and columns of held points are struck out
  HeldSystem(const Eigen::SparseMatrix<double>& matrix, const std::vector<PointRole>& roles);

  /// Replaces the free points of `x` by those for which the free rows of matrix * x are those of `right`; an empty
  /// `right` stands for zeros.
  void solve(std::vector<Vec3d>& x, const std::vector<Vec3d>& right, const RunContext& ctx);

private:
  struct Coupling {
    std::size_t row;    // number of the free point
    std::uint32_t held; // point
    double entry;
  };

  static Eigen::SparseMatrix<double> freePart(const Eigen::SparseMatrix<double>& matrix,
                                              const std::vector<PointRole>& roles);

  std::vector<std::uint32_t> mFree; // points
  std::vector<Coupling> mCouplings;
  Factor mFactor;
  std::vector<SolveRow> mRows;
};

} // namespace volcaustic
