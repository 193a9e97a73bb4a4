// A picture in passes: each adds as many samples a pixel as there are, to the tiles that still need them.
#pragma once

#include "backends/view_tracer.h"
#include "volcaustic/view.h"

#include <span>
#include <string>
#include <vector>

namespace volcaustic {

/// The layers of a picture whose sum is the light of its lamps.
inline constexpr const char* kLightParts[] = {"caustic", "direct", "receiver"};

/// The channels of a picture, and of the layers that each of these lights has by itself: `light.R`, `light.caustic.R`,
/// ...
std::vector<std::string> pictureChannels(std::span<const std::string> lights = {});

class Picture {
public:
  /// All zero; most of what that costs is memory's first touch.
  Picture(const Camera& camera, const ViewOptions& options, double voxelSize, const RunContext& ctx);

  [[nodiscard]] const kernels::PixelPlanes& planes() const { return mPlanes; }
  /// Has all passes rendered; the observer may be empty.
  ViewResult render(ViewTracer& tracer, const ViewObserver& observer);

private:
  /// Tiles whose noise, or a neighbour's, is above the threshold after so many samples a pixel: what one tile has not
  /// seen yet, the next one may have.
  [[nodiscard]] std::vector<std::int32_t> unfinished(const std::vector<std::int32_t>& tiles, int samples) const;
  [[nodiscard]] bool isNoisy(std::int32_t tile, int samples, double floor) const;
  [[nodiscard]] std::int64_t pixelsOf(const std::vector<std::int32_t>& tiles) const;
  [[nodiscard]] kernels::Int3 cornerOf(std::int32_t tile) const; ///< column, row
  /// Calls visit(pixel) for those of a tile.
  template <class Visit>
  void forEachPixel(std::int32_t tile, const Visit& visit) const;

  ViewOptions mOptions;
  RunContext mCtx;
  ViewResult mResult;
  std::vector<float> mSpread;
  kernels::PixelPlanes mPlanes;
  std::int32_t mColumns, mRows; ///< of tiles
};

} // namespace volcaustic
