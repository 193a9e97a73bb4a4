#include "polygonise/pinches.h"

#include <algorithm>
#include <map>

namespace volcaustic {

namespace {

using CellKey = std::array<int, 3>; // z, y, x in the lattice

CellKey keyOf(const SurfaceBlock& block, int cell) {
  return {block.coord[2] * kBlockCells + cell / (kBlockCells * kBlockCells),
          block.coord[1] * kBlockCells + cell / kBlockCells % kBlockCells,
          block.coord[0] * kBlockCells + cell % kBlockCells};
}
CellKey below(CellKey cell, int axis) {
  --cell[2 - axis];
  return cell;
}

struct Cell {
  std::size_t block;
  std::uint16_t cell;
  unsigned inside, joined, flipped;

  [[nodiscard]] bool isPinchedAt(int face) const { return facesOfOnePatch(inside, joined) >> face & 1; }
  void flip(int face) {
    joined ^= 1u << face;
    flipped ^= 1u << face;
  }
};

} // namespace

std::vector<BlockFlips> pinchedFaces(std::span<const SurfaceBlock> blocks,
                                     std::span<const std::shared_ptr<const BlockSurface>> surfaces) {
  std::map<CellKey, Cell> cells;
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (const PinchedCell& p : surfaces[b]->pinched)
      cells.emplace(keyOf(blocks[b], p.cell), Cell{b, p.cell, p.inside, p.joined, 0});
  for (auto& [key, high] : cells)
    for (int axis = 0; axis < 3; ++axis) {
      const auto low = cells.find(below(key, axis));
      if (low == cells.end() || !high.isPinchedAt(2 * axis) || !low->second.isPinchedAt(2 * axis + 1)) continue;
      high.flip(2 * axis);
      low->second.flip(2 * axis + 1);
    }
  std::vector<Cell> flipped;
  for (const auto& [key, cell] : cells)
    if (cell.flipped != 0) flipped.push_back(cell);
  std::sort(flipped.begin(), flipped.end(),
            [](const Cell& a, const Cell& b) { return std::pair(a.block, a.cell) < std::pair(b.block, b.cell); });
  std::vector<BlockFlips> flips;
  for (const Cell& cell : flipped) {
    if (flips.empty() || flips.back().block != cell.block) flips.push_back({cell.block, {}});
    flips.back().faces.push_back({cell.cell, static_cast<std::uint8_t>(cell.flipped)});
  }
  return flips;
}

} // namespace volcaustic
