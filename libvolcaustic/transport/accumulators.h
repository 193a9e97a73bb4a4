// The CPU's sinks: private sums for each worker, in 64-bit fixed point, merged brick by brick. Integers add up to the
// same whatever the order, so neither the number of threads nor their timing changes a bit of the result.
#pragma once

#include "core/brick_grid.h"
#include "kernels/tally.h"
#include "volcaustic/error.h"
#include "volcaustic/run_context.h"

#include <array>
#include <atomic>
#include <memory>
#include <vector>

namespace volcaustic {

/// Sums of one brick: powerLength RGB, then its luminance-weighted direction, for each voxel.
inline constexpr int kSums = 6;
using AccumulatorBrick = std::array<std::array<std::int64_t, kSums>, kBrickVoxels>;

/// What the sinks of one pass share: scales, and the memory they may take between them.
struct SinkRules {
  double depositScale = 1; ///< fixed-point units for a W*voxel
  double tallyScale = 1;   ///< fixed-point units for a W
  std::uint64_t memoryLimit = 0;
  std::atomic<std::uint64_t> bytes{0};

  /// Scales for a pass that emits at most `watts` in any channel. A voxel may collect 64 W*voxel for each emitted W
  /// (every photon crossing it some forty times over) before 2^62 is reached; what is left below is 2^-34 of a
  /// millionth of the power.
  explicit SinkRules(double watts, std::uint64_t memoryLimit_) : memoryLimit(memoryLimit_) {
    int exponent = 0;
    std::frexp(watts > 0 ? watts : 1.0, &exponent);
    depositScale = std::ldexp(1.0, 62 - 6 - exponent);
    tallyScale = std::ldexp(1.0, 62 - 2 - exponent);
  }
};

class CpuSink {
public:
  CpuSink(const kernels::Int3& brickDims, SinkRules& rules)
      : mRules(&rules), mBrickDims(brickDims), mBricks(std::size_t(brickDims.x) * brickDims.y * brickDims.z) {}

  void deposit(const kernels::Int3& voxel, const kernels::Float3& powerLength, const kernels::Float3& direction) {
    auto& brick = mBricks[(std::size_t(voxel.x >> 3) * mBrickDims.y + (voxel.y >> 3)) * mBrickDims.z + (voxel.z >> 3)];
    if (!brick) brick = allocate();
    auto& sums = (*brick)[kernels::FlatMedium::voxelOffset(voxel)];
    const double s = mRules->depositScale;
    sums[0] += static_cast<std::int64_t>(powerLength.x * s);
    sums[1] += static_cast<std::int64_t>(powerLength.y * s);
    sums[2] += static_cast<std::int64_t>(powerLength.z * s);
    sums[3] += static_cast<std::int64_t>(direction.x * s);
    sums[4] += static_cast<std::int64_t>(direction.y * s);
    sums[5] += static_cast<std::int64_t>(direction.z * s);
  }
  void tally(kernels::Outcome outcome, const kernels::Double3& power) {
    auto& t = mTallies[static_cast<int>(outcome)];
    t[0] += static_cast<std::int64_t>(power.x * mRules->tallyScale);
    t[1] += static_cast<std::int64_t>(power.y * mRules->tallyScale);
    t[2] += static_cast<std::int64_t>(power.z * mRules->tallyScale);
  }
  void count(kernels::Counter counter, std::int64_t n) { mCounts[static_cast<int>(counter)] += n; }

  [[nodiscard]] const AccumulatorBrick* brick(std::int64_t index) const { return mBricks[index].get(); }
  [[nodiscard]] const std::array<std::int64_t, 3>& tallies(kernels::Outcome o) const {
    return mTallies[static_cast<int>(o)];
  }
  [[nodiscard]] std::int64_t counts(kernels::Counter c) const { return mCounts[static_cast<int>(c)]; }

private:
  std::unique_ptr<AccumulatorBrick> allocate() {
    if (mRules->bytes.fetch_add(sizeof(AccumulatorBrick)) + sizeof(AccumulatorBrick) > mRules->memoryLimit)
      throw Error(ErrorKind::Input, "photons: the light sums need more than the memory limit of " +
                                        std::to_string(mRules->memoryLimit >> 20) +
                                        " MiB; lower the resolution or raise --memory-limit");
    return std::make_unique<AccumulatorBrick>(); // zeroed
  }

  SinkRules* mRules;
  kernels::Int3 mBrickDims;
  std::vector<std::unique_ptr<AccumulatorBrick>> mBricks;
  std::array<std::array<std::int64_t, 3>, static_cast<int>(kernels::Outcome::Count)> mTallies{};
  std::array<std::int64_t, static_cast<int>(kernels::Counter::Count)> mCounts{};
};

} // namespace volcaustic
