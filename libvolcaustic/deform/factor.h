// A factorised sparse matrix whose solves run in parallel, with the same bits for any number of threads.
#pragma once

#include "volcaustic/run_context.h"

#include <array>
#include <Eigen/SparseCore>
#include <vector>

namespace volcaustic {

/// Three right-hand sides of one unknown, solved in one pass over the factor; the fourth fills a SIMD register.
using SolveRow = std::array<double, 4>;

/// P A P^T = L D L^T of a symmetric positive definite matrix, P a fill-reducing order. The tree of the elimination
/// falls into subtrees that do not depend on each other, and the rest above them. The solve goes from the leaves of the
/// subtrees up and back down; every unknown gathers what it needs, in an order that is part of the factor.
class Factor {
public:
  /// \param lower the lower triangle
  /// \throws Error(Input) "deform: ..." where the matrix is singular in double precision.
  explicit Factor(const Eigen::SparseMatrix<double>& lower);

  /// Replaces right-hand sides by solutions.
  void solve(std::vector<SolveRow>& rows, const RunContext& ctx);

private:
  /// The strictly triangular part of the factor, by rows or by columns.
  struct Strips {
    std::vector<int> start{0}, index;
    std::vector<double> value;
  };

  void makeTasks();
  void eliminate(const std::vector<int>& unknowns);
  void substituteBack(const std::vector<int>& unknowns);

  Strips mRows, mColumns;
  std::vector<double> mInverseDiagonal;
  std::vector<int> mPlace;              // of each unknown in the order of elimination
  std::vector<std::vector<int>> mTasks; // subtrees, each in ascending order
  std::vector<int> mTop;                // what depends on several of them
  std::vector<SolveRow> mRowsInOrder;   // of the solve that runs
};

} // namespace volcaustic
