// Cuts triangles along the level curve of a function of space.
#pragma once

#include "mesh/topology.h"

#include <functional>
#include <vector>

namespace volcaustic {

/// What is left of a triangle: corners `first` and, where two corners are left, `second`; then the cut from `from` to
/// `to`, and back.
struct CutTriangle {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::uint32_t first, second, from, to;
  std::uint32_t source; ///< index of the triangle
};

struct CutTriangles {
  std::vector<std::uint32_t> whole; ///< indices of triangles that no cut touches
  std::vector<CutTriangle> cut;
};

/// What of the triangles is where `level` is negative, or with `keepsNegative` false where it is not. Vertices on cut
/// edges are appended to `positions`, one for each edge.
CutTriangles cutTriangles(const std::vector<TriangleCorners>& triangles, std::vector<Vec3d>& positions,
                          bool keepsNegative, const std::function<double(const Vec3d&)>& level);

/// The cuts as closed curves of vertices. False where they branch or end.
bool curvesOf(const std::vector<CutTriangle>& cuts, std::vector<std::vector<std::uint32_t>>& curves);

} // namespace volcaustic
