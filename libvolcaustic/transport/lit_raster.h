// What a raster's rays light: cubes of voxels as a whole, and parts of voxels.
#pragma once

#include "backends/lanes.h"
#include "kernels/emission.h"
#include "transport/footprint.h"

#include <span>
#include <vector>

namespace volcaustic {

/// The face of a cube around a light that sees what is at r from it, 2 * axis + (whether along it): that of the largest
/// coordinate, the first of equals.
int cubeFaceTowards(const kernels::Double3& r);
/// Whether a raster, one of six, is this face.
bool isCubeFace(const kernels::EmissionFrame& frame, int face);

class LitRaster {
public:
  /// `entry` is the raster's map of first bends; both stay valid while this lives.
  LitRaster(const kernels::EmissionFrame& frame, std::span<const float> entry, const RunContext& ctx);

  /// How a cube of voxels lies: wholly before the first bends, wholly behind them, neither; or where another face of
  /// the cube around the light sees it.
  enum class Cover : std::uint8_t { Lit, Shadow, Mixed, Elsewhere };
  [[nodiscard]] Cover cover(const kernels::Int3& low, int size) const;

  /// Of each voxel of a brick (z fastest), the part of its light that comes through this raster and has not met a bend:
  /// over the rays that cross the voxel, lit length by length.
  void litParts(const kernels::Int3& low, std::span<float, kernels::kStepVoxels> parts) const;

private:
  /// Nearest and farthest first bend over the cells of a tile.
  struct TileDepths {
    int edge; ///< cells along a tile's edge
    int columns, rows;
    std::vector<float> nearest, farthest;
  };
  static TileDepths tileDepths(const kernels::EmissionFrame& frame, std::span<const float> entry,
                               const RunContext& ctx);
  /// The part of a voxel that this raster sees, in sixty-fourths; over the faces of a cube around a light they add up
  /// to one.
  [[nodiscard]] double share(const kernels::Int3& voxel) const;
  /// litParts of one voxel that this raster sees, by its footprint.
  [[nodiscard]] double litPart(const kernels::Int3& voxel, const Footprint& f) const;
  [[nodiscard]] kernels::LitLengths<double> regularLengths(const kernels::Int3& voxel, const Footprint& f) const;
  [[nodiscard]] kernels::LitLengths<double> anyLengths(const kernels::Int3& voxel, const Footprint& f) const;
  [[nodiscard]] double centreLit(const kernels::Int3& voxel) const;
  enum class Seen { All, Part, Nothing };
  [[nodiscard]] Seen seenPart(const kernels::Int3& low, int size) const;
  /// Bounds of the first bends over a footprint's tiles.
  struct Bends {
    float nearest, farthest;
  };
  [[nodiscard]] Bends bends(const Footprint& f) const;

  const kernels::EmissionFrame& mFrame;
  std::span<const float> mEntry;
  TileDepths mTiles;
  bool mRegular; ///< rays at the middles of their cells, near enough for single precision, numbered with 32 bits
  const LaneSet& mLanes = laneSet("");
};

} // namespace volcaustic
