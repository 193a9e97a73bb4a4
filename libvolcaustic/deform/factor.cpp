#include "deform/factor.h"

#include "core/parallel.h"
#include "core/simd_clones.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <Eigen/SparseCholesky>

namespace volcaustic {

namespace {

/// Subtrees are cut where one has less than this part of all entries: enough pieces for any number of threads, few
/// enough that most of the work is in them.
constexpr std::size_t kPieces = 32;

/// row - sum of value[e] * rows[index[e]] over the entries [begin, end).
VOLCAUSTIC_SIMD_CLONES void gather(SolveRow& row, const SolveRow* rows, const int* index, const double* value,
                                   int begin, int end) {
  double sum[4] = {row[0], row[1], row[2], row[3]};
  for (int e = begin; e < end; ++e) {
    const double* other = rows[index[e]].data();
    for (int k = 0; k < 4; ++k) sum[k] -= value[e] * other[k];
  }
  for (std::size_t k = 0; k < 4; ++k) row[k] = sum[k];
}

} // namespace

Factor::Factor(const Eigen::SparseMatrix<double>& lower) {
  if (lower.rows() == 0) return;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> ldlt(lower);
  const Eigen::VectorXd diagonal = ldlt.vectorD();
  if (ldlt.info() != Eigen::Success || !(diagonal.array() > 0).all())
    throw Error(ErrorKind::Input, "deform: the surface is too uneven for its equations to be solved; "
                                  "remesh it, or hold more of it with handles");
  const Eigen::SparseMatrix<double>& l = ldlt.matrixL().nestedExpression();
  const auto keep = [](const auto& matrix, Strips& strips) {
    strips.start.assign(matrix.outerIndexPtr(), matrix.outerIndexPtr() + matrix.outerSize() + 1);
    strips.index.assign(matrix.innerIndexPtr(), matrix.innerIndexPtr() + matrix.nonZeros());
    strips.value.assign(matrix.valuePtr(), matrix.valuePtr() + matrix.nonZeros());
  };
  keep(l, mColumns);
  keep(Eigen::SparseMatrix<double, Eigen::RowMajor>(l), mRows);
  const Eigen::Index count = l.rows();
  mPlace.resize(static_cast<std::size_t>(count));
  for (Eigen::Index i = 0; i < count; ++i)
    mPlace[static_cast<std::size_t>(i)] = ldlt.permutationP().size() > 0 ? ldlt.permutationP().indices()[i] : int(i);
  for (const double d : diagonal) mInverseDiagonal.push_back(1 / d);
  mRowsInOrder.resize(mPlace.size());
  makeTasks();
}

void Factor::makeTasks() {
  const std::size_t count = mPlace.size();
  constexpr int kRoot = -1;
  std::vector<int> parent(count, kRoot);
  std::vector<std::size_t> work(count, 0); // entries of the subtree
  for (std::size_t i = 0; i < count; ++i) {
    work[i] += 1 + static_cast<std::size_t>(mColumns.start[i + 1] - mColumns.start[i]);
    if (mColumns.start[i] == mColumns.start[i + 1]) continue;
    parent[i] = mColumns.index[static_cast<std::size_t>(mColumns.start[i])];
    work[static_cast<std::size_t>(parent[i])] += work[i];
  }
  const std::size_t most = (mColumns.value.size() + count) / kPieces + 1;
  std::vector<int> taskOf(count, kRoot);
  std::size_t filled = most; // of the last task: small subtrees share one
  for (std::size_t i = count; i-- > 0;) {
    const auto above = static_cast<std::size_t>(parent[i]);
    if (work[i] > most) continue;
    if (parent[i] == kRoot || work[above] > most) {
      if (filled + work[i] > most) {
        mTasks.emplace_back();
        filled = 0;
      }
      filled += work[i];
      taskOf[i] = static_cast<int>(mTasks.size()) - 1;
    } else {
      taskOf[i] = taskOf[above];
    }
  }
  for (std::size_t i = 0; i < count; ++i)
    (taskOf[i] == kRoot ? mTop : mTasks[static_cast<std::size_t>(taskOf[i])]).push_back(static_cast<int>(i));
}

void Factor::eliminate(const std::vector<int>& unknowns) {
  for (const int i : unknowns) {
    const auto at = static_cast<std::size_t>(i);
    gather(mRowsInOrder[at], mRowsInOrder.data(), mRows.index.data(), mRows.value.data(), mRows.start[at],
           mRows.start[at + 1]);
  }
}

void Factor::substituteBack(const std::vector<int>& unknowns) {
  for (auto i = unknowns.rbegin(); i != unknowns.rend(); ++i) {
    const auto at = static_cast<std::size_t>(*i);
    for (double& x : mRowsInOrder[at]) x *= mInverseDiagonal[at];
    gather(mRowsInOrder[at], mRowsInOrder.data(), mColumns.index.data(), mColumns.value.data(), mColumns.start[at],
           mColumns.start[at + 1]);
  }
}

void Factor::solve(std::vector<SolveRow>& rows, const RunContext& ctx) {
  const auto forTasks = [&](auto&& body) {
    parallelFor(static_cast<std::int64_t>(mTasks.size()), 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t t = begin; t < end; ++t) body(mTasks[static_cast<std::size_t>(t)]);
    });
  };
  for (std::size_t i = 0; i < rows.size(); ++i) mRowsInOrder[static_cast<std::size_t>(mPlace[i])] = rows[i];
  forTasks([&](const std::vector<int>& task) { eliminate(task); });
  eliminate(mTop);
  substituteBack(mTop);
  forTasks([&](const std::vector<int>& task) { substituteBack(task); });
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = mRowsInOrder[static_cast<std::size_t>(mPlace[i])];
}

} // namespace volcaustic
