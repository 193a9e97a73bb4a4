#include "backends/lanes.h"

#include "backends/cpu_sink.h"
#include "backends/row_pages.h"
#include "backends/tile_emission.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <string>
#include <vector>

namespace volcaustic {

// One for each instruction set that lane_*.cpp are compiled for.
#define VOLCAUSTIC_LANE_FUNCTIONS(name)                                                                                \
  namespace name {                                                                                                     \
  void emitTileRow(const EmissionTask& task, std::int32_t tileRow, PhotonTally& tally);                                \
  void findStops(const StopTask& task);                                                                                \
  void tracePhotons(const PhotonTask& task, CpuSums& sums, FarChords& far);                                            \
  void rasterise(const FarChord* chords, const std::uint32_t* ids, std::int64_t count, const kernels::Int3& corner,    \
                 float scale, BlockSums& sums);                                                                        \
  kernels::LitLengths<float> litLengths(const kernels::LitView& view, const float* entry);                             \
  void lightAround(const kernels::Lamp& lamp, const kernels::Int3& low, const kernels::Int3& dims, const float* parts, \
                   float* sums);                                                                                       \
  std::uint64_t finishBlock(const kernels::LightSums<std::int32_t>& sums, kernels::FluenceVoxel* const* bricks);       \
  void finishBrick(const kernels::LightSums<float>& sums, kernels::FluenceVoxel* out);                                 \
  void addCorners(const kernels::FluenceField& field, const std::int32_t (&entries)[8], const CornerVoxels& voxels,    \
                  bool directions, CornerLight& light);                                                                \
  std::int32_t packCorners(const CornerLight& light, kernels::HalfVoxel* out);                                         \
  void view(const ViewTask& task, ViewCounts& counts);                                                                 \
  void crossRows(const RowsTask& task, RowPages& pages);                                                               \
  int sweepRows32(const RowSweep<std::uint32_t>& sweep);                                                               \
  int sweepRows64(const RowSweep<std::uint64_t>& sweep);                                                               \
  }
VOLCAUSTIC_LANE_FUNCTIONS(avx512)
VOLCAUSTIC_LANE_FUNCTIONS(avx2)
#undef VOLCAUSTIC_LANE_FUNCTIONS

namespace {

void emitOneByOne(const EmissionTask& task, std::int32_t tileRow, PhotonTally& tally) {
  tiles::TileRowEmission<float>(task, tileRow, tally).run();
}

void stopOneByOne(const StopTask& task) { tiles::findStops<float>(task); }

/// The reference: every chord goes to the sums at once.
void traceOneByOne(const PhotonTask& task, CpuSums& sums, FarChords&) {
  CpuSink sink(sums, task.scale);
  const kernels::PhotonBody<CpuSink> body{task.medium, task.frame,    task.entry, task.cells,
                                          task.rules,  task.landings, 0};
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

void lightAroundOneByOne(const kernels::Lamp& lamp, const kernels::Int3& low, const kernels::Int3& dims,
                         const float* parts, float* sums) {
  const auto centre = [](int c, int dim) { return static_cast<float>(std::clamp(c, 0, dim - 1)) + 0.5f; };
  for (int k = 0; k < kAroundVoxels; ++k, sums += 8) {
    const kernels::Float3 p(centre(low.x + k / 100, dims.x), centre(low.y + k / 10 % 10, dims.y),
                            centre(low.z + k % 10, dims.z));
    const kernels::LampLight<float> light = kernels::lampLight<float>(lamp, p);
    const kernels::Float3 fluence = light.fluence * parts[k];
    const kernels::Float3 towards = light.direction * kernels::luminance(fluence);
    for (int i = 0; i < 3; ++i) {
      sums[i] += fluence[i];
      sums[4 + i] += towards[i];
    }
  }
}

bool packOneByOne(const float* v, kernels::FluenceVoxel* out) {
  std::uint32_t any = 0;
  for (int k = 0; k < 8; ++k, v += 8) {
    out[k] = kernels::pack({kernels::Float3(v[0], v[1], v[2]), kernels::Float3(v[4], v[5], v[6])});
    for (const std::uint32_t w : out[k].words) any |= w;
  }
  return any != 0;
}
std::uint64_t finishBlockOneByOne(const kernels::LightSums<std::int32_t>& sums, kernels::FluenceVoxel* const* bricks) {
  return kernels::finishBricks<kBlockEdge>(sums, bricks, packOneByOne);
}
void finishBrickOneByOne(const kernels::LightSums<float>& sums, kernels::FluenceVoxel* out) {
  kernels::finishBricks<8>(sums, &out, packOneByOne);
}

struct CountingSink {
  ViewCounts& counts;
  void count(kernels::Counter c, std::int64_t n) {
    using kernels::Counter;
    (c == Counter::Steps ? counts.steps : c == Counter::NotFinite ? counts.notFinite : counts.stepLimit) += n;
  }
};
void viewOneByOne(const ViewTask& task, ViewCounts& counts) {
  CountingSink sink{counts};
  const kernels::ViewBody<CountingSink> body{task.scene, task.planes, task.firstSample, task.endSample};
  const kernels::CameraFrame& camera = task.scene.camera;
  for (std::int32_t r = task.row; r < std::min(task.row + kViewTile, camera.height); ++r)
    for (std::int32_t c = task.column; c < std::min(task.column + kViewTile, camera.width); ++c)
      body(std::int64_t{r} * camera.width + c, sink);
}

void addCornersOneByOne(const kernels::FluenceField& field, const std::int32_t (&entries)[8],
                        const CornerVoxels& voxels, bool directions, CornerLight& light) {
  for (int k = 0; k < kernels::kFieldVoxels; ++k) {
    const std::int32_t entry = entries[voxels.brick[k]];
    if (entry == 0) continue;
    const kernels::Light l =
        kernels::unpack(entry < 0 ? field.constants[~entry]
                                  : field.voxels[(entry - 1) * std::int64_t{kernels::kStepVoxels} + voxels.offset[k]]);
    for (int i = 0; i < 3; ++i) light.of[i][k] += directions ? l.towards[i] : l.fluence[i];
  }
}
std::int32_t packCornersOneByOne(const CornerLight& light, kernels::HalfVoxel* out) {
  float most = 0;
  for (const auto& part : light.of)
    for (int k = 0; k < kernels::kFieldVoxels; ++k) most = std::max(most, std::abs(part[k]));
  const std::int32_t unit = kernels::textureUnitFor(most);
  if (unit == 0) return 0;
  const float scale = kernels::inverseOfUnit(unit);
  for (int k = 0; k < kernels::kFieldVoxels; ++k)
    out[k] = {kernels::halfOf(light.of[0][k] * scale), kernels::halfOf(light.of[1][k] * scale),
              kernels::halfOf(light.of[2][k] * scale), 0};
  return unit;
}

std::vector<LaneSet> findLaneSets() {
  std::vector<LaneSet> sets;
#if defined(VOLCAUSTIC_HAS_LANES)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512cd"))
    sets.push_back({"avx512", 16, avx512::emitTileRow, avx512::findStops, avx512::tracePhotons, avx512::rasterise,
                    avx512::litLengths, avx512::lightAround, avx512::finishBlock, avx512::finishBrick, avx512::view,
                    avx512::crossRows, avx512::sweepRows32, avx512::sweepRows64, avx512::addCorners,
                    avx512::packCorners});
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
    sets.push_back({"avx2", 8, avx2::emitTileRow, avx2::findStops, avx2::tracePhotons, avx2::rasterise,
                    avx2::litLengths, avx2::lightAround, avx2::finishBlock, avx2::finishBrick, avx2::view,
                    avx2::crossRows, avx2::sweepRows32, avx2::sweepRows64, avx2::addCorners, avx2::packCorners});
#endif
  sets.push_back({"scalar", 1, emitOneByOne, stopOneByOne, traceOneByOne, nullptr, litOneByOne, lightAroundOneByOne,
                  finishBlockOneByOne, finishBrickOneByOne, viewOneByOne, crossRowsOneByOne, sweepRowsOneByOne,
                  sweepRowsOneByOne, addCornersOneByOne, packCornersOneByOne});
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
