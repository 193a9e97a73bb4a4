// The photon pass: emission, march, merge, direct light, smoothing (docs/algorithms/photons.md).

#include "volcaustic/photons.h"

#include "backends/photon_tracer.h"
#include "core/parallel.h"
#include "transport/direct.h"
#include "transport/emission.h"
#include "transport/march_rules.h"
#include "transport/passes.h"
#include "transport/reach.h"
#include "transport/smooth.h"
#include "transport/tracers.h"
#include "volcaustic/error.h"
#include "volume/radiance_bricks.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <type_traits>

namespace volcaustic {

namespace {

using kernels::Counter;
using kernels::EmissionFrame;
using kernels::Outcome;

struct NumberedFrame {
  int light;
  EmissionFrame frame;
};

/// Units of the sums. The strongest photon's light in a voxel is worth 2^15 to 2^17 units, so rounding costs a
/// hundred-thousandth of it, evenly up and down; powers have room for all that the rasters can emit.
FixedPoint fixedPoint(std::span<const NumberedFrame> frames) {
  double watts = 0, photon = 0;
  for (const auto& [light, f] : frames) {
    const double strongest = kernels::maxComponent(f.strength);
    watts += strongest * (f.point ? 4 * 3.14159265358979323846 : static_cast<double>(f.cells()));
    photon = std::max(photon, strongest * (f.point ? f.du * f.dv : 1));
  }
  const auto exponentOf = [](double v) {
    int exponent = 0;
    std::frexp(v > 0 ? v : 1.0, &exponent);
    return exponent;
  };
  return {std::ldexp(1.0, 16 - exponentOf(photon)), std::ldexp(1.0, 60 - exponentOf(watts))};
}

class PhotonPass {
public:
  PhotonPass(const Medium& medium, const FlatMediumStorage& flat, std::span<const Light> lights,
             const PhotonOptions& options, const RunContext& ctx, std::shared_ptr<TracerState> state)
      : mMedium(medium)
      , mLights(lights)
      , mOptions(options)
      , mCtx(ctx)
      , mFlat(flat)
      , mFrames(allFrames())
      , mScale(fixedPoint(mFrames))
      , mTracer(makeTracer({flat.view(), rules(), mScale}, tracerContext(), std::move(state)))
      , mDirect{
            BrickGrid<Vec3f>(medium.domain().dims, {0, 0, 0}), BrickGrid<Vec3f>(medium.domain().dims, {0, 0, 0}), {}} {}

  PhotonResult run() {
    for (std::size_t i = 0; i < mFrames.size(); ++i) traceFrame(static_cast<int>(i));
    return finish();
  }

private:
  [[nodiscard]] std::vector<NumberedFrame> allFrames() const {
    std::vector<NumberedFrame> frames;
    for (std::size_t i = 0; i < mLights.size(); ++i)
      for (const EmissionFrame& f :
           emissionFrames(mLights[i], static_cast<int>(i), mMedium.domain(), mOptions, mCtx.seed))
        frames.push_back({static_cast<int>(i), f});
    return frames;
  }

  /// Raster by raster, each in strips of rows: what a tracer keeps for its photons stays small, and a run of hours can
  /// tell how far it is.
  void traceFrame(int number) {
    const auto& [light, frame] = mFrames[number];
    mCtx.requireMemory(static_cast<std::uint64_t>(frame.cells()) * sizeof(float), "photons.grid");
    std::vector<float> entry(frame.cells());
    const ReachMap reach = timed("reach", [&] { return reachOf(mFlat, frame); });
    constexpr std::int64_t kStripCells = 1 << 22;
    const std::int64_t tiles = std::max<std::int64_t>(kStripCells / frame.columns / kernels::kReachTile, 1);
    const auto strip = static_cast<std::int32_t>(std::min<std::int64_t>(tiles * kernels::kReachTile, frame.rows));
    for (RowRange rows{0, strip}; rows.begin < frame.rows; rows = {rows.end, rows.end + strip}) {
      rows.end = std::min(rows.end, frame.rows);
      const double all = static_cast<double>(mFrames.size()) * frame.rows;
      mTraced = static_cast<double>(number) / static_cast<double>(mFrames.size()) + rows.begin / all;
      mTracing = (rows.end - rows.begin) / all;
      timed("emission", [&] { mTracer->emit(frame, reach.view(), rows, entry.data()); });
      timed("photons", [&] { mTracer->trace(frame, rows, entry.data()); });
    }
    timed("direct light",
          [&] { addDirectLight(mDirect, mFlat, mMedium.domain(), mLights[light], frame, entry, mCtx); });
  }

