#include "transport/landed_cells.h"

#include "core/parallel.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

LandedCells::LandedCells(const ReceiverSet& set, std::int32_t columns, std::int32_t rows,
                         std::span<const kernels::Landing> landings, const RunContext& ctx)
    : mRows(static_cast<std::size_t>(rows)) {
  const auto triangles = static_cast<std::int32_t>(set.triangles().size());
  const auto landed = [&](const kernels::Landing& l) {
    return l.triangle >= 0 && l.triangle < triangles && std::isfinite(l.column) && std::isfinite(l.row);
  };
  const auto rowOf = [&](std::int64_t r) { return landings.data() + r * columns; };
  parallelFor(rows, 16, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t r = begin; r < end; ++r) {
      const kernels::Landing* row = rowOf(r);
      std::int32_t first = 0, beyond = columns;
      while (first < beyond && !landed(row[first])) ++first;
      while (beyond > first && !landed(row[beyond - 1])) --beyond;
      mRows[r] = {first, beyond, 0, 0};
    }
  });
  std::size_t cells = 0;
  for (Row& r : mRows) {
    r.first = cells;
    cells += static_cast<std::size_t>(r.end - r.begin);
  }
  ctx.requireMemory(cells * (sizeof(LandedCell) + 1), "receivers: photons that landed"); // and a flag for each
  mCells.resize(cells);
  parallelFor(rows, 16, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      Row& r = mRows[i];
      for (std::int32_t c = r.begin; c < r.end; ++c) {
        const kernels::Landing& l = rowOf(i)[c];
        LandedCell& cell = mCells[r.first + static_cast<std::size_t>(c - r.begin)];
        if (!landed(l)) {
          cell = {0, 0, -1, nullptr};
          continue;
        }
        const std::int32_t chart = set.chartOf(l.triangle);
        const TexelRange& t = set.charts()[chart].texels; // rounding may have left it
        cell = {std::clamp(l.column, float(t.column), float(t.column + t.columns)),
                std::clamp(l.row, float(t.row), float(t.row + t.rows)), chart, &l};
        ++r.landed;
      }
    }
  });
  for (const Row& r : mRows) mLanded += r.landed;
}

} // namespace volcaustic
