// The instruction sets that photons and the camera's rays run on, on this machine's cores.
//
// The lane_*.cpp files are compiled once for each of them; which one runs is chosen at run time. Such a file must not
// leave shared copies of functions behind: the linker might pick one for the whole program, and an older processor
// would stop at it. So all that it includes is inlined (VOLCAUSTIC_HD), and a test looks at the object files' symbols.
#pragma once

#include "backends/light_bricks.h"
#include "kernels/lamp.h"
#include "kernels/lit.h"
#include "kernels/view.h"

#include <span>
#include <string_view>
#include <vector>

namespace volcaustic {

/// A worker's sums.
struct CpuSums {
  LightBricks bricks;
  PhotonTally tally;
};

/// A straight way through many voxels, in grid space: rasterised later, block by block, where it would be scattered
/// over memory now.
struct FarChord {
  float start[3], direction[3];
  float length;
  float power[3]; ///< mean over the length, W
  float slope[3]; ///< its change, W/voxel; power holds at length/2
  float unused;   ///< lets lanes load any three numbers as four
};

/// Chords that a task left for later; grows outside the files that are compiled for an instruction set.
class FarChords {
public:
  void append(const FarChord* chords, int count);
  [[nodiscard]] std::span<const FarChord> all() const { return mChords; }

private:
  std::vector<FarChord> mChords;
};

/// Cells of a raster's rows: those of one row of reach tiles at a time.
struct EmissionTask {
  const kernels::FlatMedium& medium;
  const kernels::EmissionFrame& frame;
  kernels::RasterView view; ///< of the frame
  kernels::RasterReach reach;
  FixedPoint scale;
  RowRange rows; ///< asked for
  float* entry;
  const float* stops = nullptr; ///< RasterCells
};

/// Photons of a raster: those of cells[0] to cells[count - 1].
struct PhotonTask {
  const kernels::FlatMedium& medium;
  const kernels::EmissionFrame& frame;
  const kernels::PhotonRules& rules;
  FixedPoint scale;
  const float* entry;
  const std::uint32_t* cells;
  std::int64_t count;
  kernels::Landing* landings = nullptr; ///< RasterCells
};
/// Rays of a raster's rows: where each first meets a receiver.
struct StopTask {
  const kernels::ReceiverScene& receivers;
  const kernels::EmissionFrame& frame;
  kernels::RasterView view; ///< of the frame
  RowRange rows;
  float* stops;
};

/// Samples of the pixels of a tile: kViewTile x kViewTile from a corner on, as many as there are.
inline constexpr int kViewTile = 32, kTilePixels = kViewTile * kViewTile;
/// A worker's room for a tile: the planes of one sample, and rays that are not at their end yet.
struct ViewScratch {
  alignas(64) float planes[kernels::kPixelPlanes][kTilePixels];
  alignas(64) std::int32_t rays[kernels::kViewRayNumbers][kTilePixels]; ///< numbers of any type
  alignas(64) std::int32_t pixels[kTilePixels];                         ///< of the rays, in the tile
};
struct ViewTask {
  const kernels::ViewScene& scene;
  const kernels::PixelPlanes& planes;
  std::int32_t column, row;
  std::int32_t firstSample, endSample;
  ViewScratch& scratch;
};
struct ViewCounts {
  std::int64_t steps = 0, notFinite = 0, stepLimit = 0;
};

/// Light at the corners of a brick's cells (view_light.h): three numbers of 9x9x9 voxels, z fastest, and room for a
/// register beyond them.
inline constexpr int kCornersPadded = 752;
struct CornerLight {
  alignas(64) float of[3][kCornersPadded];
};
/// The voxels of a brick and of one more layer on its high sides: `brick` is one of eight (x: 4, y: 2, z: 1), `offset`
/// is in it.
struct CornerVoxels {
  alignas(64) std::int32_t brick[kCornersPadded], offset[kCornersPadded];
};

struct RowsTask;
class RowPages;
template <class Word>
struct RowSweep;

/// Voxels of a brick and of one voxel around it, and as many more as a register may read beyond them.
inline constexpr int kAroundVoxels = 1000, kAroundPadded = 1024;

/// What an instruction set offers.
struct LaneSet {
  std::string_view name; ///< "avx512", "avx2", "scalar"
  int width;             ///< numbers in a register
  /// PhotonTracer::emit for those of the asked rows that are in a row of tiles.
  void (*emitTileRow)(const EmissionTask& task, std::int32_t tileRow, PhotonTally& tally);
  /// Distances to the first receiver, kNeverBends for none, relative to the frame's depth0; from the light on.
  void (*findStops)(const StopTask& task);
  /// Carries photons to their ends. Light of short chords goes to the sums, long chords to `far`.
  void (*tracePhotons)(const PhotonTask& task, CpuSums& sums, FarChords& far);
  /// Adds what chords[ids[0]] to chords[ids[count - 1]] leave in the block with this corner, and in the voxels around
  /// it, to its sums, each for a deposit of at most 2^17 units. The sums are within half of their range before.
  void (*rasterise)(const FarChord* chords, const std::uint32_t* ids, std::int64_t count, const kernels::Int3& corner,
                    float scale, BlockSums& sums);
  /// Lengths of all rays of the footprint inside the voxel: in all, and before their first bends.
  kernels::LitLengths<float> (*litLengths)(const kernels::LitView& view, const float* entry);
  /// Adds the lamp's light at the centres of 10x10x10 voxels from `low` on (z fastest, each moved into the domain),
  /// times the part of it that each is given, to eight sums a voxel (kernels::LightSums). `parts` has kAroundPadded
  /// numbers.
  void (*lightAround)(const kernels::Lamp& lamp, const kernels::Int3& low, const kernels::Int3& dims,
                      const float* parts, float* sums);
  /// kernels::finishBricks on a block, of 4x4x4 bricks, and on a brick.
  std::uint64_t (*finishBlock)(const kernels::LightSums<std::int32_t>& sums, kernels::FluenceVoxel* const* bricks);
  void (*finishBrick)(const kernels::LightSums<float>& sums, kernels::FluenceVoxel* out);
  /// Adds the task's samples to the planes.
  void (*view)(const ViewTask& task, ViewCounts& counts);
  /// Adds the crossings of the task's triangles with the rows of its column to the pages (row_pages.h).
  void (*crossRows)(const RowsTask& task, RowPages& pages);
  /// Carries rows through a brick whose winding numbers, with the offset, are 0 and 1 only. The numbers of the other
  /// rows are written to `irregular`, which grows, and their winding numbers left alone. \return how many there are
  int (*sweepRows32)(const RowSweep<std::uint32_t>& sweep);
  int (*sweepRows64)(const RowSweep<std::uint64_t>& sweep);
  /// Adds the light of voxels, whose eight bricks have these entries in the field: fluence, or directions.
  void (*addCorners)(const kernels::FluenceField& field, const std::int32_t (&entries)[8], const CornerVoxels& voxels,
                     bool directions, CornerLight& light);
  /// Writes light as halves. \return their unit's bits (kernels::textureUnit), 0 where all is dark
  std::int32_t (*packCorners)(const CornerLight& light, kernels::HalfVoxel* out);
};

/// Those that this processor has, the widest first; "scalar", one photon at a time, is the last and the reference.
std::span<const LaneSet> laneSets();

/// By name; "" is the widest. \throws Error(Usage) for names that nobody has, Error(Device) for those that this
/// processor does not have.
const LaneSet& laneSet(std::string_view name);

} // namespace volcaustic
