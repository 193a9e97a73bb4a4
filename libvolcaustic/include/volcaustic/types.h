/// \file types.h
/// The few value types that every public header shares. Standard library only.
#pragma once

#include <array>
#include <cstdint>

namespace volcaustic {

using Vec3d = std::array<double, 3>;
using Vec3f = std::array<float, 3>;
using Vec3i = std::array<int, 3>;
/// Spectra are Rec. 709 linear RGB triples.
using Rgb = std::array<double, 3>;
/// Row-major affine placement of points: pWorld = matrix * (pLocal, 1). The last row of 0 0 0 1 is implied.
using Affine = std::array<std::array<double, 4>, 3>;

inline constexpr Affine kIdentity{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

/// An axis-aligned box in world space.
struct Box {
  Vec3d min{0, 0, 0};
  Vec3d max{0, 0, 0};
};

/// A regular lattice of cubic voxels in world space. Voxel (i, j, k), 0 <= i < dims[0] and so on, is the cube
/// from minCorner + voxelSize*(i, j, k) to minCorner + voxelSize*(i+1, j+1, k+1). In the OpenVDB grids of a domain that
/// voxel has index coordinate (i, j, k), so the grid transform maps index 0 to minCorner + voxelSize/2.
struct Domain {
  Vec3d minCorner{0, 0, 0};
  double voxelSize = 1;
  Vec3i dims{0, 0, 0};

  [[nodiscard]] Vec3d maxCorner() const {
    return {minCorner[0] + voxelSize * dims[0], minCorner[1] + voxelSize * dims[1], minCorner[2] + voxelSize * dims[2]};
  }
  [[nodiscard]] std::int64_t voxelCount() const { return std::int64_t{dims[0]} * dims[1] * dims[2]; }
};

} // namespace volcaustic
