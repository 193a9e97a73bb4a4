// Two fluids that mix in a box (docs/algorithms/simulation.md): advection, diffusion, forces, pressure, in this order.
#include "core/range_check.h"
#include "simulation/mixing_state.h"

#include <cmath>

namespace volcaustic {

namespace {

constexpr double kCellsPerStep = 1.5; ///< that the fastest flow may pass
constexpr int kMaxSteps = 64;         ///< for a frame; beyond them steps are longer, which costs detail, not stability
constexpr int kLeastCells = 4;        ///< along the shortest side
constexpr std::uint64_t kBytesPerCell = 200;

Domain domainOf(const MixingOptions& options) {
  Domain domain;
  domain.voxelSize = *std::max_element(options.size.begin(), options.size.end()) / options.resolution;
  for (int a = 0; a < 3; ++a) {
    domain.dims[a] = static_cast<int>(std::lround(options.size[a] / domain.voxelSize));
    if (domain.dims[a] < kLeastCells)
      throw Error(ErrorKind::Usage,
                  "mixing: the box is only " + std::to_string(domain.dims[a]) +
                      " cells wide along an axis; raise resolution, or give a box of more equal sides");
    domain.minCorner[a] = options.center[a] - .5 * domain.dims[a] * domain.voxelSize;
  }
  return domain;
}

void addBuoyancy(Flow& flow, double acceleration, double time, const RunContext& ctx) {
  Lattice& upwards = flow.velocity.component[2];
  const float half = static_cast<float>(.5 * acceleration * time);
  forEachRow(upwards.dims(), ctx, [&](int j, int k) {
    if (k == 0) return;
    for (int i = 0; i < flow.cells[0]; ++i)
      upwards.at(i, j, k) += half * (flow.concentration.at(i, j, k) + flow.concentration.at(i, j, k + 1));
  });
}

/// Within the box: what is beyond bottom and top is imposed, and nothing comes from there but with the flow.
void diffuseCells(Flow& flow, double amount, const RunContext& ctx) {
  if (amount <= 0) return;
  Lattice cells(flow.cells, {.5f, .5f, .5f});
  const auto first = flow.concentration.values().begin() + static_cast<std::ptrdiff_t>(flow.concentration.stride(2));
  std::copy_n(first, cells.size(), cells.values().begin());
  constexpr auto kClosed = DiffusionEnds::Closed;
  diffuse(cells, amount, {kClosed, kClosed, kClosed}, ctx);
  std::copy(cells.values().begin(), cells.values().end(), first);
}

} // namespace

MixingSimulation::State::State(const MixingOptions& given, const Domain& box, const RunContext& context)
    : options(given)
    , ctx(context)
    , domain(box)
    , jet(given, box.dims, box.voxelSize, context.seed)
    , solver(box.dims)
    , flow(box.dims) {
  jet.impose(flow, 0);
  solver.project(flow, ctx);
}

double MixingSimulation::State::longestStep(const Flow& now) const {
  const double flowing = now.velocity.maxSpeed(ctx);
  if (!std::isfinite(flowing))
    throw Error(ErrorKind::Input, "mixing: the flow left the finite numbers; lower inflow, buoyancy or swirl");
  // What a step may add to it from rest.
  const double speed = flowing + std::sqrt(std::abs(options.buoyancy) * domain.voxelSize);
  return speed > 0 ? kCellsPerStep * domain.voxelSize / speed : 1 / options.framesPerSecond;
}

void MixingSimulation::State::step(Flow& now, double begin, double time) {
  const float cells = static_cast<float>(time / domain.voxelSize);
  Flow next = now;
  next.concentration = advected(now.concentration, now.velocity, cells, ctx);
  for (int a = 0; a < 3; ++a)
    next.velocity.component[a] = advected(now.velocity.component[a], now.velocity, cells, ctx);
  balance(next, now, cells, ctx);

  const double perCell = time / (domain.voxelSize * domain.voxelSize);
  constexpr auto kClosed = DiffusionEnds::Closed;
  diffuseCells(next, options.diffusion * perCell, ctx);
  for (int a = 0; a < 3; ++a) {
    std::array<DiffusionEnds, 3> ends{kClosed, kClosed, kClosed};
    ends[a] = DiffusionEnds::Held;
    diffuse(next.velocity.component[a], options.viscosity * perCell, ends, ctx);
  }

  addBuoyancy(next, options.buoyancy, time, ctx);
  confineVorticity(next.velocity, next.cells, options.swirl, time, ctx);
  jet.impose(next, begin + time);
  solver.project(next, ctx);
  now = std::move(next);
}

void MixingSimulation::State::advance(Flow& now) {
  const double length = 1 / options.framesPerSecond, begin = frame * length;
  double done = 0;
  while (done < length) {
    const double longest = std::max(longestStep(now), length / kMaxSteps), rest = length - done;
    const bool last = rest <= longest;
    const double time = last ? rest : rest / std::ceil(rest / longest);
    step(now, begin + done, time);
    done = last ? length : done + time;
    ctx.progress("mixing", done / length);
  }
}

MixingSimulation::MixingSimulation(const MixingOptions& options, const RunContext& ctx) {
  MixingOptions checked = options;
  describe(RangeCheck(ErrorKind::Usage, "mixing"), checked);
  const Domain domain = domainOf(options);
  ctx.requireMemory(static_cast<std::uint64_t>(domain.voxelCount()) * kBytesPerCell, "mixing at this resolution");
  mState = std::make_unique<State>(options, domain, ctx);
}

MixingSimulation::~MixingSimulation() = default;
MixingSimulation::MixingSimulation(MixingSimulation&&) noexcept = default;
MixingSimulation& MixingSimulation::operator=(MixingSimulation&&) noexcept = default;

void MixingSimulation::advance() {
  Flow next = mState->flow; // a cancelled frame begins anew
  mState->advance(next);
  mState->flow = std::move(next);
  ++mState->frame;
}

int MixingSimulation::frame() const { return mState->frame; }

float MixingSimulation::concentration(const Vec3i& cell) const {
  for (int a = 0; a < 3; ++a)
    if (cell[a] < 0 || cell[a] >= mState->domain.dims[a])
      throw Error(ErrorKind::Usage, "MixingSimulation::concentration: the cell is outside the box; see domain()");
  return mState->flow.concentration.at(cell[0], cell[1], cell[2] + 1);
}

const Domain& MixingSimulation::domain() const { return mState->domain; }

double MixingSimulation::divergence() const {
  const double fastest = mState->flow.velocity.maxSpeed(mState->ctx);
  return fastest > 0 ? largestDivergence(mState->flow.velocity, mState->flow.cells, mState->ctx) / fastest : 0;
}

} // namespace volcaustic
