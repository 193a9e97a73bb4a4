// The instruction sets that photons run on, on this machine's cores.
//
// lane_photons.cpp and lane_blocks.cpp are compiled once for each of them; which one runs is chosen at run time. Such a
// file must not leave shared copies of functions behind: the linker might pick one for the whole program, and an older
// processor would stop at it. So all that it includes is inlined (VOLCAUSTIC_HD), and a test looks at the object files'
// symbols.
#pragma once

#include "backends/light_bricks.h"
#include "kernels/lit.h"

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
  float power[3];   ///< mean over the length, W
  float slope[3];   ///< its change, W/voxel; power holds at length/2
  float unused = 0; ///< lets lanes load any three numbers as four
};

/// Chords that a task left for later; grows outside the files that are compiled for an instruction set.
class FarChords {
public:
  void append(const FarChord* chords, int count);
  [[nodiscard]] std::span<const FarChord> all() const { return mChords; }

private:
  std::vector<FarChord> mChords;
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
};

/// A block that a chord goes through.
struct BlockCrossing {
  std::int32_t block, chord;
};

/// What an instruction set offers.
struct LaneSet {
  std::string_view name; ///< "avx512", "avx2", "scalar"
  int width;             ///< numbers in a register
  /// Carries photons to their ends. Light of short chords goes to the sums, long chords to `far`.
  void (*tracePhotons)(const PhotonTask& task, CpuSums& sums, FarChords& far);
  /// Blocks of blockDims that each of `count` chords goes through, each once; `crossings` has room for mostBlocks() of
  /// every chord. Returns their number.
  std::int64_t (*findBlocks)(const FarChord* chords, std::int64_t count, const kernels::Int3& blockDims,
                             BlockCrossing* crossings);
  /// Adds the part inside the block of chords[ids[0]] to chords[ids[count - 1]] to its sums, each for a deposit of at
  /// most 2^17 units. The sums are within half of their range before. Returns the number of voxels crossed.
  std::int64_t (*rasterise)(const FarChord* chords, const std::uint32_t* ids, std::int64_t count,
                            const kernels::Int3& corner, float scale, BlockSums& sums);
  /// Lengths of all rays of the footprint inside the voxel: in all, and before their first bends.
  kernels::LitLengths<float> (*litLengths)(const kernels::LitView& view, const float* entry);
  /// Adds the light to all 512 voxels of a brick: fluence, and its luminance times the direction; three numbers each.
  void (*lightBrick)(const kernels::LampView& lamp, float* fluence, float* direction);
  /// Three passes of (1, 2, 1)/4 over a brick of three-vectors and one voxel around it: 10x10x10 in, 8x8x8 out.
  void (*smoothBrick)(const float* in, float* out);
};
/// Blocks that a chord of this length can go through.
constexpr std::int64_t mostBlocks(float length) { return 3 * (static_cast<std::int64_t>(length) / kBlockEdge + 2); }

/// Those that this processor has, the widest first; "scalar", one photon at a time, is the last and the reference.
std::span<const LaneSet> laneSets();

/// By name; "" is the widest. \throws Error(Usage) for names that nobody has, Error(Device) for those that this
/// processor does not have.
const LaneSet& laneSet(std::string_view name);

} // namespace volcaustic
