#include "simulation/multigrid.h"

namespace volcaustic {

namespace {

constexpr std::size_t kCoarsest = 64; ///< cells, which sweeps alone solve
constexpr int kCoarsestSweeps = 16;

std::array<PoissonLevel::Axis, 3> joined(std::array<PoissonLevel::Axis, 3> axes) {
  for (int a = 0; a < 3; ++a) {
    PoissonLevel::Axis& axis = axes[a];
    const std::size_t count = axis.width.size();
    axis.couple.assign(count + 1, 0);
    for (std::size_t i = 1; i < count; ++i) axis.couple[i] = 2 / (axis.width[i - 1] + axis.width[i]);
    axis.open = a == 2 ? 2 / axis.width.back() : 0;
  }
  return axes;
}

} // namespace

/// Coefficients of the cells of one row; those of i follow from the axis x.
struct PoissonLevel::Row {
  std::size_t first;           ///< cell
  float across;                ///< area of the faces along x
  float down, up, below, over; ///< over width x: to (j-1), (j+1), (k-1), (k+1)
  float open;
  std::ptrdiff_t y, z;
};

PoissonLevel::PoissonLevel(std::array<Axis, 3> given, const Vec3i& n)
    : dims(n)
    , axes(joined(std::move(given)))
    , solution(static_cast<std::size_t>(n[0]) * n[1] * n[2])
    , right(solution.size())
    , mResidual(solution.size()) {}

PoissonLevel PoissonLevel::finest(const Vec3i& cells) {
  std::array<Axis, 3> axes;
  for (int a = 0; a < 3; ++a) axes[a].width.assign(cells[a], 1);
  return {axes, cells};
}

PoissonLevel PoissonLevel::coarser() const {
  std::array<Axis, 3> joint;
  Vec3i half;
  for (int a = 0; a < 3; ++a) {
    half[a] = (dims[a] + 1) / 2;
    joint[a].width.assign(half[a], 0);
    for (int i = 0; i < dims[a]; ++i) joint[a].width[i / 2] += axes[a].width[i];
  }
  return {joint, half};
}

PoissonLevel::Row PoissonLevel::row(int j, int k) const {
  const Axis &y = axes[1], &z = axes[2];
  const float wy = y.width[j], wz = z.width[k];
  return {.first = (static_cast<std::size_t>(k) * dims[1] + j) * dims[0],
          .across = wy * wz,
          .down = y.couple[j] * wz,
          .up = y.couple[j + 1] * wz,
          .below = z.couple[k] * wy,
          .over = z.couple[k + 1] * wy,
          .open = k == dims[2] - 1 ? z.open * wy : 0,
          .y = dims[0],
          .z = std::ptrdiff_t{dims[0]} * dims[1]};
}

namespace {

/// Calls at(i, diagonal, sum of the neighbours' products) for cells i = begin, begin + step, ... of a row.
template <class Row, class At>
void alongRow(const PoissonLevel::Axis& axis, const Row& row, const float* x, int begin, int step, const At& at) {
  const int n = static_cast<int>(axis.width.size());
  // Where there is no neighbour its coefficient is zero, and the cell itself is read.
  const std::ptrdiff_t down = row.down > 0 ? -row.y : 0, up = row.up > 0 ? row.y : 0;
  const std::ptrdiff_t below = row.below > 0 ? -row.z : 0, over = row.over > 0 ? row.z : 0;
  const float cross = row.down + row.up + row.below + row.over + row.open;
  for (int i = begin; i < n; i += step) {
    const float wx = axis.width[i], low = axis.couple[i] * row.across, high = axis.couple[i + 1] * row.across;
    const float* c = x + i;
    float sum = wx * (row.down * c[down] + row.up * c[up] + row.below * c[below] + row.over * c[over]);
    if (i > 0) sum += low * c[-1];
    if (i < n - 1) sum += high * c[1];
    at(i, low + high + wx * cross, sum);
  }
}

} // namespace

void PoissonLevel::multiply(const std::vector<float>& x, std::vector<float>& result, const RunContext& ctx) const {
  forEachRow(dims, ctx, [&](int j, int k) {
    const Row r = row(j, k);
    const float* in = x.data() + r.first;
    float* out = result.data() + r.first;
    alongRow(axes[0], r, in, 0, 1, [&](int i, float diagonal, float sum) { out[i] = diagonal * in[i] - sum; });
  });
}

void PoissonLevel::relax(int colour, const RunContext& ctx) {
  forEachRow(dims, ctx, [&](int j, int k) {
    const Row r = row(j, k);
    float* x = solution.data() + r.first;
    const float* b = right.data() + r.first;
    alongRow(axes[0], r, x, (j + k + colour) & 1, 2,
             [&](int i, float diagonal, float sum) { x[i] = (b[i] + sum) / diagonal; });
  });
}

void PoissonLevel::restrictTo(PoissonLevel& coarse, const RunContext& ctx) {
  multiply(solution, mResidual, ctx);
  forEachRow(coarse.dims, ctx, [&](int j, int k) {
    float* sum = coarse.right.data() + (static_cast<std::size_t>(k) * coarse.dims[1] + j) * coarse.dims[0];
    std::fill_n(sum, coarse.dims[0], 0.0f);
    for (int z = 2 * k; z < std::min(2 * k + 2, dims[2]); ++z)
      for (int y = 2 * j; y < std::min(2 * j + 2, dims[1]); ++y) {
        const std::size_t first = (static_cast<std::size_t>(z) * dims[1] + y) * dims[0];
        for (int i = 0; i < dims[0]; ++i) sum[i / 2] += right[first + i] - mResidual[first + i];
      }
  });
}

void PoissonLevel::prolongFrom(const PoissonLevel& coarse, const RunContext& ctx) {
  forEachRow(dims, ctx, [&](int j, int k) {
    const float* from =
        coarse.solution.data() + (static_cast<std::size_t>(k / 2) * coarse.dims[1] + j / 2) * coarse.dims[0];
    float* x = solution.data() + (static_cast<std::size_t>(k) * dims[1] + j) * dims[0];
    for (int i = 0; i < dims[0]; ++i) x[i] += from[i / 2];
  });
}

Multigrid::Multigrid(const Vec3i& cells) {
  mLevels.push_back(PoissonLevel::finest(cells));
  while (mLevels.back().size() > kCoarsest) mLevels.push_back(mLevels.back().coarser());
}

void Multigrid::cycle(const std::vector<float>& right, std::vector<float>& result, const RunContext& ctx) {
  mLevels.front().right = right;
  cycleFrom(0, ctx);
  result = mLevels.front().solution;
}

void Multigrid::cycleFrom(std::size_t number, const RunContext& ctx) {
  PoissonLevel& level = mLevels[number];
  std::fill(level.solution.begin(), level.solution.end(), 0.0f);
  const bool coarsest = number + 1 == mLevels.size();
  const int sweeps = coarsest ? kCoarsestSweeps : 1;
  // The colours the other way round on the way back: so the cycle is symmetric.
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (const int colour : {0, 1}) level.relax(colour, ctx);
  if (!coarsest) {
    level.restrictTo(mLevels[number + 1], ctx);
    cycleFrom(number + 1, ctx);
    level.prolongFrom(mLevels[number + 1], ctx);
  }
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (const int colour : {1, 0}) level.relax(colour, ctx);
}

} // namespace volcaustic
