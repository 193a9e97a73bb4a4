// The photon pass: emission, march, merge, direct light, smoothing (docs/algorithms/photons.md).

#include "volcaustic/photons.h"

#include "backends/cpu.h"
#include "kernels/photon.h"
#include "transport/accumulators.h"
#include "transport/direct.h"
#include "transport/emission.h"
#include "transport/march_rules.h"
#include "transport/passes.h"
#include "transport/smooth.h"
#include "volume/radiance_bricks.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

using kernels::Counter;
using kernels::EmissionFrame;
using kernels::Outcome;

constexpr std::int64_t kEmissionGrain = 4096; // raster cells for one task
constexpr std::int64_t kPhotonGrain = 256;    // photons for one task: a stretch of a raster row

struct NumberedFrame {
  int light;
  EmissionFrame frame;
};

/// Upper bound of what the rasters can emit in one channel, W.
double powerBound(std::span<const NumberedFrame> frames) {
  double watts = 0;
  for (const auto& [light, f] : frames)
    watts +=
        kernels::maxComponent(f.strength) * (f.point ? 4 * 3.14159265358979323846 : static_cast<double>(f.cells()));
  return watts;
}

class PhotonPass {
public:
  PhotonPass(const Medium& medium, const FlatMediumStorage& flat, std::span<const Light> lights,
             const PhotonOptions& options, const RunContext& ctx)
      : mMedium(medium)
      , mLights(lights)
      , mOptions(options)
      , mCtx(ctx)
      , mFlat(flat)
      , mFrames(allFrames())
      , mRules(powerBound(mFrames), ctx.effectiveMemoryLimit())
      , mDirect{BrickGrid<Vec3f>(medium.domain().dims, {0, 0, 0}), BrickGrid<Vec3f>(medium.domain().dims, {0, 0, 0})} {
    for (int i = 0; i < threadCount(ctx); ++i) mSinks.emplace_back(mFlat.brickDims, mRules);
  }

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

  void traceFrame(int number) {
    const auto& [light, frame] = mFrames[number];
    mCtx.requireMemory(static_cast<std::uint64_t>(frame.cells()) * 2 * sizeof(float), "photons.grid");
    std::vector<float> entry(frame.cells());
    const kernels::EmissionBody<CpuSink> emission{mFlat.view(), frame, entry.data()};
    launchCpu(frame.cells(), kEmissionGrain, mCtx, {}, emission, std::span(mSinks));

    std::vector<std::uint32_t> cells;
    for (std::int64_t i = 0; i < frame.cells(); ++i)
      if (entry[i] != kernels::kNeverBends) cells.push_back(static_cast<std::uint32_t>(i));

    const kernels::PhotonBody<CpuSink> photons{mFlat.view(), frame, entry.data(), cells.data(), rules()};
    RunContext ctx = mCtx;
    if (mCtx.onProgress)
      ctx.onProgress = [&](std::string_view stage, double f) {
        mCtx.onProgress(stage, (number + f) / static_cast<double>(mFrames.size()));
      };
    launchCpu(static_cast<std::int64_t>(cells.size()), kPhotonGrain, ctx, "photons", photons, std::span(mSinks));

    addDirectLight(mDirect, mFlat, mMedium.domain(), mLights[light], frame, entry, mCtx);
  }

  [[nodiscard]] kernels::PhotonRules rules() const {
    return {marchRules(mOptions), mOptions.maxSteps, static_cast<float>(mOptions.cutoff), mOptions.roulette, mCtx.seed};
  }

