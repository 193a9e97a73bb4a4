// The CUDA backend against the CPU's reference, one photon at a time, for the same rasters through the same media.

#include "backends/photon_tracer.h"
#include "kernels/view.h"
#include "parity/gpu_required.h"
#include "support/fields.h"
#include "support/solids.h"
#include "transport/emission.h"
#include "transport/hybrid.h"
#include "transport/march_rules.h"
#include "transport/reach.h"
#include "volcaustic/error.h"
#include "volume/flatten.h"

#include <cmath>
#include <cstring>
#include <cuda_runtime.h>
#include <gtest/gtest.h>
#include <vector>

namespace volcaustic::test {

using namespace volcaustic::kernels;
using volcaustic::Light; // not kernels::Light

namespace {

constexpr int kResolution = 64;

/// A medium, the rasters of its light, and everything a tracer is given.
struct ParityScene {
  FlatMediumStorage flat;
  std::vector<EmissionFrame> frames;
  PhotonRules rules;

  ParityScene(const Medium& medium, const Light& light, PhotonOptions options)
      : flat(flattenMedium(medium, {}, {})), frames(emissionFrames(light, 0, medium.domain(), options, 11)) {
    rules.march = marchRules(options);
    rules.maxSteps = options.maxSteps;
    rules.cutoff = static_cast<float>(options.cutoff);
    rules.seed = 11;
  }

