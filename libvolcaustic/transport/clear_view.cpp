#include "transport/clear_view.h"

#include "transport/emission.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

using kernels::Double3;

void ClearView::Bounds::add(const Double3& p) {
  low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
  high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
}

ClearView::ClearView(const ReceiverSet& set, const kernels::EmissionFrame& frame, std::span<const float> entry)
    : mFrame(frame), mReceivers(set.surfaces().size()) {
  for (const kernels::ReceiverTriangle& t : set.triangles())
    for (const kernels::Float3& corner : t.corner) mReceivers[t.receiver].add(Double3(corner));
  mColumns = (frame.columns + kTile - 1) / kTile;
  mRows = (frame.rows + kTile - 1) / kTile;
  mNearest.assign(static_cast<std::size_t>(mColumns) * mRows, kernels::kNeverBends);
  for (std::int32_t row = 0; row < frame.rows; ++row)
    for (std::int32_t column = 0; column < frame.columns; ++column) {
      float& nearest = mNearest[static_cast<std::size_t>(row / kTile) * mColumns + column / kTile];
      nearest = std::min(nearest, entry[static_cast<std::size_t>(row) * frame.columns + column]);
    }
}

bool ClearView::reaches(const Patch& patch, std::int32_t number, bool point, const Double3& light) const {
  Bounds bounds;
  for (const Double3& p : patch) bounds.add(p);
  return bendsNowhere(patch) && !isShadowed(bounds, number, point, light);
}

/// What a perspective or parallel projection makes of a parallelogram lies between the images of its corners.
bool ClearView::bendsNowhere(const Patch& patch) const {
  if (mNearest.empty()) return true;
  double u0 = 1e300, u1 = -1e300, v0 = 1e300, v1 = -1e300, farthest = 0;
  for (const Double3& p : patch) {
    const std::optional<RasterPlace> place = placeOnRaster(mFrame, p);
    if (!place) return false;
    u0 = std::min(u0, place->u), u1 = std::max(u1, place->u), v0 = std::min(v0, place->v), v1 = std::max(v1, place->v);
    farthest = std::max(farthest, place->depth - mFrame.depth0);
  }
  // A cell more on every side: what rounds to the next one.
  double c0 = (u0 - mFrame.u0) / mFrame.du - 1, c1 = (u1 - mFrame.u0) / mFrame.du + 1,
         r0 = (v0 - mFrame.v0) / mFrame.dv - 1, r1 = (v1 - mFrame.v0) / mFrame.dv + 1;
  if (mFrame.cubeFace && (c0 < 0 || r0 < 0 || c1 > mFrame.columns || r1 > mFrame.rows)) return false;
  if (c1 < 0 || r1 < 0 || c0 >= mFrame.columns || r0 >= mFrame.rows) return true; // beside the raster
  const auto tile = [](double cell, std::int32_t cells) {
    return static_cast<std::int32_t>(std::clamp(cell, 0.0, cells - 1.0)) / kTile;
  };
  for (std::int32_t row = tile(r0, mFrame.rows); row <= tile(r1, mFrame.rows); ++row)
    for (std::int32_t column = tile(c0, mFrame.columns); column <= tile(c1, mFrame.columns); ++column)
      if (mNearest[static_cast<std::size_t>(row) * mColumns + column] < farthest) return false;
  return true;
}

/// The patch's box, moved towards the light, against the others' boxes: the way of its middle against boxes as much
/// larger. On its way to a point a patch only shrinks.
bool ClearView::isShadowed(const Bounds& patch, std::int32_t number, bool point, const Double3& light) const {
  const Double3 middle = (patch.low + patch.high) * 0.5, half = (patch.high - patch.low) * 0.5;
  const Double3 way = point ? light - middle : -light;
  const double farthest = point ? 1 : 1e300;
  for (std::size_t i = 0; i < mReceivers.size(); ++i) {
    if (static_cast<std::int32_t>(i) == number) continue;
    double entry = 0, exit = farthest;
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kMargin = 0.01; // voxels
      const double low = mReceivers[i].low[axis] - half[axis] - kMargin - middle[axis],
                   high = mReceivers[i].high[axis] + half[axis] + kMargin - middle[axis];
      if (way[axis] == 0) {
        if (low > 0 || high < 0) exit = -1;
        continue;
      }
      const double a = low / way[axis], b = high / way[axis];
      entry = std::max(entry, std::min(a, b));
      exit = std::min(exit, std::max(a, b));
    }
    if (entry <= exit) return true;
  }
  return false;
}

} // namespace volcaustic
