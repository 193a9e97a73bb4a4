// The crossings of a column of bricks with the triangles of a mesh, as bits: for each brick that has some, two bits a
// sample, which say that the winding number rises or falls there by one.
#pragma once

#include "kernels/rows.h"

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace volcaustic {

/// Triangles of a mesh against the rows of a column of bricks.
struct RowsTask {
  const double* points; ///< three a vertex: whole numbers of lattice units (kernels/rows.h)
  const std::array<std::uint32_t, 3>* triangles;
  const std::uint32_t* ids; ///< which of them
  std::int64_t count;
  kernels::RowColumn column;
  kernels::RowRect box; ///< the rows of the column, as a rectangle
  bool reversed;        ///< counts every crossing the other way
};

/// Rows that sweepRows() carries through a brick. Word is as wide as a row needs: 32 bits, or 64 at 8 sub-voxels.
template <class Word>
struct RowSweep {
  const Word *rises, *falls;
  std::make_signed_t<Word>* winding; ///< before the brick; becomes the number after it
  Word* inside;                      ///< bit k of a row: sample k is inside
  std::uint16_t* irregular;          ///< room for all rows
  int rows;                          ///< a multiple of 64
  int samples;                       ///< along a row, in the brick
  int offset;                        ///< added to the winding numbers
};

/// One column's bricks at a time; the room is used again for the next one.
class RowPages {
public:
  /// For columns of `bricks` bricks with 2^log2 sub-voxels along a voxel's edge.
  RowPages(int bricks, int log2);

  /// Appends crossings of the column, in any order.
  void add(const kernels::Crossing* crossings, int count);
  [[nodiscard]] bool empty() const { return mUsedWords == 0; }
  [[nodiscard]] bool touched(int brick) const { return mPages[brick] >= 0; }
  /// The rows' bits of a touched brick: those that rise, then those that fall. \pre Word fits log2
  template <class Word>
  [[nodiscard]] Word* page(int brick) {
    return reinterpret_cast<Word*>(mWords.data() + std::size_t(mPages[brick]) * kPageUnit);
  }
  /// Crossings that found their bit taken: a second one of the same sign at the same sample. Sorted by brick and row
  /// once sortExtra() was called.
  [[nodiscard]] std::span<const kernels::Crossing> extra() const { return mExtra; }
  void sortExtra();
  /// Forgets all.
  void clear();

private:
  template <class Word>
  void addAs(const kernels::Crossing* crossings, int count);
  std::int32_t touch(int brick);

  bool mWide;
  int mRows;
  /// Pages are whole numbers of 64 words of 64 bits: two bits for each of 64 rows and more.
  static constexpr std::size_t kPageUnit = 64;
  std::size_t mPageWords, mUsedWords = 0;
  std::vector<std::int32_t> mPages; // where the bricks' pages begin, in page units; -1 for none
  std::vector<std::uint64_t> mWords;
  std::vector<kernels::Crossing> mExtra;
};

/// crossRows() of the task's number `i`, one row at a time and however large the triangle.
void crossRowsOf(const RowsTask& task, std::int64_t i, RowPages& pages);

/// The rows of the task's column that the rectangle around a triangle holds samples of.
kernels::RowRect rowsAround(const RowsTask& task, std::int64_t i);

/// crossRows() and sweepRows() of lanes.h, one by one: the reference.
void crossRowsOneByOne(const RowsTask& task, RowPages& pages);
int sweepRowsOneByOne(const RowSweep<std::uint32_t>& sweep);
int sweepRowsOneByOne(const RowSweep<std::uint64_t>& sweep);

} // namespace volcaustic
