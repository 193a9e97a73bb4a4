// The cells of a raster whose photons landed, row by row.
#pragma once

#include "kernels/receivers.h"
#include "transport/receiver_set.h"

#include <cstdint>
#include <span>
#include <vector>

namespace volcaustic {

/// Where a photon landed.
struct LandedCell {
  float column, row;  ///< on its chart
  std::int32_t chart; ///< -1: the photon did not land
  const kernels::Landing* landing;

  [[nodiscard]] MapPoint point() const { return {column, row}; }
  [[nodiscard]] kernels::Double3 power() const { return {landing->power[0], landing->power[1], landing->power[2]}; }
};

/// Of each row, from the first cell that landed to the last.
class LandedCells {
public:
  /// \throws Error(Input) beyond the context's memory.
  LandedCells(const ReceiverSet& set, std::int32_t columns, std::int32_t rows,
              std::span<const kernels::Landing> landings, const RunContext& ctx);

  [[nodiscard]] std::int32_t rows() const { return static_cast<std::int32_t>(mRows.size()); }
  [[nodiscard]] std::int64_t landed() const { return mLanded; }
  /// Null where there is no cell, and where nothing landed.
  [[nodiscard]] const LandedCell* at(std::int32_t column, std::int32_t row) const {
    if (row < 0 || row >= rows()) return nullptr;
    const Row& r = mRows[row];
    if (column < r.begin || column >= r.end) return nullptr;
    const LandedCell& cell = mCells[r.first + static_cast<std::size_t>(column - r.begin)];
    return cell.chart < 0 ? nullptr : &cell;
  }

  struct Columns {
    std::int32_t begin, end;
  };
  /// Of a row; empty beyond the raster.
  [[nodiscard]] Columns columnsOf(std::int32_t row) const {
    return row < 0 || row >= rows() ? Columns{0, 0} : Columns{mRows[row].begin, mRows[row].end};
  }

private:
  struct Row {
    std::int32_t begin = 0, end = 0;
    std::size_t first = 0;
    std::int32_t landed = 0;
  };
  std::vector<Row> mRows;
  LargeVector<LandedCell> mCells;
  std::int64_t mLanded = 0;
};

} // namespace volcaustic
