// What the winding number of a mesh's caps rounds to at the samples of a lattice. See winding.h for why that is all
// that a mesh which does not close needs.
#pragma once

#include "volcaustic/run_context.h"
#include "volume/cap_winding.h"
#include "volume/coverage_rows.h"
#include "volume/cube_interpolation.h"
#include "volume/winding.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace volcaustic {

/// The caps' winding number, rounded and negated: the whole number to add to the winding number of the closed mesh.
class CapOffsets {
public:
  static constexpr std::int16_t kVaries = std::numeric_limits<std::int16_t>::min();

  /// Decides for the largest octree cubes of bricks for which the number is provably the same at every sample.
  CapOffsets(const LoopCaps& caps, const SubLattice& lattice, const RunContext& ctx);

  /// Of a brick of the lattice (z fastest); kVaries where it is not one number.
  [[nodiscard]] std::int16_t ofBrick(std::int64_t brick) const { return mTable[brick]; }
  /// Of every sample of a brick, in row order.
  void ofSamples(const Vec3i& brick, std::vector<std::int16_t>& offsets) const;

private:
  void fillBricks(const Vec3i& first, int n);

  SubLattice mLattice;
  CapWinding mWinding;
  std::vector<CubeInterpolation> mLevels; // cubes of a brick, of half its edge and so on
  Vec3i mBricks{};
  std::vector<std::int16_t> mTable;
};

} // namespace volcaustic
