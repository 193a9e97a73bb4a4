// Where the surface of a receiver lies in its map.
#pragma once

#include "kernels/vec.h"
#include "transport/texel_cover.h"
#include "volcaustic/mesh.h"

#include <string>
#include <vector>

namespace volcaustic {

/// Charts are pieces of surface that are mapped as a whole, by one affine map; each has a rectangle of texels for
/// itself.
struct ReceiverAtlas {
  std::int32_t columns = 0, rows = 0;
  std::vector<TexelRange> charts;
  std::vector<std::int32_t> chartOf; ///< of each triangle; -1 for one without area, or the same as an earlier one
  std::vector<MapTriangle> texels;   ///< of each triangle
};

/// A triangle's unit normal, and its area; zeros where it has none that numbers can tell.
struct TrianglePlane {
  kernels::Double3 normal{0, 0, 0};
  double area = 0;
};
TrianglePlane planeOf(const Mesh& mesh, std::size_t triangle);

/// A parallelogram of two triangles (corners 0, 1, 2 and 0, 2, 3), counter-clockwise from its lower left: one chart,
/// with square texels or nearly so, `resolution` along the longer side.
ReceiverAtlas rectangleAtlas(const Mesh& rectangle, int resolution);

/// Triangles that hang together over edges and face about the same way (53 degrees at most) are projected onto a plane,
/// so the texels of a chart stand for areas that differ by a factor of 1.7 at most. Charts of one scale are packed into
/// a square of `resolution` texels along a side, more where they are too many for it. A border of one texel around each
/// keeps bilinear lookups inside. \throws Error(Input) "place: ..." where even the largest map is too small.
ReceiverAtlas meshAtlas(const Mesh& mesh, int resolution, const std::string& place, const RunContext& ctx);

} // namespace volcaustic
