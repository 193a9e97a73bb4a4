// Where the topology of a surface may change: the blocks of the lattice that its level set is made in.
#pragma once

#include "volume/topology_parts.h"

namespace volcaustic {

using SurfaceParts = std::vector<std::unique_ptr<SurfacePart>>;

/// Cells between the change and where the surface is kept, and the width of the strip that both are known in.
inline constexpr double kMargin = 2.2, kStrip = 2.3;

class RegionMarker {
public:
  /// Everything marked is grown by `pad`, a length.
  RegionMarker(const SurfaceParts& parts, double voxelSize, double pad, const RunContext& ctx);

  /// The surface of a part nearer than `reach` to that of another one.
  void markNear(std::size_t part, std::size_t other, double reach);
  /// Where two parts are in the same place.
  void markOverlap(std::size_t part, std::size_t other);
  /// Where a part enters itself.
  void markSelfOverlap(std::size_t part);
  /// The surface where the ball of `radius` that touches it from within is not inside the part.
  void markThin(std::size_t part, double radius);
  void markSurface(std::size_t part);

  [[nodiscard]] BlockGrid take();

private:
  template <class Wanted>
  void markTriangles(std::size_t part, Wanted wanted);
  void markBox(const Vec3d& low, const Vec3d& high);

  const SurfaceParts& mParts;
  double mVoxelSize, mPad;
  const RunContext& mCtx;
  BlockGrid mGrid;
};

/// Whether two boxes come nearer than `reach`, along each axis.
bool areNear(const Box& a, const Box& b, double reach);

} // namespace volcaustic
