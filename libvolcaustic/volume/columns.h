// Coverage of a mesh, column of bricks by column, on the CPU.
#pragma once

#include "core/brick_grid.h"
#include "volume/cap_offsets.h"
#include "volume/column_bins.h"

#include <string>

namespace volcaustic {

/// Adds the coverage of what the triangles enclose to a grid of the lattice's bricks, all of them 0; `offsets` are
/// added to winding numbers, or null. \throws Error(Input), naming `what`, beyond the memory limit.
void coverColumns(const LatticeTriangles& triangles, const CapOffsets* offsets, const SubLattice& lattice,
                  const std::string& what, BrickGrid<float>& coverage, const RunContext& ctx);

} // namespace volcaustic