  /// Fixed-point sums to fluence, brick by brick; the caustic's direction sums go to `direction`.
  void merge(BrickGrid<Vec3f>& caustic, BrickGrid<Vec3f>& direction) {
    std::vector<std::int64_t> touched;
    for (std::int64_t b = 0; b < caustic.brickCount(); ++b)
      if (std::any_of(mSinks.begin(), mSinks.end(), [&](const CpuSink& s) { return s.brick(b) != nullptr; }))
        touched.push_back(b);
    mCtx.requireMemory(touched.size() * 2 * kBrickVoxels * sizeof(Vec3f), "photons: caustic light");
    caustic.activate(touched);
    direction.activate(touched);
    // Sums are W*voxel; fluence is their world length over the voxel's volume.
    const double h = mMedium.domain().voxelSize, unit = 1 / (mRules.depositScale * h * h);
    parallelFor(static_cast<std::int64_t>(touched.size()), 16, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) {
        const auto light = caustic.voxels(touched[i]), towards = direction.voxels(touched[i]);
        for (int k = 0; k < kBrickVoxels; ++k) {
          std::array<std::int64_t, kSums> sums{};
          for (const CpuSink& sink : mSinks)
            if (const AccumulatorBrick* brick = sink.brick(touched[i]))
              for (int c = 0; c < kSums; ++c) sums[c] += (*brick)[k][c];
          for (int c = 0; c < 3; ++c) {
            light[k][c] = static_cast<float>(static_cast<double>(sums[c]) * unit);
            towards[k][c] = static_cast<float>(static_cast<double>(sums[3 + c]) * unit);
          }
        }
      }
    });
  }

  PhotonResult finish() {
    const Vec3i& dims = mMedium.domain().dims;
    auto bricks = std::make_shared<RadianceBricks>();
    bricks->caustic = BrickGrid<Vec3f>(dims, {0, 0, 0});
    BrickGrid<Vec3f> causticDirection(dims, {0, 0, 0});
    merge(bricks->caustic, causticDirection);
    const EnergyBalance balance = balanceOf(bricks->caustic);
    mSinks.clear();

    if (mOptions.smooth) {
      bricks->caustic = smoothed(bricks->caustic, mCtx);
      causticDirection = smoothed(causticDirection, mCtx);
      mDirect.fluence = smoothed(mDirect.fluence, mCtx);
      mDirect.direction = smoothed(mDirect.direction, mCtx);
    }
    bricks->direct = std::move(mDirect.fluence);
    bricks->direction = meanDirection(*bricks, causticDirection, mDirect.direction);
    return {RadianceVolume(mMedium.domain(), bricks), balance};
  }

  /// (sum of luminance * direction) / (sum of luminance) over both parts of the light.
  [[nodiscard]] BrickGrid<Vec3f> meanDirection(const RadianceBricks& light, const BrickGrid<Vec3f>& causticSum,
                                               const BrickGrid<Vec3f>& directSum) const {
    BrickGrid<Vec3f> mean(light.caustic.dims(), {0, 0, 0});
    const auto divide = [](const Vec3f& a, const Vec3f& b, const Vec3f& fa, const Vec3f& fb) -> Vec3f {
      const float l = kernels::luminance(kernels::Float3(fa[0] + fb[0], fa[1] + fb[1], fa[2] + fb[2]));
      if (!(l > 0)) return {0, 0, 0};
      const kernels::Float3 d(kernels::Float3(a[0] + b[0], a[1] + b[1], a[2] + b[2]) * (1 / l));
      const float len = kernels::length(d);
      const float s = len > 1 ? 1 / len : 1; // rounding may carry a beam beyond 1
      return {d.x * s, d.y * s, d.z * s};
    };
    const auto at = [](const BrickGrid<Vec3f>& g, std::int64_t b, int k) {
      return g.isConstant(b) ? g.constant(b) : g.voxels(b)[k];
    };
    std::vector<std::int64_t> varying;
    for (std::int64_t b = 0; b < mean.brickCount(); ++b)
      if (causticSum.isConstant(b) && directSum.isConstant(b) && light.caustic.isConstant(b) &&
          light.direct.isConstant(b))
        mean.setConstant(b, divide(causticSum.constant(b), directSum.constant(b), light.caustic.constant(b),
                                   light.direct.constant(b)));
      else
        varying.push_back(b);
    mean.activate(varying);
    parallelFor(static_cast<std::int64_t>(varying.size()), 16, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) {
        const std::int64_t b = varying[i];
        for (int k = 0; k < kBrickVoxels; ++k)
          mean.voxels(b)[k] =
              divide(at(causticSum, b, k), at(directSum, b, k), at(light.caustic, b, k), at(light.direct, b, k));
      }
    });
    return mean;
  }

  [[nodiscard]] EnergyBalance balanceOf(const BrickGrid<Vec3f>& caustic) const {
    EnergyBalance e;
    const auto watts = [&](Outcome o) {
      std::array<std::int64_t, 3> t{};
      for (const CpuSink& s : mSinks)
        for (int c = 0; c < 3; ++c) t[c] += s.tallies(o)[c];
      return Rgb{static_cast<double>(t[0]) / mRules.tallyScale, static_cast<double>(t[1]) / mRules.tallyScale,
                 static_cast<double>(t[2]) / mRules.tallyScale};
    };
    const auto total = [&](Counter c) {
      std::int64_t n = 0;
      for (const CpuSink& s : mSinks) n += s.counts(c);
      return n;
    };
    e.emitted = watts(Outcome::Emitted);
    e.absorbed = watts(Outcome::Absorbed);
    e.scattered = watts(Outcome::Scattered);
    e.escaped = watts(Outcome::Escaped);
    e.received = watts(Outcome::Received);
    e.cutOff = watts(Outcome::CutOff);
    e.tracedLoss = watts(Outcome::TracedLoss);
    e.depositedLoss = lossInVolume(caustic);
    e.photonsEmitted = total(Counter::Emitted);
    e.photonsTraced = total(Counter::Traced);
    e.photonsAtStepLimit = total(Counter::StepLimit);
    e.photonsNotFinite = total(Counter::NotFinite);
    e.steps = total(Counter::Steps);
    e.voxelsCrossed = total(Counter::VoxelsCrossed);
    return e;
  }

  /// Sum of attenuation * fluence * voxel volume, brick by brick in their order.
  [[nodiscard]] Rgb lossInVolume(const BrickGrid<Vec3f>& caustic) const {
    const kernels::FlatMedium flat = mFlat.view();
    const double h = mMedium.domain().voxelSize, volumePerVoxel = h * h; // attenuation is in 1/voxel: h^3 * (1/h)
    Rgb loss{0, 0, 0};
    for (std::int64_t b = 0; b < caustic.brickCount(); ++b) {
      if (caustic.isConstant(b)) continue;
      const Vec3i c = caustic.brickCoord(b);
      for (int k = 0; k < kBrickVoxels; ++k) {
        const kernels::Int3 v{c[0] * 8 + (k >> 6), c[1] * 8 + ((k >> 3) & 7), c[2] * 8 + (k & 7)};
        if (v.x >= flat.dims.x || v.y >= flat.dims.y || v.z >= flat.dims.z) continue;
        const kernels::Float3 a = flat.opticsAt(v).attenuation;
        const Vec3f& f = caustic.voxels(b)[k];
        for (int i = 0; i < 3; ++i) loss[i] += static_cast<double>(a[i]) * f[i] * volumePerVoxel;
      }
    }
    return loss;
  }

  const Medium& mMedium;
  std::span<const Light> mLights;
  const PhotonOptions& mOptions;
  const RunContext& mCtx;
  const FlatMediumStorage& mFlat;
  std::vector<NumberedFrame> mFrames;
  SinkRules mRules;
  std::vector<CpuSink> mSinks;
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
                          const PhotonOptions& options, const RunContext& ctx) {
  check(options);
  return PhotonPass(medium, flat, lights, options, ctx).run();
}

PhotonResult tracePhotons(const Medium& medium, std::span<const Light> lights, const StepFieldOptions& stepField,
                          const PhotonOptions& options, const RunContext& ctx) {
  return tracePhotons(medium, flattenMedium(medium, stepField, ctx), lights, options, ctx);
}

} // namespace volcaustic
