// What grids made by others must be, and what their values may become.
#pragma once

#include "volcaustic/run_context.h"
#include "volume/vdb_file.h"

#include <atomic>
#include <string>
#include <vector>

namespace volcaustic {

inline constexpr float kLargestCoefficient = 1e9f; ///< as in a scene file
inline constexpr float kForwardMost = 0.99f;       ///< of the asymmetry

/// The grids of these names. \throws Error(Input) listing what there is when one is absent or holds no numbers.
GridSelection mappableGrids(const std::string& place, const std::vector<std::string>& names);

/// \throws Error(Input) for a frustum
void requireLinear(const openvdb::GridBase& grid, const std::string& place);

/// \throws Error(Usage) unless scale and offset are finite
void requireFinite(const GridMapping& mapping, const std::string& place);

/// What a mapping's values may be. Remembers what it met, from all threads.
class MappedRange {
public:
  MappedRange(float low, float high) : mLow(low), mHigh(high) {}

  float operator()(float value);
  /// Of offset + scale * value. What is beyond the range by no more than these were rounded is within it.
  float operator()(const GridMapping& mapping, int channel, float value);
  /// Warns of values that were clamped. \throws Error(Input) for values that were not finite.
  void report(const std::string& property, const std::string& grid, const std::string& place,
              const RunContext& ctx) const;

private:
  float mLow, mHigh;
  std::atomic<bool> mNotFinite{false}, mClamped{false};
};

} // namespace volcaustic