  /// The caller's, with progress over all rasters and strips.
  [[nodiscard]] RunContext tracerContext() {
    RunContext ctx = mCtx;
    if (mCtx.onProgress)
      ctx.onProgress = [this](std::string_view stage, double f) { mCtx.onProgress(stage, mTraced + f * mTracing); };
    return ctx;
  }

  /// Runs a part and adds its time to the parts of that name.
  template <class Part>
  std::invoke_result_t<Part> timed(const char* name, const Part& part) {
    const auto start = std::chrono::steady_clock::now();
    const auto book = [&] {
      const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
      const auto it = std::find_if(mParts.begin(), mParts.end(), [name](const PassPart& p) { return p.name == name; });
      if (it != mParts.end())
        it->ms += ms.count();
      else
        mParts.push_back({name, ms.count()});
    };
    if constexpr (std::is_void_v<decltype(part())>) {
      part();
      book();
    } else {
      auto result = part();
      book();
      return result;
    }
  }

  [[nodiscard]] kernels::PhotonRules rules() const {
    return {marchRules(mOptions), mOptions.maxSteps, static_cast<float>(mOptions.cutoff), mOptions.roulette, mCtx.seed};
  }

  /// Fixed-point sums to fluence, block by block; the caustic's direction sums go to `direction`. Returns what the
  /// medium takes of that light, W.
  Rgb merge(BrickGrid<Vec3f>& caustic, BrickGrid<Vec3f>& direction) {
    const std::vector<BlockOfBricks> blocks = touchedBlocks(caustic);
    // Some blocks at a time: what bricks of a block are lit is known when its sums are.
    const auto group = std::max<std::int64_t>(64, std::int64_t{16} * threadCount(mCtx));
    std::vector<BrickLight, UninitialisedAllocator<BrickLight>> found(group * kBlockBricks);
    std::vector<char> lit(found.size());
    Rgb loss{0, 0, 0};
    for (std::int64_t first = 0; first < static_cast<std::int64_t>(blocks.size()); first += group) {
      const std::int64_t count = std::min(group, static_cast<std::int64_t>(blocks.size()) - first);
      std::vector<Rgb> losses(count);
      std::fill(lit.begin(), lit.end(), 0);
      parallelFor(count, 1, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
        BlockSums sums;
        for (std::int64_t i = begin; i < end; ++i) {
          const BlockOfBricks& block = blocks[first + i];
          sums.clear();
          mTracer->addBlock(block.number, sums);
          for (std::size_t k = 0; k < block.bricks.size(); ++k) {
            const std::size_t at = i * kBlockBricks + k;
            lit[at] = mergeBrick(caustic.brickCoord(block.bricks[k]), sums, found[at], losses[i]);
          }
        }
      });
      for (const Rgb& l : losses)
        for (int c = 0; c < 3; ++c) loss[c] += l[c];
      storeLit(std::span(blocks).subspan(first, count), found, lit, caustic, direction);
    }
    return loss;
  }

  /// Light and its direction sums in a brick.
  struct BrickLight {
    std::array<Vec3f, kBrickVoxels> light, towards;
  };
  static constexpr std::int64_t kBlockBricks = kBlockVoxels / kBrickVoxels;

  struct BlockOfBricks {
    std::int64_t number;
    std::vector<std::int64_t> bricks; ///< inside the domain
  };

