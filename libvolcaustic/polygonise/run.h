// A shape polygonised with cells of a given size.
#pragma once

#include "polygonise/store.h"
#include "volcaustic/polygonise.h"

namespace volcaustic {

/// What stays the same for all sizes of cells.
struct PolygoniseJob {
  ShapeProgram program;
  Box bounds;
  BlockStore& store;
  const RunContext& ctx;
  std::uint64_t evaluations = 0; ///< so far

  [[nodiscard]] double longestSide() const;
};

struct PolygoniseResult {
  Mesh mesh;
  PolygoniseReport report; ///< its evaluations are those of this size of cells
};
PolygoniseResult polygoniseAt(PolygoniseJob& job, double cellSize);

/// As many triangles as polygoniseAt() would make.
std::uint64_t countTriangles(PolygoniseJob& job, double cellSize);

} // namespace volcaustic
