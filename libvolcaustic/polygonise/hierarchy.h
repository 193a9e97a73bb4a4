// The blocks of cells that a surface may pass through, each with what of the shape matters there.
#pragma once

#include "shapes/program.h"
#include "volcaustic/run_context.h"

#include <cstdint>
#include <vector>

namespace volcaustic {

/// Cells along the edge of a block, and points of the lattice along it.
inline constexpr int kBlockCells = 8, kBlockPoints = kBlockCells + 1;

/// Points of the lattice are at whole multiples of the cell size, so that it stays where it is when a shape moves in
/// it.
inline double latticeCoordinate(std::int64_t i, double cellSize) { return static_cast<double>(i) * cellSize; }

struct SurfaceBlock {
  Vec3i coord;          ///< in blocks: its first cell is at kBlockCells times that
  ShapeProgram program; ///< that holds in the block and two cells around it
  std::uint64_t hash;   ///< of the program
};

/// In order of z, y and x. \throws Error(Input) for more than 32768 cells along an axis, or more than memory holds
std::vector<SurfaceBlock> surfaceBlocks(const ShapeProgram& program, const Box& bounds, double cellSize,
                                        const RunContext& ctx);

/// Whether surfaceBlocks() can take cells of that size.
bool latticeHolds(const Box& bounds, double cellSize);

} // namespace volcaustic
