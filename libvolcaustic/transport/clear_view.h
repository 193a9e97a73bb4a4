// Light on whole patches of a flat receiver: most of a floor has nothing between it and a light.
#pragma once

#include "kernels/emission.h"
#include "transport/receiver_set.h"

#include <array>
#include <span>
#include <vector>

namespace volcaustic {

/// Answers for one sharp light and one of its rasters. All arguments must live as long.
class ClearView {
public:
  /// `entry`: the raster's first bends, relative to frame.depth0.
  ClearView(const ReceiverSet& set, const kernels::EmissionFrame& frame, std::span<const float> entry);

  /// Corners of a parallelogram, grid space.
  using Patch = std::array<kernels::Double3, 4>;

  /// True only if light, of a point or parallel, meets neither a bend of this raster nor another receiver on its way to
  /// any point of a patch of the flat receiver `number`; of six rasters around a light, only if this one sees all of
  /// the patch. `light` is the place of the point or the direction.
  [[nodiscard]] bool reaches(const Patch& patch, std::int32_t number, bool point, const kernels::Double3& light) const;

private:
  static constexpr std::int32_t kTile = 16; ///< cells along a side
  struct Bounds {
    kernels::Double3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    void add(const kernels::Double3& p);
  };

  [[nodiscard]] bool bendsNowhere(const Patch& patch) const;
  [[nodiscard]] bool isShadowed(const Bounds& patch, std::int32_t number, bool point,
                                const kernels::Double3& light) const;

  const kernels::EmissionFrame& mFrame;
  std::int32_t mColumns = 0, mRows = 0; ///< of tiles
  std::vector<float> mNearest;          ///< first bend of each tile
  std::vector<Bounds> mReceivers;
};

} // namespace volcaustic
