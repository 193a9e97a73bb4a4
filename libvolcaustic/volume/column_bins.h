// Triangles on the lattice of sub-voxels, and which of them meet which column of bricks.
#pragma once

#include "backends/row_pages.h"
#include "core/large_memory.h"
#include "volcaustic/mesh.h"
#include "volume/coverage_rows.h"
#include "volume/winding.h"

#include <array>
#include <cstdint>
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
  LargeVector<double> mPoints;
  std::vector<Corners> mJoined;
  std::span<const Corners> mCorners;
};

/// The triangles of each column of bricks: a counting sort.
class ColumnBins {
public:
  /// \throws Error(Input), naming `what`, beyond the memory limit.
  ColumnBins(const LatticeTriangles& triangles, const SubLattice& lattice, const std::string& what,
             const RunContext& ctx);

  [[nodiscard]] std::int64_t size() const { return std::int64_t{mColumns[0]} * mColumns[1]; }
  [[nodiscard]] std::array<int, 2> coord(std::int64_t column) const {
    return {static_cast<int>(column / mColumns[1]), static_cast<int>(column % mColumns[1])};
  }
  /// Whether winding numbers are -1 inside rather than 1, as they are of a mesh that is inside out: lanes are at their
  /// best with 0 and 1.
  [[nodiscard]] bool facesInwards() const { return mVolume < 0; }
  /// The task of a column's triangles.
  [[nodiscard]] RowsTask task(std::int64_t column) const;

private:
  struct Entry {
    std::uint32_t column, triangle;
  };
  /// A part of the triangles, which is sorted on its own.
  struct Part {
    LargeVector<Entry> entries;
    std::vector<std::uint32_t> counts; ///< of each column; then where in it the next entry goes
    double volume = 0; ///< six times that under the triangles, of which only the sign of the sum matters
  };
  struct Span;

  void find(std::int64_t begin, std::int64_t end, Part& part) const;
  void addSpread(std::int64_t triangle, const Span& span, Part& part) const;
  void sort(std::vector<Part>& parts, const std::string& what, const RunContext& ctx);

  const LatticeTriangles& mTriangles;
  SubLattice mLattice;
  std::array<int, 2> mColumns;
  double mVolume = 0;
  std::vector<std::uint64_t> mStart;
  LargeVector<std::uint32_t> mIds;
};

} // namespace volcaustic
