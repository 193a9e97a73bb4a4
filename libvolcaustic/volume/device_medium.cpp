#include "volume/device_medium.h"

#include "backends/devices.h"
#include "core/parallel.h"
#include "volcaustic/error.h"
#include "volume/medium_store.h"
#include "volume/optics.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace volcaustic {

namespace {

kernels::Float3 toFloat3(const Rgb& c) {
  return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
}
kernels::Int3 toInt3(const Vec3i& v) { return {v[0], v[1], v[2]}; }

template <class Optics> // Material or Ambient
kernels::PointOptics pointOf(const Optics& o) {
  return {static_cast<float>(o.index), 0, toFloat3(o.attenuation), toFloat3(o.scattering),
          static_cast<float>(o.asymmetry)};
}

/// Triangles from which on `auto` takes the GPU. Below, the CPU's lanes take a few milliseconds, no more than starting
/// some dozens of kernels and copying the arrays back.
constexpr std::size_t kLeastTriangles = 20000;

/// The GPU that ctx.device means for meshes of this size; without one, cudaOrdinal is -1.
DeviceChoice chooseFor(std::span<const Body> bodies, const RunContext& ctx) {
  std::size_t triangles = 0;
  for (const Body& body : bodies) triangles += body.mesh ? body.mesh->triangles.size() : 0;
  // No driver is woken up for small meshes.
  if (triangles < kLeastTriangles && parseDevice(ctx.device).kind == DeviceRequest::Kind::Auto) return {};
  RunContext quiet = ctx; // the photon pass tells what was chosen
  quiet.onLog = {};
  return chooseDevice(quiet);
}

/// Calls work(); when the device fails and the choice allows it, warns and returns nothing.
template <class Work>
auto orFallBack(bool mayFallBack, const RunContext& ctx, const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Device || !mayFallBack) throw;
    ctx.warn(std::string(e.what()) + "; going on with the CPU");
    return {};
  }
}

void addBody(DeviceMediumBuilder& builder, const Body& body, const Domain& domain, const VoxeliseOptions& options,
             const RunContext& ctx) {
  if (!body.shape.empty()) {
    const CoveragePatch patch = voxeliseBody(body, domain, options.supersample, options.fill, ctx);
    // Its coverage has no steps of its own: those of the counts are to be fine.
    constexpr int kFinestCounts = 8;
    builder.add(countsOf(patch, kFinestCounts), pointOf(body.material));
    return;
  }
  const SampledBody sampled(body, domain, options.supersample, options.fill, ctx);
  const kernels::PointOptics optics = pointOf(body.material);
  if (!sampled.closed())
    builder.add(countsOf(sampled.cover(ctx), options.supersample), optics);
  else if (!sampled.reachesDomain() || !builder.add(sampled.task(), sampled.firstBrick(), optics, ctx))
    sampled.warnOfNothing(ctx);
}

} // namespace

kernels::PointOptics pointOptics(const Material& material) { return pointOf(material); }
kernels::PointOptics pointOptics(const Ambient& ambient) { return pointOf(ambient); }

MediumPlan planOf(const Domain& domain, const Ambient& ambient, std::span<const Body> bodies, int blur) {
  return {toInt3(domain.dims), pointOptics(ambient), changedGrids(ambient, bodies), blur, gaussianWeights(blur)};
}

kernels::StepRules stepRules(const StepFieldOptions& options, const Domain& domain) {
  return {domain.voxelSize, options.indexTolerance, options.indexTolerance2, options.attenuationTolerance};
}

BodyCounts countsOf(const CoveragePatch& patch, int supersample) {
  using kernels::BrickFill;
  const BrickGrid<float>& coverage = patch.coverage;
  BodyCounts result{toInt3(patch.firstBrick), toInt3(coverage.brickDims()), 0, {}, {}, {}};
  while (1 << result.log2 < supersample) ++result.log2;
  const auto samples = static_cast<float>(supersample * supersample * supersample);
  const auto countOf = [samples](float c) { return static_cast<std::uint16_t>(std::lround(c * samples)); };
  std::uint32_t counted = 0;
  for (std::int64_t b = 0; b < coverage.brickCount(); ++b) {
    const bool constant = coverage.isConstant(b);
    const float c = constant ? coverage.constant(b) : 0;
    const bool whole = constant && (c == 0 || c == 1);
    result.fills.push_back(!whole ? BrickFill::Counted : c == 0 ? BrickFill::Empty : BrickFill::Full);
    result.counted.push_back(counted);
    if (whole) continue;
    ++counted;
    if (constant)
      result.counts.insert(result.counts.end(), kBrickVoxels, countOf(c));
    else
      std::ranges::transform(coverage.voxels(b), std::back_inserter(result.counts), countOf);
  }
  result.counted.push_back(counted);
  return result;
}

std::shared_ptr<const DeviceBricks> mediumOnDevice(std::span<const Body> bodies, const Ambient& ambient,
                                                   const Domain& domain, const VoxeliseOptions& options,
                                                   const RunContext& ctx) {
  const DeviceChoice choice = chooseFor(bodies, ctx);
  if (choice.cudaOrdinal < 0) return nullptr;
  return orFallBack(choice.mayFallBack, ctx, [&] {
    const std::unique_ptr<DeviceMediumBuilder> builder =
        makeCudaMediumBuilder(ctx.effectiveMemoryLimit(), choice.cudaOrdinal);
    for (std::size_t i = 0; i < bodies.size(); ++i)
      addBody(*builder, bodies[i], domain, options, shareOf(ctx, i, bodies.size()));
    auto bricks = builder->finish(planOf(domain, ambient, bodies, options.blur));
    ctx.progress("blend", 1);
    return bricks;
  });
}

std::optional<FlatMediumStorage> flattenOnDevice(const Medium& medium, const StepFieldOptions& options,
                                                 const RunContext& ctx) {
  const std::shared_ptr<const DeviceBricks> bricks = medium.store().onDevice();
  const DeviceRequest::Kind asked = parseDevice(ctx.device).kind;
  if (!bricks || asked == DeviceRequest::Kind::Cpu) return {};
  return orFallBack(asked == DeviceRequest::Kind::Auto, ctx, [&] {
    return std::optional(bricks->flatten(stepRules(options, medium.domain()), static_cast<float>(options.cap), ctx));
  });
}

} // namespace volcaustic
