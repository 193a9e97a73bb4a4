// The receivers of a scene as the kernels see them, with the texels that they collect light in.
#pragma once

#include "core/large_memory.h"
#include "kernels/receivers.h"
#include "transport/texel_cover.h"
#include "volcaustic/receivers.h"

#include <cstdint>
#include <span>
#include <vector>

namespace volcaustic {

/// A part of a receiver's surface that lies in its map in one piece, and the texels that are its own: nobody else's
/// surface is in them, nor in any that a bilinear lookup on it reads.
struct ReceiverChart {
  std::int32_t receiver;
  TexelRange texels; ///< of the receiver's map
};

/// Where a triangle lies in its receiver's map.
MapTriangle mapTriangle(const kernels::ReceiverTriangle& triangle);

/// Immutable. Texels are numbered through all receivers: ReceiverSurface::firstTexel + row * columns + column.
class ReceiverSet {
public:
  /// \throws Error(Input) "receivers[i] (name): ..." for a mesh without a triangle or numbers that are not finite,
  /// Error(Usage) for a resolution out of range, Error(Input) beyond the context's memory.
  ReceiverSet(std::span<const Receiver> receivers, const Domain& domain, const RunContext& ctx);

  /// Valid as long as the set and `irradiance` (three floats a texel, or null) are.
  [[nodiscard]] kernels::ReceiverScene scene(const float* irradiance = nullptr) const;

  [[nodiscard]] std::span<const kernels::ReceiverTriangle> triangles() const { return mTriangles; }
  [[nodiscard]] std::span<const kernels::ReceiverSurface> surfaces() const { return mSurfaces; }
  [[nodiscard]] std::span<const ReceiverChart> charts() const { return mCharts; }
  [[nodiscard]] std::int32_t chartOf(std::int32_t triangle) const { return mChartOf[triangle]; }
  /// Whether all of a receiver is in one plane, its map edge to edge.
  [[nodiscard]] bool isFlat(std::int32_t receiver) const;
  [[nodiscard]] std::int64_t texelCount() const { return static_cast<std::int64_t>(mTexels.size()); }
  [[nodiscard]] std::int64_t texelAt(std::int32_t receiver, std::int32_t column, std::int32_t row) const {
    return mSurfaces[receiver].firstTexel + std::int64_t{row} * mSurfaces[receiver].columns + column;
  }

  struct Texel {
    float area = 0;             ///< of the surface in it, world units squared; 0 where there is none
    float cover = 0;            ///< part of the texel that the surface takes up, 0 to 1
    std::int32_t triangle = -1; ///< that takes up most of it
  };
  [[nodiscard]] std::span<const Texel> texels() const { return mTexels; }

  /// A map for each receiver. Three floats a texel, W/m2.
  [[nodiscard]] std::vector<ReceiverMap> maps(std::span<const float> caustic, std::span<const float> direct) const;

private:
  static constexpr double kLeastCover = 1e-9; ///< of a triangle or a texel: below, it is not there

  void addReceiver(const Receiver& receiver, const std::string& place, const Domain& domain, const RunContext& ctx);
  void measureTexels(double voxelSize, const RunContext& ctx);

  std::vector<kernels::ReceiverNode> mNodes;
  std::vector<kernels::ReceiverTriangle> mTriangles;
  std::vector<kernels::ReceiverSurface> mSurfaces;
  std::vector<ReceiverChart> mCharts;
  std::vector<std::int32_t> mChartOf; ///< of each triangle
  LargeVector<Texel> mTexels;
  std::vector<ReceiverMap> mEmptyMaps; ///< geometry without pictures
};

} // namespace volcaustic
