// Polygons into triangles.
#pragma once

#include "volcaustic/types.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace volcaustic {

/// Corners that a polygon which is not convex may have: ear clipping takes quadratic time, and no real face comes near.
inline constexpr std::size_t kMaxConcaveCorners = 16384;

/// Splits simple polygons, one after another, keeping its scratch memory. Deterministic.
class PolygonTriangulator {
public:
  /// Writes corners.size() - 2 triangles of corner numbers into the result, wound as the polygon is. A polygon that is
  /// convex in its plane (Newell's normal) is split as a fan around its first corner, any other one by ear clipping (G.
  /// Meisters, "Polygons have ears", 1975; D. Eberly, "Triangulation by Ear Clipping"), which also takes holes that are
  /// joined to the outline by a bridge of doubled corners. A polygon that crosses itself or has no area is split too:
  /// its signed area is kept, whatever its triangles overlap. An empty result says that the polygon is not convex and
  /// has more than kMaxConcaveCorners corners.
  std::span<const std::array<std::uint32_t, 3>> triangulate(std::span<const Vec3d> corners);

private:
  using Point = std::array<double, 2>;

  /// Projects along the main axis of the normal, so that the polygon runs counter-clockwise. False when it has no area.
  bool project(std::span<const Vec3d> corners);
  [[nodiscard]] bool isConvex() const;
  void fan(std::uint32_t count);
  void clipEars();
  [[nodiscard]] double turn(std::uint32_t corner) const;
  void classify(std::uint32_t corner);
  [[nodiscard]] bool isEar(std::uint32_t corner) const;
  [[nodiscard]] std::uint32_t pickCorner(std::uint32_t start) const;

  std::vector<std::array<std::uint32_t, 3>> mTriangles;
  std::vector<Point> mPoints;
  std::vector<std::uint32_t> mPrevious, mNext; // the outline that is left, as a ring of corners
  std::vector<std::uint32_t> mReflex;          // corners that were reflex or flat at the start
  std::vector<std::uint8_t> mIsReflex, mIsEar;
};

} // namespace volcaustic
