// The seam between the photon pass and the machines that run it. A tracer owns one machine's sums for one pass; all
// tracers of a pass count in the same fixed-point units, so their sums add up exactly, whatever each of them traced.
#pragma once

#include "backends/block_sums.h"
#include "backends/flat_storage.h"
#include "kernels/photon.h"
#include "volcaustic/run_context.h"

#include <array>
#include <cstdint>
#include <memory>

namespace volcaustic {

/// Fixed-point units of a pass.
struct FixedPoint {
  double deposit = 1; ///< for a W*voxel
  double tally = 1;   ///< for a W
};

/// Power by outcome in FixedPoint::tally units, and counts.
struct PhotonTally {
  std::array<std::array<std::int64_t, 3>, static_cast<int>(kernels::Outcome::Count)> power{};
  std::array<std::int64_t, static_cast<int>(kernels::Counter::Count)> counts{};

  PhotonTally& operator+=(const PhotonTally& other) {
    for (std::size_t i = 0; i < power.size(); ++i)
      for (int c = 0; c < 3; ++c) power[i][c] += other.power[i][c];
    for (std::size_t i = 0; i < counts.size(); ++i) counts[i] += other.counts[i];
    return *this;
  }
};

/// Rows [begin, end) of a raster.
struct RowRange {
  std::int32_t begin = 0, end = 0;
};

/// What there is for each cell of a raster, in arrays of the whole raster.
struct RasterCells {
  // NOLINTNEXTLINE(google-explicit-constructor): most rasters have nothing but entries
  RasterCells(float* entries, const float* firstReceivers = nullptr, kernels::Landing* photonLandings = nullptr)
      : entry(entries), stops(firstReceivers), landings(photonLandings) {}

  float* entry;               ///< distance of the first bend
  const float* stops;         ///< distance to the first receiver; null without receivers
  kernels::Landing* landings; ///< where photons ended; null without receivers. Those that landed nowhere leave theirs
};

class PhotonTracer {
public:
  virtual ~PhotonTracer() = default;

  /// Does what EmissionBody does for every cell of the rows; cells of other rows are left alone. `reach` bounds where
  /// the raster's rays can bend.
  virtual void emit(const kernels::EmissionFrame& frame, const kernels::RasterReach& reach, RowRange rows,
                    const RasterCells& cells) = 0;
  /// Carries the photons of the rows' cells that bend from there to their ends. Landings are there after wait().
  virtual void trace(const kernels::EmissionFrame& frame, RowRange rows, const RasterCells& cells) = 0;
  /// Waits until everything asked for has been carried out; the sums need not be on this machine then. Tracers whose
  /// calls return when they are done have nothing to wait for.
  virtual void wait() {}
  /// Waits for everything asked for; the sums below are complete and on this machine then.
  virtual void finish() = 0;

  /// Whether a block (z fastest over blockDims), or the voxels around it, may hold any light.
  [[nodiscard]] virtual bool touched(std::int64_t block) const = 0;
  /// Adds the sums of the block and of the voxels around it to `sums`. Safe from several threads at once.
  virtual void addBlock(std::int64_t block, BlockSums& sums) const = 0;
  [[nodiscard]] virtual PhotonTally tally() const = 0;
  /// The most memory that the tracer's own arrays took, bytes on its machine.
  [[nodiscard]] virtual std::uint64_t peakBytes() const = 0;
};

/// What every machine is given. The medium's arrays stay valid while the tracer lives.
struct TracerSetup {
  kernels::FlatMedium medium;
  kernels::PhotonRules rules;
  FixedPoint scale;
  std::shared_ptr<const DeviceFlatMedium> onDevice{}; ///< the medium where it was built, if that was a GPU
};

/// This machine's cores. `lanes` is the instruction set asked for: "", "scalar", "avx2" or "avx512" ("" takes the
/// widest).
std::unique_ptr<PhotonTracer> makeCpuTracer(const TracerSetup& setup, const RunContext& ctx, std::string_view lanes);

/// CUDA device `ordinal`; a medium that does not lie there is uploaded. \throws Error(Device) when it cannot be used or
/// its memory does not do.
std::unique_ptr<PhotonTracer> makeCudaTracer(const TracerSetup& setup, const RunContext& ctx, int ordinal);

} // namespace volcaustic
