// The bricks of a domain that a body can reach, and their samples.
#pragma once

#include "volcaustic/medium.h"
#include "volume/coverage_rows.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

/// Bricks of the domain that a box in world space meets, grown by `margin` voxels; empty when first > last somewhere.
struct BrickRange {
  Vec3i first, last;
  [[nodiscard]] bool empty() const { return first[0] > last[0] || first[1] > last[1] || first[2] > last[2]; }
};
inline BrickRange bricksMet(const Box& box, double margin, const Domain& domain) {
  BrickRange range{};
  for (int a = 0; a < 3; ++a) {
    const double bricks = (domain.dims[a] + 7) / 8;
    const auto brickAt = [&](double p) {
      return std::floor((p - domain.minCorner[a]) / domain.voxelSize / kBrickSize);
    };
    const double grow = margin / kBrickSize;
    range.first[a] = static_cast<int>(std::clamp(brickAt(box.min[a]) - std::ceil(grow), 0.0, bricks));
    range.last[a] = static_cast<int>(std::clamp(brickAt(box.max[a]) + std::ceil(grow), -1.0, bricks - 1));
  }
  return range;
}

inline SubLattice latticeOf(const BrickRange& range, const Domain& domain, int supersample) {
  SubLattice lattice;
  lattice.corner = domain.minCorner;
  lattice.scale = supersample / domain.voxelSize;
  while (1 << lattice.log2 < supersample) ++lattice.log2;
  for (int a = 0; a < 3; ++a) {
    lattice.first[a] = range.first[a] * lattice.brickSamples();
    lattice.size[a] = (range.last[a] - range.first[a] + 1) * lattice.brickSamples();
  }
  return lattice;
}

} // namespace volcaustic
