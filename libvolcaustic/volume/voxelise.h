// Solid coverage of one body by super-sampling (docs/algorithms/voxelise.md).
#pragma once

#include "backends/medium_plan.h"
#include "core/brick_grid.h"
#include "volcaustic/medium.h"
#include "volume/coverage_rows.h"
#include "volume/winding.h"

#include <memory>
#include <string>

namespace volcaustic {

/// Coverage of one body over the bricks that it can reach: fractions of supersample^3 samples, 0 outside the patch.
struct CoveragePatch {
  Vec3i firstBrick{0, 0, 0}; ///< of the patch, in bricks of the domain
  BrickGrid<float> coverage; ///< over whole bricks, also beyond the domain's far faces
};

class LatticeTriangles;

/// A body on the lattice of samples that decides its coverage.
class SampledBody {
public:
  /// The body's mesh must outlive it. \throws as voxeliseBody()
  SampledBody(const Body& body, const Domain& domain, int supersample, FillRule fill, const RunContext& ctx);
  ~SampledBody();

  /// Without it nothing below has a meaning but cover().
  [[nodiscard]] bool reachesDomain() const { return mTriangles != nullptr; }
  /// Whether task() is all there is to know of it; the rims of an open mesh are capped, and their winding numbers
  /// added.
  [[nodiscard]] bool closed() const { return mClosed; }
  [[nodiscard]] const Vec3i& firstBrick() const { return mFirstBrick; }
  [[nodiscard]] CountTask task() const;

  /// Its coverage, by the CPU. Warns of a body without a sample.
  [[nodiscard]] CoveragePatch cover(const RunContext& ctx) const;
  void warnOfNothing(const RunContext& ctx) const;

private:
  std::string mPlace;
  bool mClosed = true;
  LoopCaps mCaps;
  Vec3i mFirstBrick{0, 0, 0};
  SubLattice mLattice;
  std::size_t mPoints = 0;
  std::unique_ptr<const LatticeTriangles> mTriangles; // of mCaps too
};

/// Decides inside and outside by `fill` at one sample in each of supersample^3 sub-voxels. Time and memory grow with
/// the surface and the number of bricks. With FillRule::Auto a mesh that is not closed is warned of. \throws
/// Error(Input) naming the body: no triangle, an index out of range, a coordinate that is not finite or absurd; with
/// FillRule::Exact a mesh that is not closed.
CoveragePatch voxeliseBody(const Body& body, const Domain& domain, int supersample, FillRule fill,
                           const RunContext& ctx = {});

} // namespace volcaustic
