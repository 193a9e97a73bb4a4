// The photon pass: emission, march, merge, direct light, smoothing (docs/algorithms/photons.md).

#include "volcaustic/photons.h"

#include "backends/lanes.h"
#include "backends/photon_tracer.h"
#include "core/large_memory.h"
#include "core/parallel.h"
#include "transport/caustic.h"
#include "transport/direct.h"
#include "transport/emission.h"
#include "transport/lit_receivers.h"
#include "transport/march_rules.h"
#include "transport/passes.h"
#include "transport/reach.h"
#include "transport/separate_lights.h"
#include "transport/soft_lights.h"
#include "transport/tracers.h"
#include "volcaustic/error.h"
#include "volume/radiance_bricks.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <type_traits>

namespace volcaustic {

namespace {

using kernels::Counter;
using kernels::EmissionFrame;
using kernels::Outcome;

struct NumberedFrame {
  int light; ///< among the parts
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
  PhotonPass(const Medium& medium, const FlatMediumStorage& flat, std::span<const LightPart> lights,
             std::span<const Receiver> receivers, const PhotonOptions& options, const RunContext& ctx,
             std::shared_ptr<TracerState> state)
      : mMedium(medium)
      , mLights(lights)
      , mOptions(options)
      , mCtx(ctx)
      , mFlat(flat)
      , mReceivers(receivers, medium.domain(), ctx)
      , mReceiverScene(mReceivers.scene())
      , mReceived(mReceivers, medium.domain(), medium.ambient(), ctx)
      , mFrames(allFrames())
      , mScale(fixedPoint(mFrames))
      , mTracer(makeTracer({flat.view(), rules(), mScale, flat.onDevice}, tracerContext(), std::move(state)))
      , mDirect(flat, medium.domain(), lights, ctx) {}

  PhotonResult run() {
    for (std::size_t i = 0; i < mFrames.size(); ++i) traceFrame(static_cast<int>(i));
    return finish();
  }

private:
  [[nodiscard]] std::vector<NumberedFrame> allFrames() const {
    std::vector<NumberedFrame> frames;
    for (std::size_t i = 0; i < mLights.size(); ++i) {
      const auto& [light, number, part, share] = mLights[i];
      PhotonOptions own = mOptions;
      for (int& side : own.grid) side = std::max(1, static_cast<int>(std::lround(side * std::sqrt(share))));
      for (const EmissionFrame& f :
           emissionFrames(light, number, mMedium.domain(), own, mCtx.seed + part * 0x9e3779b9u))
        frames.push_back({static_cast<int>(i), f});
    }
    return frames;
  }

  /// Raster by raster, each in strips of rows: what a tracer keeps for its photons stays small, and a run of hours can
  /// tell how far it is.
  void traceFrame(int number) {
    const auto& [light, frame] = mFrames[number];
    mCtx.requireMemory(static_cast<std::uint64_t>(frame.cells()) * sizeof(float), "photons.grid");
    LargeVector<float> entry(frame.cells()), stops; // every cell is written
    std::vector<kernels::Landing> landings;
    RasterCells cells(entry.data());
    if (mReceiverScene.any()) {
      mCtx.requireMemory(static_cast<std::uint64_t>(frame.cells()) * (2 * sizeof(float) + sizeof(kernels::Landing)),
                         "photons.grid");
      stops.resize(frame.cells());
      landings.resize(frame.cells());
      cells = {entry.data(), stops.data(), landings.data()};
      timed("receivers", [&] { findStops(frame, stops.data()); });
    }
    const ReachMap reach = timed("reach", [&] { return reachOf(mFlat, frame, mCtx); });
    constexpr std::int64_t kStripCells = 1 << 22;
    const std::int64_t tiles = std::max<std::int64_t>(kStripCells / frame.columns / kernels::kReachTile, 1);
    const auto strip = static_cast<std::int32_t>(std::min<std::int64_t>(tiles * kernels::kReachTile, frame.rows));
    for (RowRange rows{0, strip}; rows.begin < frame.rows; rows = {rows.end, rows.end + strip}) {
      rows.end = std::min(rows.end, frame.rows);
      const double all = static_cast<double>(mFrames.size()) * frame.rows;
      mTraced = static_cast<double>(number) / static_cast<double>(mFrames.size()) + rows.begin / all;
      mTracing = (rows.end - rows.begin) / all;
      timed("emission", [&] { mTracer->emit(frame, reach.view(), rows, cells); });
      timed("photons", [&] { mTracer->trace(frame, rows, cells); });
    }
    if (mReceiverScene.any()) {
      timed("photons", [&] { mTracer->wait(); });
      timed("receivers", [&] {
        mReceived.addDirect(mLights[light], frame, entry);
        mReceived.addLandings(frame, landings);
      });
      // From here on light ends at receivers as at bends.
      for (std::size_t i = 0; i < entry.size(); ++i) entry[i] = std::min(entry[i], stops[i]);
    }
    timed("direct light", [&] { mDirect.add(light, frame, entry); });
  }

