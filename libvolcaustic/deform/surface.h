// What deformation reads of a mesh: the surface with points of equal position welded, so that triangles without shared
// vertices deform without cracks.
#pragma once

#include "mesh/topology.h"

#include <cstdint>
#include <span>
#include <vector>

namespace volcaustic {

/// Lists of numbers, one for each point, in one piece of memory.
struct PointLists {
  std::vector<std::uint32_t> start{0}; ///< one more than there are points
  std::vector<std::uint32_t> entries;

  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t point) const {
    return std::span(entries).subspan(start[point], start[point + 1] - start[point]);
  }
};

struct DeformSurface {
  std::vector<std::uint32_t> pointOf;     ///< of each vertex of the mesh
  std::vector<Vec3d> points;              ///< at rest
  std::vector<TriangleCorners> triangles; ///< over points; without those of a repeated corner
  PointLists trianglesOf;
  PointLists neighbours;
  /// Of each entry of `neighbours`: half the sum of the cotangents opposite the edge at rest, held between bounds that
  /// keep every weight positive (kLeastWeight, kMostWeight), so that systems of them are positive definite.
  std::vector<double> weights;
  std::vector<std::uint32_t> component; ///< of each point: what hangs together over edges
  std::uint32_t componentCount = 0;
  std::vector<bool> onBorder; ///< ends an edge of one triangle

  static constexpr double kLeastWeight = .01, kMostWeight = 100;
};

/// \param mesh as requireValid() takes it
DeformSurface makeDeformSurface(const Mesh& mesh);

} // namespace volcaustic
