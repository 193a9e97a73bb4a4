// Coverage of a mesh, column of bricks by column, on the CPU.
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/mesh.h"
#include "volume/cap_offsets.h"
#include "volume/coverage_rows.h"
#include "volume/winding.h"

#include <span>
#include <string>
#include <vector>

namespace volcaustic {

/// The triangles of a mesh and of the caps that close it, on the lattice.
class LatticeTriangles {
public:
  using Corners = std::array<std::uint32_t, 3>;

  LatticeTriangles(const Mesh& mesh, const LoopCaps& caps, const SubLattice& lattice, const RunContext& ctx);

  /// Three numbers a vertex.
  [[nodiscard]] const double* points() const { return mPoints.data(); }
  [[nodiscard]] std::span<const Corners> corners() const { return mCorners; }

private:
  std::vector<double> mPoints;
  std::vector<Corners> mJoined;
  std::span<const Corners> mCorners;
};

/// Adds the coverage of what the triangles enclose to a grid of the lattice's bricks, all of them 0; `offsets` are
/// added to winding numbers, or null. \throws Error(Input), naming `what`, beyond the memory limit.
void coverColumns(const LatticeTriangles& triangles, const CapOffsets* offsets, const SubLattice& lattice,
                  const std::string& what, BrickGrid<float>& coverage, const RunContext& ctx);

} // namespace volcaustic