  /// Where the rays of a raster first meet a receiver.
  void findStops(const EmissionFrame& frame, float* stops) const {
    const LaneSet& lanes = laneSet(parseDevice(mCtx.device).lanes);
    const kernels::RasterView view = kernels::rasterView(frame);
    parallelFor(frame.rows, 8, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      lanes.findStops(
          {mReceiverScene, frame, view, {static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end)}, stops});
    });
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
    return {marchRules(mOptions), mOptions.maxSteps, static_cast<float>(mOptions.cutoff), mOptions.roulette, mCtx.seed,
            mOptions.fresnel,     mReceiverScene};
  }

  PhotonResult finish() {
    const Domain& domain = mMedium.domain();
    auto light = std::make_shared<RadianceBricks>(domain.dims);
    timed("direct light", [&] { mDirect.finish(mOptions.smooth, light->direct); });
    timed("sorting far light", [&] { mTracer->finish(); });
    const Rgb depositedLoss = timed("caustic light", [&] {
      RunContext ctx = mCtx; // what the sums and direct light take already is no longer free
      const std::uint64_t limit = mCtx.effectiveMemoryLimit();
      ctx.memoryLimit = limit - std::min(limit - 1, mTracer->peakBytes() + light->direct.stored.memoryBytes());
      return gatherCaustic(*mTracer, mFlat, domain.voxelSize, mScale, mOptions.smooth, light->caustic, ctx);
    });
    EnergyBalance balance = balanceOfTallies();
    balance.depositedLoss = depositedLoss;
    const std::uint64_t peakBytes = mTracer->peakBytes();
    return {RadianceVolume(domain, std::move(light)), litReceivers(), balance, std::move(mParts), peakBytes};
  }

  LitReceivers litReceivers() {
    if (!mReceiverScene.any()) return {};
    ReceivedLight light = timed("receivers", [&] {
      for (std::size_t i = 0; i < mLights.size(); ++i)
        if (std::none_of(mFrames.begin(), mFrames.end(), [i](const NumberedFrame& f) { return f.light == int(i); }))
          mReceived.addDirect(mLights[i], {}, {}); // a light that does not shine into the box
      return mReceived.finish();
    });
    return LitReceivers(std::make_shared<const LitReceiverData>(std::move(mReceivers), std::move(light)));
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
  std::span<const LightPart> mLights;
  const PhotonOptions& mOptions;
  const RunContext& mCtx;
  const FlatMediumStorage& mFlat;
  ReceiverSet mReceivers;
  const kernels::ReceiverScene mReceiverScene; ///< without their light
  ReceiverLight mReceived;
  std::vector<NumberedFrame> mFrames;
  FixedPoint mScale;
  double mTraced = 0, mTracing = 1; ///< fractions of all rows: done, and in the strip that is traced
  std::vector<PassPart> mParts;
  std::unique_ptr<PhotonTracer> mTracer;
  DirectLightBuilder mDirect;
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

std::vector<ReceiverMap> LitReceivers::maps() const {
  if (!mData) return {};
  return mData->set.maps(mData->light.caustic, mData->light.direct);
}

PhotonResult tracePhotons(const Medium& medium, const FlatMediumStorage& flat, std::span<const Light> lights,
                          std::span<const Receiver> receivers, const PhotonOptions& options, const RunContext& ctx,
                          std::shared_ptr<TracerState> state) {
  check(options);
  const std::vector<LightPart> parts = partsOf(lights, ctx);
  if (!options.separate) return PhotonPass(medium, flat, parts, receivers, options, ctx, std::move(state)).run();
  const std::vector<std::string> names = lightLayers(lights);
  std::vector<PhotonResult> each;
  for (int i = 0; i < static_cast<int>(lights.size()); ++i) {
    std::vector<LightPart> own;
    std::copy_if(parts.begin(), parts.end(), std::back_inserter(own),
                 [i](const LightPart& p) { return p.number == i; });
    const RunContext share = shareOf(ctx, i, static_cast<int>(lights.size()), each);
    each.push_back(PhotonPass(medium, flat, own, receivers, options, share, state).run());
    each.back().light = names[i];
  }
  return sumOf(std::move(each), medium.domain(), ctx);
}

PhotonResult tracePhotons(const Medium& medium, std::span<const Light> lights, const StepFieldOptions& stepField,
                          const PhotonOptions& options, const RunContext& ctx, std::span<const Receiver> receivers) {
  return tracePhotons(medium, flattenMedium(medium, stepField, ctx), lights, receivers, options, ctx);
}

} // namespace volcaustic
