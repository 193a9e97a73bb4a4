// What half coverage loses of a solid: corners, edges, and whatever is thinner than a voxel. See
// docs/algorithms/surface.md.
#pragma once

#include "volcaustic/run_context.h"

#include <array>
#include <openvdb/openvdb.h>

namespace volcaustic {

/// Coverage whose surface at one half stays within three quarters of a voxel of the solid's own, where the coverage
/// itself has it shrink from corners and sharp edges and vanish in sheets and wires. A voxel that a flat surface would
/// leave as it is keeps its value. The same active voxels; values in 0 to 1.
openvdb::FloatGrid::Ptr sharpenedCoverage(const openvdb::FloatGrid& coverage, const RunContext& ctx);

/// The part of a voxel that lies beneath a plane, given the part `mean` of the 3^3 voxels around it that does, and any
/// vector along the plane's normal. Exported for its test.
class PlaneCoverage {
public:
  PlaneCoverage();
  [[nodiscard]] float centre(float mean, const std::array<float, 3>& normal) const;

private:
  static constexpr int kMeans = 65, kRatios = 9;
  /// [smallest/largest component][middle/largest][mean, 0 to 1/2]
  std::array<std::array<std::array<float, kMeans>, kRatios>, kRatios> mCentre{};
};

} // namespace volcaustic