  [[nodiscard]] std::vector<BlockOfBricks> touchedBlocks(const BrickGrid<Vec3f>& grid) const {
    constexpr int kEdge = kBlockEdge / kBrickSize;
    const kernels::Int3 count = blockDims(mFlat.dims);
    std::vector<BlockOfBricks> blocks;
    std::int64_t number = 0;
    for (int x = 0; x < count.x; ++x)
      for (int y = 0; y < count.y; ++y)
        for (int z = 0; z < count.z; ++z, ++number) {
          if (!mTracer->touched(number)) continue;
          BlockOfBricks block{number, {}};
          for (int i = 0; i < kEdge * kEdge * kEdge; ++i) {
            const Vec3i brick{x * kEdge + i / (kEdge * kEdge), y * kEdge + i / kEdge % kEdge, z * kEdge + i % kEdge};
            const Vec3i& n = grid.brickDims();
            if (brick[0] < n[0] && brick[1] < n[1] && brick[2] < n[2]) block.bricks.push_back(grid.brickIndex(brick));
          }
          blocks.push_back(std::move(block));
        }
    return blocks;
  }

  /// Gives the bricks with light their voxels in the grids.
  void storeLit(std::span<const BlockOfBricks> blocks, std::span<const BrickLight> found, std::span<const char> lit,
                BrickGrid<Vec3f>& caustic, BrickGrid<Vec3f>& direction) const {
    std::vector<std::int64_t> bricks, from;
    for (std::size_t i = 0; i < blocks.size(); ++i)
      for (std::size_t k = 0; k < blocks[i].bricks.size(); ++k)
        if (const std::size_t at = i * kBlockBricks + k; lit[at]) {
          bricks.push_back(blocks[i].bricks[k]);
          from.push_back(static_cast<std::int64_t>(at));
        }
    mCtx.requireMemory((caustic.activeBrickCount() + bricks.size()) * sizeof(BrickLight) +
                           mDirect.fluence.memoryBytes() + mDirect.direction.memoryBytes(),
                       "photons: caustic light");
    caustic.activate(bricks, Fill::Later);
    direction.activate(bricks, Fill::Later);
    parallelFor(static_cast<std::int64_t>(bricks.size()), 32, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) {
        const BrickLight& b = found[from[i]];
        std::copy(b.light.begin(), b.light.end(), caustic.voxels(bricks[i]).begin());
        std::copy(b.towards.begin(), b.towards.end(), direction.voxels(bricks[i]).begin());
      }
    });
  }

  /// Fluence of one brick, and what the medium takes of it; false when it holds no light.
  bool mergeBrick(const Vec3i& c, const BlockSums& sums, BrickLight& out, Rgb& loss) const {
    // Sums are W*voxel; fluence is their world length over the voxel's volume. Attenuation is in 1/voxel: its part of
    // W*voxel is W.
    const double h = mMedium.domain().voxelSize, watts = 1 / mScale.deposit, unit = watts / (h * h);
    const kernels::FlatMedium flat = mFlat.view();
    bool lit = false;
    const std::int32_t* low = sums.lowOnly();
    for (int k = 0; k < kBrickVoxels; ++k) {
      const int x = c[0] * 8 + (k >> 6), y = c[1] * 8 + ((k >> 3) & 7), z = c[2] * 8 + (k & 7);
      const int voxel = blockOffset(x, y, z);
      const std::int32_t* l = low + std::size_t(voxel) * 8;
      const VoxelSums s = low ? VoxelSums{l[0], l[1], l[2], l[4], l[5], l[6]} : sums.at(voxel);
      for (int i = 0; i < 3; ++i) {
        out.light[k][i] = static_cast<float>(static_cast<double>(s[i]) * unit);
        out.towards[k][i] = static_cast<float>(static_cast<double>(s[3 + i]) * unit);
      }
      if ((s[0] | s[1] | s[2]) == 0) continue;
      lit = true;
      if (!flat.attenuates) continue;
      const kernels::Float3 a = flat.opticsAt({x, y, z}).attenuation;
      for (int i = 0; i < 3; ++i) loss[i] += static_cast<double>(a[i]) * static_cast<double>(s[i]) * watts;
    }
    return lit;
  }

  PhotonResult finish() {
    const Vec3i& dims = mMedium.domain().dims;
    auto bricks = std::make_shared<RadianceBricks>();
    bricks->caustic = BrickGrid<Vec3f>(dims, {0, 0, 0});
    BrickGrid<Vec3f> causticDirection(dims, {0, 0, 0});
    timed("sorting far light", [&] { mTracer->finish(); });
    const Rgb depositedLoss = timed("sums", [&] { return merge(bricks->caustic, causticDirection); });
    EnergyBalance balance = balanceOfTallies();
    balance.depositedLoss = depositedLoss;
    const std::uint64_t sumsBytes = mTracer->peakBytes();
    mTracer.reset();

    // All that is held from here on at once: these four, the mean direction, and one grid more while it is smoothed.
    mCtx.requireMemory(3 * bricks->caustic.memoryBytes() + causticDirection.memoryBytes() +
                           2 * mDirect.fluence.memoryBytes() + mDirect.direction.memoryBytes(),
                       "photons: light volumes");
    if (mOptions.smooth)
      timed("smoothing", [&] {
        bricks->caustic = smoothed(bricks->caustic, mCtx);
        causticDirection = smoothed(causticDirection, mCtx);
        const std::vector<std::int64_t> edges = directEdges();
        smoothSome(mDirect.fluence, edges, mCtx);
        smoothSome(mDirect.direction, edges, mCtx);
      });
    bricks->direct = std::move(mDirect.fluence);
    timed("direction", [&] { bricks->direction = meanDirection(*bricks, causticDirection, mDirect.direction); });
    return {RadianceVolume(mMedium.domain(), bricks), balance, std::move(mParts), sumsBytes};
  }

  /// Bricks where direct light has an edge, or neighbours that see other lights. Elsewhere it is smooth by itself.
  [[nodiscard]] std::vector<std::int64_t> directEdges() const {
    const BrickGrid<Vec3f>& grid = mDirect.fluence;
    const Vec3i n = grid.brickDims();
    std::vector<std::int64_t> edges;
    if (mDirect.covers.empty()) return edges;
    for (std::int64_t b = 0; b < grid.brickCount(); ++b) {
      const Vec3i c = grid.brickCoord(b);
      bool edge = mDirect.covers[b] == DirectLight::kEdge;
      for (int i = 0; i < 27 && !edge; ++i) {
        const Vec3i o{c[0] + i / 9 - 1, c[1] + i / 3 % 3 - 1, c[2] + i % 3 - 1};
        if (o[0] < 0 || o[1] < 0 || o[2] < 0 || o[0] >= n[0] || o[1] >= n[1] || o[2] >= n[2]) continue;
        edge = mDirect.covers[grid.brickIndex(o)] != mDirect.covers[b];
      }
      if (edge) edges.push_back(b);
    }
    return edges;
  }

  /// (sum of luminance * direction) / (sum of luminance) over both parts of the light.
  [[nodiscard]] BrickGrid<Vec3f> meanDirection(const RadianceBricks& light, const BrickGrid<Vec3f>& causticSum,
                                               const BrickGrid<Vec3f>& directSum) const {
    BrickGrid<Vec3f> mean(light.caustic.dims(), {0, 0, 0});
    const auto divide = [](const Vec3f& a, const Vec3f& b, const Vec3f& fa, const Vec3f& fb) -> Vec3f {
      const float l = kernels::luminance(kernels::Float3(fa[0] + fb[0], fa[1] + fb[1], fa[2] + fb[2]));
      if (!(l > 0)) return {0, 0, 0};
      const kernels::Float3 d(kernels::Float3(a[0] + b[0], a[1] + b[1], a[2] + b[2]) * (1 / l));
      const float squared = kernels::dot(d, d);
      const float s = squared > 1 ? 1 / std::sqrt(squared) : 1; // rounding may carry a beam beyond 1
      return {d.x * s, d.y * s, d.z * s};
    };
    // A brick as a step through its voxels, or no step through its one value.
    struct Brick {
      const Vec3f* values;
      int step;
      Brick(const BrickGrid<Vec3f>& g, std::int64_t b)
          : values(g.isConstant(b) ? &g.constant(b) : g.voxels(b).data()), step(g.isConstant(b) ? 0 : 1) {}
      const Vec3f& operator[](int k) const { return values[k * step]; }
    };
    std::vector<std::int64_t> varying;
    for (std::int64_t b = 0; b < mean.brickCount(); ++b)
      if (causticSum.isConstant(b) && directSum.isConstant(b) && light.caustic.isConstant(b) &&
          light.direct.isConstant(b))
        mean.setConstant(b, divide(causticSum.constant(b), directSum.constant(b), light.caustic.constant(b),
                                   light.direct.constant(b)));
      else
        varying.push_back(b);
    mean.activate(varying, Fill::Later);
    parallelFor(static_cast<std::int64_t>(varying.size()), 16, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) {
        const Brick a(causticSum, varying[i]), b(directSum, varying[i]), fa(light.caustic, varying[i]),
            fb(light.direct, varying[i]);
        const auto out = mean.voxels(varying[i]);
        for (int k = 0; k < kBrickVoxels; ++k) out[k] = divide(a[k], b[k], fa[k], fb[k]);
      }
    });
    return mean;
  }

  [[nodiscard]] EnergyBalance balanceOfTallies() const {
    EnergyBalance e;
    const PhotonTally tally = mTracer->tally();
    const auto watts = [&](Outcome o) {
      const auto& t = tally.power[static_cast<int>(o)];
      return Rgb{static_cast<double>(t[0]) / mScale.tally, static_cast<double>(t[1]) / mScale.tally,
                 static_cast<double>(t[2]) / mScale.tally};
    };
    const auto total = [&](Counter c) { return tally.counts[static_cast<int>(c)]; };
    e.emitted = watts(Outcome::Emitted);
    e.absorbed = watts(Outcome::Absorbed);
    e.scattered = watts(Outcome::Scattered);
    e.escaped = watts(Outcome::Escaped);
    e.received = watts(Outcome::Received);
    e.cutOff = watts(Outcome::CutOff);
    e.tracedLoss = watts(Outcome::TracedLoss);
    e.photonsEmitted = total(Counter::Emitted);
    e.photonsTraced = total(Counter::Traced);
    e.photonsAtStepLimit = total(Counter::StepLimit);
    e.photonsNotFinite = total(Counter::NotFinite);
    e.steps = total(Counter::Steps);
    e.voxelsCrossed = total(Counter::VoxelsCrossed);
    return e;
  }

  const Medium& mMedium;
  std::span<const Light> mLights;
  const PhotonOptions& mOptions;
  const RunContext& mCtx;
  const FlatMediumStorage& mFlat;
  std::vector<NumberedFrame> mFrames;
  FixedPoint mScale;
  double mTraced = 0, mTracing = 1; ///< fractions of all rows: done, and in the strip that is traced
  std::vector<PassPart> mParts;
  std::unique_ptr<PhotonTracer> mTracer;
  DirectLight mDirect;
};

