// Winding numbers of closed shells at the nodes of a lattice, from their crossings with the lattice's columns.
#pragma once

#include "mesh/topology.h"
#include "volcaustic/run_context.h"

#include <span>
#include <vector>

namespace volcaustic {

/// Node (i, j, k) of the lattice is at voxelSize * (i, j, k). Every column of nodes along z knows where it passes
/// through a triangle, so a winding number is exact, whatever else the shells run through.
class WindingColumns {
public:
  struct Crossing {
    float z;  ///< in voxels
    int turn; ///< what the winding number changes by, going up
  };

  /// Of triangles over welded vertices. \throws Error(Input) for more columns than memory.
  WindingColumns(std::span<const Vec3d> positions, std::span<const TriangleCorners> triangles, double voxelSize,
                 const RunContext& ctx);

  [[nodiscard]] int at(int i, int j, int k) const;
  /// From below upwards.
  [[nodiscard]] std::span<const Crossing> column(int i, int j) const;
  /// Columns that may cross something are from `first` on, `size` of them along x and y.
  [[nodiscard]] const std::array<int, 2>& first() const { return mFirst; }
  [[nodiscard]] const std::array<int, 2>& size() const { return mSize; }

private:
  template <class Visit>
  void forCrossings(std::span<const Vec3d> positions, std::span<const TriangleCorners> triangles, double voxelSize,
                    Visit visit) const;

  std::array<int, 2> mFirst{0, 0}, mSize{0, 0};
  std::vector<std::uint32_t> mBegin;
  std::vector<Crossing> mCrossings;
};

} // namespace volcaustic
