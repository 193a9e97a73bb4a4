#include "simulation/pressure.h"

#include <cmath>

namespace volcaustic {

namespace {

constexpr double kTolerance = 1e-4; ///< largest divergence that is left, over the fastest speed
constexpr int kMaxIterations = 100;
constexpr std::int64_t kPiece = 16384; // of an array, for one thread at a time

/// Sums of pieces of fixed size, added in their order: the same bits for any number of threads.
double dot(const std::vector<float>& a, const std::vector<float>& b, const RunContext& ctx) {
  const auto count = static_cast<std::int64_t>(a.size());
  std::vector<double> sums((count + kPiece - 1) / kPiece);
  parallelFor(count, kPiece, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    double sum = 0;
    for (std::int64_t i = begin; i < end; ++i) sum += static_cast<double>(a[i]) * b[i];
    sums[begin / kPiece] = sum;
  });
  double total = 0;
  for (const double sum : sums) total += sum;
  return total;
}

/// body(i) for all i below `count`.
template <class Body>
void forEach(std::size_t count, const RunContext& ctx, const Body& body) {
  parallelFor(static_cast<std::int64_t>(count), kPiece, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) body(i);
  });
}

/// a = b + factor * a, or with the roles turned round.
void scaleAndAdd(std::vector<float>& a, double factor, const std::vector<float>& b, const RunContext& ctx) {
  forEach(a.size(), ctx, [&](std::size_t i) { a[i] = b[i] + static_cast<float>(factor) * a[i]; });
}
void addScaled(std::vector<float>& a, double factor, const std::vector<float>& b, const RunContext& ctx) {
  forEach(a.size(), ctx, [&](std::size_t i) { a[i] += static_cast<float>(factor) * b[i]; });
}

void divergence(const StaggeredVelocity& velocity, const Vec3i& cells, std::vector<float>& result,
                const RunContext& ctx) {
  forEachRow(cells, ctx, [&](int j, int k) {
    float* out = result.data() + (static_cast<std::size_t>(k) * cells[1] + j) * cells[0];
    std::fill_n(out, cells[0], 0.0f);
    for (int a = 0; a < 3; ++a) {
      const Lattice& faces = velocity.component[a];
      const float* low = faces.values().data() + faces.index(0, j, k);
      const float* high = low + faces.stride(a);
      for (int i = 0; i < cells[0]; ++i) out[i] += high[i] - low[i];
    }
  });
}

/// Takes the gradient from the faces between cells, and from the open top.
void subtractGradient(Flow& flow, const RunContext& ctx) {
  const Lattice& p = flow.pressure;
  for (int a = 0; a < 3; ++a) {
    Lattice& faces = flow.velocity.component[a];
    forEachRow(faces.dims(), ctx, [&](int j, int k) {
      for (int i = 0; i < faces.dims()[0]; ++i) {
        Vec3i cell{i, j, k};
        if (cell[a] == 0 || (a < 2 && cell[a] == flow.cells[a])) continue;
        --cell[a];
        const float before = p.at(cell[0], cell[1], cell[2]);
        faces.at(i, j, k) -= a == 2 && k == flow.cells[2] ? -2 * before : p.at(i, j, k) - before;
      }
    });
  }
}

} // namespace

double largestDivergence(const StaggeredVelocity& velocity, const Vec3i& cells, const RunContext& ctx) {
  std::vector<float> values(static_cast<std::size_t>(cells[0]) * cells[1] * cells[2]);
  divergence(velocity, cells, values, ctx);
  return largestMagnitude(values, ctx);
}

PressureSolver::PressureSolver(const Vec3i& cells)
    : mMultigrid(cells)
    , mResidual(mMultigrid.finest().size())
    , mDirection(mResidual)
    , mPreconditioned(mResidual)
    , mProduct(mResidual) {}

int PressureSolver::project(Flow& flow, const RunContext& ctx) {
  std::vector<float>& x = flow.pressure.values();
  const PoissonLevel& matrix = mMultigrid.finest();
  const double enough = kTolerance * flow.velocity.maxSpeed(ctx);
  divergence(flow.velocity, flow.cells, mResidual, ctx);
  matrix.multiply(x, mProduct, ctx);
  forEach(x.size(), ctx, [&](std::size_t i) { mResidual[i] = -mResidual[i] - mProduct[i]; });
  double energy = 0;
  int iteration = 0;
  for (; iteration < kMaxIterations && largestMagnitude(mResidual, ctx) > enough; ++iteration) {
    mMultigrid.cycle(mResidual, mPreconditioned, ctx);
    const double next = dot(mResidual, mPreconditioned, ctx);
    if (iteration == 0)
      mDirection = mPreconditioned;
    else
      scaleAndAdd(mDirection, next / energy, mPreconditioned, ctx);
    energy = next;
    matrix.multiply(mDirection, mProduct, ctx);
    const double step = energy / dot(mDirection, mProduct, ctx);
    addScaled(x, step, mDirection, ctx);
    addScaled(mResidual, -step, mProduct, ctx);
  }
  subtractGradient(flow, ctx);
  return iteration;
}

} // namespace volcaustic