void check(const PhotonOptions& o) {
  if (o.grid[0] < 1 || o.grid[1] < 1)
    throw Error(ErrorKind::Usage, "photons.grid: needs at least one photon along each side");
  if (static_cast<std::int64_t>(o.grid[0]) * o.grid[1] > 0xffffffffll)
    throw Error(ErrorKind::Usage, "photons.grid: at most 2^32 photons for a light");
  if (!(o.minStep > 0) || !(o.maxStep >= o.minStep))
    throw Error(ErrorKind::Usage, "photons.minStep: must be above 0 and at most photons.maxStep");
  if (o.maxSteps < 1) throw Error(ErrorKind::Usage, "photons.maxSteps: must be at least 1");
  if (!(o.cutoff >= 0 && o.cutoff < 1)) throw Error(ErrorKind::Usage, "photons.cutoff: must be in [0, 1)");
}

} // namespace

double EnergyBalance::relativeImbalance() const {
  double worst = 0;
  for (int c = 0; c < 3; ++c)
    if (emitted[c] > 0)
      worst = std::max(worst, std::abs(emitted[c] - absorbed[c] - scattered[c] - escaped[c] - received[c] - cutOff[c]) /
                                  emitted[c]);
  return worst;
}

PhotonResult tracePhotons(const Medium& medium, const FlatMediumStorage& flat, std::span<const Light> lights,
                          const PhotonOptions& options, const RunContext& ctx, std::shared_ptr<TracerState> state) {
  check(options);
  return PhotonPass(medium, flat, lights, options, ctx, std::move(state)).run();
}

PhotonResult tracePhotons(const Medium& medium, std::span<const Light> lights, const StepFieldOptions& stepField,
                          const PhotonOptions& options, const RunContext& ctx) {
  return tracePhotons(medium, flattenMedium(medium, stepField, ctx), lights, options, ctx);
}

} // namespace volcaustic
