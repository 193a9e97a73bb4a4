// Neighbours of a raster four by four: those that landed beside each other are the corners of a beam.
#pragma once

#include "kernels/emission.h"
#include "transport/landed_cells.h"

#include <array>
#include <cstdint>
#include <vector>

namespace volcaustic {

/// The cells around a corner of the raster: (0, 0), (1, 0), (0, 1), (1, 1) seen from the first, which may be in column
/// or row -1. Null: nothing landed.
using LandingQuad = std::array<const LandedCell*, 4>;

/// A quad's two triangles, by the numbers of their corners, and their parts of a cell on the raster.
struct QuadTriangles {
  std::array<std::array<int, 3>, 2> corners;
  std::array<double, 2> areas;
};

class LandingQuads {
public:
  LandingQuads(const ReceiverSet& set, const kernels::EmissionFrame& frame, std::span<const kernels::Landing> landings,
               const RunContext& ctx);

  [[nodiscard]] const LandedCells& cells() const { return mCells; }
  /// What would lie between landings that were spread evenly over all texels, in texels; 0 where nothing landed.
  [[nodiscard]] double spacing() const { return mSpacing; }
  /// Rows -1 to rows() - 2.
  [[nodiscard]] std::int32_t rows() const { return static_cast<std::int32_t>(mRows.size()); }
  /// Of a row: from the first that has a cell which landed to the last.
  [[nodiscard]] LandedCells::Columns columnsOf(std::int32_t row) const {
    return {mRows[row + 1].begin, mRows[row + 1].end};
  }
  [[nodiscard]] LandingQuad at(std::int32_t column, std::int32_t row) const {
    return {mCells.at(column, row), mCells.at(column + 1, row), mCells.at(column, row + 1),
            mCells.at(column + 1, row + 1)};
  }
  /// Whether a quad is a beam: all landed on one chart, no edge is stretched many times as much as those beside it in
  /// its row or column, and it is not so large that the next quads would tell nothing of it.
  [[nodiscard]] bool isBeam(const LandingQuad& quad, std::int32_t column, std::int32_t row) const;
  /// What isBeam said, kept.
  [[nodiscard]] std::uint8_t& torn(std::int32_t column, std::int32_t row) {
    const Row& r = mRows[row + 1];
    return mTorn[r.first + static_cast<std::size_t>(column - r.begin)];
  }

  /// The texels of a beam.
  [[nodiscard]] TexelRange boxOf(const LandingQuad& beam) const;
  /// Rays anywhere in their cells make quads of any shape: the diagonal is taken that leaves the larger of the smaller
  /// triangles, so neither is turned inside out.
  [[nodiscard]] QuadTriangles trianglesOf(std::int32_t column, std::int32_t row) const;
  /// How far the power of a photon is spread that has no beam, in texels: to those beside it on the raster, as far as
  /// they are near.
  [[nodiscard]] double tentOf(const LandedCell& cell, std::int32_t column, std::int32_t row) const;

private:
  struct Edge {
    std::int32_t column, row, toColumn, toRow;
  };
  /// How much farther apart than on the raster two photons landed, squared; texels to a cell.
  [[nodiscard]] double squaredStretch(const LandedCell& a, const LandedCell& b) const;
  /// The larger one of the next two edges in a direction from a cell, or of those that there are; negative for none.
  [[nodiscard]] double stretchBeyond(const LandedCell& from, std::int32_t column, std::int32_t row, std::int32_t dc,
                                     std::int32_t dr) const;
  [[nodiscard]] bool isTear(const LandedCell& a, const LandedCell& b, const Edge& edge) const;

  struct Row {
    std::int32_t begin, end;
    std::size_t first;
  };
  const ReceiverSet& mSet;
  const kernels::EmissionFrame& mFrame;
  const kernels::Landing* mFirst;
  LandedCells mCells;
  std::vector<Row> mRows;
  std::vector<std::uint8_t> mTorn; ///< of each quad: 1 where it is no beam
  double mSpacing = 0;
};

} // namespace volcaustic
