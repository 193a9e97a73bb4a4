#include "backends/lanes.h"

#include "backends/cpu_sink.h"
#include "kernels/smooth.h"
#include "volcaustic/error.h"

#include <string>
#include <vector>

namespace volcaustic {

// One for each instruction set that lane_*.cpp are compiled for.
#define VOLCAUSTIC_LANE_FUNCTIONS(name)                                                                                \
  namespace name {                                                                                                     \
  void tracePhotons(const PhotonTask& task, CpuSums& sums, FarChords& far);                                            \
  std::int64_t findBlocks(const FarChord* chords, std::int64_t count, const kernels::Int3& blockDims,                  \
                          BlockCrossing* crossings);                                                                   \
  std::int64_t rasterise(const FarChord* chords, const std::uint32_t* ids, std::int64_t count,                         \
                         const kernels::Int3& corner, float scale, BlockSums& sums);                                   \
  kernels::LitLengths<float> litLengths(const kernels::LitView& view, const float* entry);                             \
  void lightBrick(const kernels::LampView& lamp, float* fluence, float* direction);                                    \
  void smoothBrick(const float* in, float* out);                                                                       \
  }
VOLCAUSTIC_LANE_FUNCTIONS(avx512)
VOLCAUSTIC_LANE_FUNCTIONS(avx2)
#undef VOLCAUSTIC_LANE_FUNCTIONS

namespace {

/// The reference: every chord goes to the sums at once.
void traceOneByOne(const PhotonTask& task, CpuSums& sums, FarChords&) {
  CpuSink sink(sums, task.scale);
  const kernels::PhotonBody<CpuSink> body{task.medium, task.frame, task.entry, task.cells, task.rules};
  for (std::int64_t i = 0; i < task.count; ++i) body(i, sink);
}

kernels::LitLengths<float> litOneByOne(const kernels::LitView& view, const float* entry) {
  kernels::LitLengths<float> sum{0, 0};
  for (std::int32_t i = 0; i < view.cells; ++i) {
    const kernels::LitLengths<float> some = kernels::litLengths<float>(view, entry, i);
    sum.all += some.all;
    sum.lit += some.lit;
  }
  return sum;
}

void lightOneByOne(const kernels::LampView& lamp, float* fluence, float* direction) {
  for (std::int32_t k = 0; k < kernels::kStepVoxels; ++k) {
    const kernels::LampLight<float> light = kernels::lampLight<float>(lamp, k);
    const float l = kernels::luminance(light.fluence);
    for (int i = 0; i < 3; ++i) {
      fluence[3 * k + i] += light.fluence[i];
      direction[3 * k + i] += light.direction[i] * l;
    }
  }
}

void smoothOneByOne(const float* in, float* out) { kernels::smoothBrick(in, out); }

std::vector<LaneSet> findLaneSets() {
  std::vector<LaneSet> sets;
#if defined(VOLCAUSTIC_HAS_LANES)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512cd"))
    sets.push_back({"avx512", 16, avx512::tracePhotons, avx512::findBlocks, avx512::rasterise, avx512::litLengths,
                    avx512::lightBrick, avx512::smoothBrick});
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
    sets.push_back({"avx2", 8, avx2::tracePhotons, avx2::findBlocks, avx2::rasterise, avx2::litLengths,
                    avx2::lightBrick, avx2::smoothBrick});
#endif
  sets.push_back({"scalar", 1, traceOneByOne, nullptr, nullptr, litOneByOne, lightOneByOne, smoothOneByOne});
  return sets;
}

} // namespace

void FarChords::append(const FarChord* chords, int count) { mChords.insert(mChords.end(), chords, chords + count); }

std::span<const LaneSet> laneSets() {
  static const std::vector<LaneSet> sets = findLaneSets();
  return sets;
}

const LaneSet& laneSet(std::string_view name) {
  if (name.empty()) return laneSets().front();
  for (const LaneSet& set : laneSets())
    if (set.name == name) return set;
  const bool known = name == "avx512" || name == "avx2";
  throw Error(
      known ? ErrorKind::Device : ErrorKind::Usage,
      "--device cpu:" + std::string(name) + ": " +
          (known ? "this processor does not have it" : "no such instruction set") + "; it has " + [] {
            std::string names;
            for (const LaneSet& set : laneSets()) names += (names.empty() ? "" : ", ") + std::string(set.name);
            return names;
          }());
}

} // namespace volcaustic