  [[nodiscard]] std::int64_t blocks() const {
    const Int3 n = blockDims(flat.dims);
    return std::int64_t{n.x} * n.y * n.z;
  }
  [[nodiscard]] TracerSetup setup() const {
    double photon = 0;
    for (const EmissionFrame& f : frames)
      photon = std::max(photon, maxComponent(f.strength) * (f.point ? f.du * f.dv : 1));
    return {flat.view(), rules, {std::ldexp(1.0, 15 - std::ilogb(photon)), std::ldexp(1.0, 40)}};
  }
};

PhotonOptions raster(int columns, int rows) {
  PhotonOptions options;
  options.grid = {columns, rows};
  return options;
}

/// A ball of red glass in fog, under slanting light.
ParityScene glassBall() {
  Ambient fog;
  fog.attenuation = {0.4, 0.5, 0.6};
  fog.scattering = {0.3, 0.3, 0.3};
  Body body;
  body.mesh = ball({0.5, 0.5, 0.55}, 0.3);
  body.material.index = 1.5;
  body.material.attenuation = {0.2, 2, 4};
  Light sun;
  sun.direction = {0.2, -0.1, -1};
  sun.irradiance = {3, 2, 1};
  return {buildMedium(std::span(&body, 1), fog, unitCube(kResolution)), sun, raster(253, 131)};
}

/// A lamp beside the ball of smooth_sphere, inside the box: the six faces of a cube.
ParityScene lampInside() {
  Light lamp;
  lamp.type = LightType::Point;
  lamp.position = {0.12, 0.2, 0.15};
  PhotonOptions options = raster(192, 192);
  options.jitter = true;
  return {sampleMedium(unitCube(kResolution), {}, indexField("smooth_sphere")), lamp, options};
}

ParityScene luneburg() {
  return {sampleMedium(unitCube(kResolution), {}, indexField("luneburg")), Light{}, raster(256, 256)};
}

struct Named {
  const char* name;
  ParityScene (*make)();
};
constexpr Named kScenes[] = {{"glassBall", glassBall}, {"lampInside", lampInside}, {"luneburg", luneburg}};

/// Emission and photons of rows [from, to) of every raster, as parts of each one's height.
void run(PhotonTracer& tracer, const ParityScene& scene, double from = 0, double to = 1) {
  for (const EmissionFrame& frame : scene.frames) {
    const ReachMap reach = reachOf(scene.flat, frame);
    std::vector<float> entry(static_cast<std::size_t>(frame.cells()));
    const RowRange rows{static_cast<std::int32_t>(std::lround(from * frame.rows)),
                        static_cast<std::int32_t>(std::lround(to * frame.rows))};
    tracer.emit(frame, reach.view(), rows, entry.data());
    tracer.trace(frame, rows, entry.data());
  }
  tracer.finish();
}

/// The sums of a block's voxels and of those around it.
std::vector<VoxelSums> lightOf(const PhotonTracer& tracer, std::int64_t block) {
  BlockSums sums;
  sums.clear();
  tracer.addBlock(block, sums);
  std::vector<VoxelSums> voxels(kSumsVoxels);
  for (int k = 0; k < kSumsVoxels; ++k) voxels[k] = sums.at(k);
  return voxels;
}

/// Sum of |a - b| over the sum of |a|, of everything that the photons left.
double relativeDifference(const PhotonTracer& a, const PhotonTracer& b, std::int64_t blocks) {
  double difference = 0, total = 0;
  for (std::int64_t i = 0; i < blocks; ++i) {
    const std::vector<VoxelSums> x = lightOf(a, i), y = lightOf(b, i);
    for (int k = 0; k < kSumsVoxels; ++k)
      for (int c = 0; c < kSums; ++c) {
        difference += std::abs(static_cast<double>(x[k][c] - y[k][c]));
        total += std::abs(static_cast<double>(x[k][c]));
      }
  }
  return difference / total;
}

/// Whether two tracers hold the same sums, bit for bit.
bool sameLight(const PhotonTracer& a, const PhotonTracer& b, std::int64_t blocks) {
  for (std::int64_t i = 0; i < blocks; ++i)
    if (lightOf(a, i) != lightOf(b, i)) return false;
  return true;
}

std::int64_t countOf(const PhotonTracer& tracer, Counter c) { return tracer.tally().counts[static_cast<int>(c)]; }

class Parity : public testing::TestWithParam<Named> {
protected:
  void SetUp() override { VOLCAUSTIC_NEED_GPU(); }
};

INSTANTIATE_TEST_SUITE_P(Scenes, Parity, testing::ValuesIn(kScenes),
                         [](const auto& scene) { return std::string(scene.param.name); });

} // namespace

// Both machines round differently (the GPU fuses multiply and add, and has an exponential of its own), so sums differ
// by rounding along the paths.
TEST_P(Parity, FluenceIsTheReferencesWithin1e4) {
  const ParityScene scene = GetParam().make();
  const auto cpu = makeCpuTracer(scene.setup(), {}, "scalar");
  const auto gpu = makeCudaTracer(scene.setup(), {}, 0);
  run(*cpu, scene);
  run(*gpu, scene);

  EXPECT_LE(relativeDifference(*cpu, *gpu, scene.blocks()), 1e-4);
  EXPECT_GT(countOf(*cpu, Counter::Traced), 1000);
  for (const Counter c : {Counter::Emitted, Counter::Traced, Counter::Steps})
    EXPECT_NEAR(static_cast<double>(countOf(*gpu, c)) / static_cast<double>(countOf(*cpu, c)), 1, 1e-4);
  EXPECT_EQ(countOf(*gpu, Counter::NotFinite), 0);
  EXPECT_EQ(countOf(*gpu, Counter::StepLimit), countOf(*cpu, Counter::StepLimit));
  const PhotonTally a = cpu->tally(), b = gpu->tally();
  const double emitted = static_cast<double>(a.power[static_cast<int>(Outcome::Emitted)][0]);
  for (std::size_t o = 0; o < a.power.size(); ++o)
    for (int c = 0; c < 3; ++c)
      EXPECT_LE(std::abs(static_cast<double>(a.power[o][c] - b.power[o][c])), 1e-4 * emitted) << o;
  EXPECT_GT(gpu->peakBytes(), 1u << 20);
}

TEST_P(Parity, TwoRunsGiveTheSameBits) {
  const ParityScene scene = GetParam().make();
  const auto once = makeCudaTracer(scene.setup(), {}, 0), again = makeCudaTracer(scene.setup(), {}, 0);
  run(*once, scene);
  run(*again, scene);
  EXPECT_TRUE(sameLight(*once, *again, scene.blocks()));
  EXPECT_EQ(once->tally().power, again->tally().power);
  EXPECT_EQ(once->tally().counts, again->tally().counts);
}

TEST_P(Parity, HybridIsExactlyTheSumOfItsParts) {
  const ParityScene scene = GetParam().make();
  constexpr double kShare = 0.37;
  const auto hybrid = makeHybridTracer(makeCpuTracer(scene.setup(), {}, ""), makeCudaTracer(scene.setup(), {}, 0),
                                       std::make_shared<HybridBalancer>(HybridBalancer::fixed(kShare)));
  const auto cpu = makeCpuTracer(scene.setup(), {}, "");
  const auto gpu = makeCudaTracer(scene.setup(), {}, 0);
  run(*hybrid, scene);
  run(*cpu, scene, 0, kShare);
  run(*gpu, scene, kShare, 1);
  for (std::int64_t b = 0; b < scene.blocks(); ++b) {
    BlockSums sums;
    sums.clear();
    cpu->addBlock(b, sums);
    gpu->addBlock(b, sums);
    const std::vector<VoxelSums> both = lightOf(*hybrid, b);
    for (int k = 0; k < kSumsVoxels; ++k) ASSERT_EQ(both[k], sums.at(k)) << b << " " << k;
  }
  PhotonTally tally = cpu->tally();
  tally += gpu->tally();
  EXPECT_EQ(hybrid->tally().power, tally.power);
  EXPECT_EQ(hybrid->tally().counts, tally.counts);
}

// Rows that another tracer emitted, and rows in any order, come to the same.
TEST_P(Parity, WhoEmitsAndInWhichOrderDoesNotMatter) {
  const ParityScene scene = GetParam().make();
  const EmissionFrame& frame = scene.frames.front();
  const std::int32_t fifth = frame.rows / 5, half = frame.rows / 2;
  const ReachMap reach = reachOf(scene.flat, frame);
  std::vector<float> entry(static_cast<std::size_t>(frame.cells())), copy = entry;
  const auto whole = makeCudaTracer(scene.setup(), {}, 0), parts = makeCudaTracer(scene.setup(), {}, 0);
  whole->emit(frame, reach.view(), {0, frame.rows}, entry.data());
  whole->trace(frame, {0, frame.rows}, entry.data());
  whole->finish();
  parts->emit(frame, reach.view(), {fifth, half}, copy.data());
  parts->trace(frame, {2 * fifth, frame.rows}, entry.data());
  parts->trace(frame, {0, 2 * fifth}, entry.data());
  parts->finish();
  EXPECT_TRUE(sameLight(*whole, *parts, scene.blocks()));
  for (int i = fifth * frame.columns; i < half * frame.columns; ++i) ASSERT_EQ(copy[i], entry[i]);
}

TEST_P(Parity, TooLittleMemoryIsOneErrorLine) {
  const ParityScene scene = GetParam().make();
  RunContext ctx;
  ctx.memoryLimit = 1;
  try {
    const auto gpu = makeCudaTracer(scene.setup(), ctx, 0);
    run(*gpu, scene);
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Device);
    EXPECT_NE(std::string(e.what()).find("out of memory"), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
  }
}

namespace {

/// Where a photon ends.
struct Exit {
  Float3 x, v, power;
  std::int32_t steps = -1;
};

/// A photon from its first bend to its end with the kernels' own steps; nothing is deposited.
VOLCAUSTIC_HD Exit carry(const FlatMedium& medium, const EmissionFrame& frame, const PhotonRules& rules,
                         std::int64_t cell, float entry) {
  Photon photon = startPhoton(medium, frame, rules, cell, entry);
  while (true) {
    PhotonMirror<float>* const none = nullptr;
    const StepOutcome<float> step = stepPhoton(medium, rules, photon, none, true, [](const ChordOf<float>&, bool) {});
    if (step.leaves || step.notFinite || step.limit) break;
  }
  return {photon.ray.x, photon.ray.v, photon.power, photon.steps};
}

__global__ void carryAll(FlatMedium medium, EmissionFrame frame, PhotonRules rules, const float* entry, Exit* exits) {
  const std::int64_t cell = blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (cell < frame.cells() && entry[cell] != kNeverBends) exits[cell] = carry(medium, frame, rules, cell, entry[cell]);
}

/// A copy of an array in device memory.
template <class T>
class OnDevice {
public:
  OnDevice(const T* from, std::int64_t count) : mBytes(std::max<std::int64_t>(count, 1) * sizeof(T)) {
    EXPECT_EQ(cudaMalloc(&mData, mBytes), cudaSuccess);
    if (from) EXPECT_EQ(cudaMemcpy(mData, from, count * sizeof(T), cudaMemcpyHostToDevice), cudaSuccess);
  }
  ~OnDevice() { cudaFree(mData); }
  OnDevice(const OnDevice&) = delete;
  OnDevice& operator=(const OnDevice&) = delete;
  [[nodiscard]] T* data() const { return mData; }
  [[nodiscard]] std::vector<T> read() const {
    std::vector<T> values(mBytes / sizeof(T));
    EXPECT_EQ(cudaMemcpy(values.data(), mData, mBytes, cudaMemcpyDeviceToHost), cudaSuccess);
    return values;
  }

private:
  T* mData = nullptr;
  std::size_t mBytes;
};

bool sameBits(const Float3& a, const Float3& b) {
  const float p[3] = {a.x, a.y, a.z}, q[3] = {b.x, b.y, b.z};
  return std::memcmp(p, q, sizeof p) == 0;
}

} // namespace

// Without fused multiply-add both machines round every sum, product, quotient and root of a path in the same way (IEEE
// 754), and a path has nothing else: each photon leaves with the same bits. Its power goes through the exponential,
// which the standard leaves to the machine: a few units in the last place for each step.
TEST_P(Parity, EveryPhotonLeavesWithTheSameBits) {
#if !defined(VOLCAUSTIC_PARITY)
  GTEST_SKIP() << "needs the preset parity: here the GPU fuses multiply and add";
#endif
  const ParityScene scene = GetParam().make();
  const FlatMedium m = scene.flat.view();
  const std::int64_t n = m.brickCount();
  const OnDevice<std::int32_t> fieldSlots(m.fieldSlots, n), stepSlots(m.stepSlots, n), opticsSlots(m.opticsSlots, n);
  const OnDevice<float> indexOffsets(m.indexOffsets, n);
  const OnDevice<FieldVoxel> fields(m.fields, m.fieldCount);
  const OnDevice<std::uint8_t> steps(m.steps, m.stepCount);
  const OnDevice<std::int32_t> voxelOptics(m.voxelOptics, m.voxelOpticsCount);
  const OnDevice<Optics> optics(m.optics, m.opticsCount);
  FlatMedium onDevice = m;
  onDevice.fieldSlots = fieldSlots.data();
  onDevice.stepSlots = stepSlots.data();
  onDevice.opticsSlots = opticsSlots.data();
  onDevice.indexOffsets = indexOffsets.data();
  onDevice.fields = fields.data();
  onDevice.steps = steps.data();
  onDevice.voxelOptics = voxelOptics.data();
  onDevice.optics = optics.data();
  onDevice.bends = nullptr; // of emission only

  const auto cpu = makeCpuTracer(scene.setup(), {}, "scalar");
  std::int64_t photons = 0;
  for (const EmissionFrame& frame : scene.frames) {
    const ReachMap reach = reachOf(scene.flat, frame);
    std::vector<float> entry(static_cast<std::size_t>(frame.cells()));
    cpu->emit(frame, reach.view(), {0, frame.rows}, entry.data());
    const OnDevice<float> entries(entry.data(), frame.cells());
    const OnDevice<Exit> exits(nullptr, frame.cells());
    carryAll<<<static_cast<unsigned>((frame.cells() + 127) / 128), 128>>>(onDevice, frame, scene.rules, entries.data(),
                                                                          exits.data());
    ASSERT_EQ(cudaDeviceSynchronize(), cudaSuccess) << cudaGetErrorString(cudaGetLastError());
    const std::vector<Exit> got = exits.read();
    for (std::int64_t cell = 0; cell < frame.cells(); ++cell) {
      if (entry[cell] == kNeverBends) continue;
      const Exit want = carry(m, frame, scene.rules, cell, entry[cell]);
      ASSERT_EQ(got[cell].steps, want.steps) << cell;
      ASSERT_TRUE(sameBits(got[cell].x, want.x) && sameBits(got[cell].v, want.v)) << cell;
      ASSERT_NEAR(got[cell].power.x, want.power.x, 1e-5f * want.power.x) << cell;
      ++photons;
    }
  }
  EXPECT_GT(photons, 1000);
}

// The view's body, too, compiles for the device on every build.
namespace {
struct NoSink {
  VOLCAUSTIC_HD void count(Counter, std::int64_t) {}
};
} // namespace
template <class Body, class Sink>
__global__ void runBody(std::int64_t n, Body body, Sink sink) {
  const std::int64_t i = blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (i < n) body(i, sink);
}
template __global__ void runBody(std::int64_t, ViewBody<NoSink>, NoSink);

} // namespace volcaustic::test
