// Rows of sub-voxels on a CUDA device: their crossings with triangles as bits, the winding numbers along them, and the
// samples inside each voxel. The arithmetic is that of kernels/rows.h; only who does what is decided here.
//
//   touched bricks    numbered in order; each has a page: a word a row of bits that rise, then a word a row that fall
//   extra crossings   those that found their bit taken, sorted by brick and row
//   columns           a block of threads each; a thread keeps the winding numbers of its rows from brick to brick
#pragma once

#include "kernels/painting.h"
#include "kernels/rows.h"

#include <cuda_runtime.h>
#include <type_traits>

namespace volcaustic {

/// Rows that a thread tries for one triangle at most.
inline constexpr int kRowsOfItem = 64;
using kernels::BrickFill;
using kernels::kVoxelsOfBrick;

struct DeviceMesh {
  const double* points;             ///< three a vertex
  const std::uint32_t* triangles;   ///< three vertices each
  const std::int64_t* firstOfItems; ///< of each triangle, and the number of all
  std::int64_t count;               ///< of triangles
};

struct DeviceLattice {
  std::int32_t bricksX, bricksY, bricksZ;
  std::int32_t log2;

  [[nodiscard]] VOLCAUSTIC_HD int brickLog2() const { return 3 + log2; }
  [[nodiscard]] VOLCAUSTIC_HD std::int64_t columns() const { return std::int64_t{bricksX} * bricksY; }
  [[nodiscard]] VOLCAUSTIC_HD std::int64_t bricks() const { return columns() * bricksZ; }
  [[nodiscard]] VOLCAUSTIC_HD kernels::RowColumn column(int x, int y) const {
    return {x << brickLog2(), y << brickLog2(), log2, bricksZ << brickLog2()};
  }
};

/// The rows that may cross a triangle, and the longer side of the rectangle around it.
struct TriangleRows {
  kernels::RowRect rect;
  double extent;
};

__device__ inline const double* cornerOf(const DeviceMesh& mesh, std::int64_t triangle, int corner) {
  return mesh.points + 3 * static_cast<std::int64_t>(mesh.triangles[3 * triangle + corner]);
}

__device__ inline TriangleRows rowsOf(const DeviceMesh& mesh, const DeviceLattice& lattice, std::int64_t triangle) {
  const double *a = cornerOf(mesh, triangle, 0), *b = cornerOf(mesh, triangle, 1), *c = cornerOf(mesh, triangle, 2);
  const auto low = [&](int axis) { return kernels::smaller(kernels::smaller(a[axis], b[axis]), c[axis]); };
  const auto high = [&](int axis) { return kernels::larger(kernels::larger(a[axis], b[axis]), c[axis]); };
  const std::int32_t inset = kernels::stagger(0, lattice.log2), shift = lattice.brickLog2();
  const kernels::RowRange x = kernels::rowRange(low(0), high(0), inset, 0, (lattice.bricksX << shift) - 1);
  const kernels::RowRange y = kernels::rowRange(low(1), high(1), inset, 0, (lattice.bricksY << shift) - 1);
  TriangleRows rows{{x.first, y.first, x.last, y.last}, kernels::larger(high(0) - low(0), high(1) - low(1))};
  // Beyond the rows' far ends nothing is crossed.
  if (low(2) > (lattice.bricksZ << shift) * kernels::kFixedOne) rows.rect.x1 = rows.rect.x0 - 1;
  return rows;
}

/// A triangle's work in items of few rows: the whole rectangle, or a part of one of its lines.
struct RowItems {
  kernels::RowRect rect;
  std::int64_t width, height;

  __device__ explicit RowItems(const kernels::RowRect& r)
      : rect(r), width(std::int64_t{r.x1} - r.x0 + 1), height(std::int64_t{r.y1} - r.y0 + 1) {}
  [[nodiscard]] __device__ bool whole() const { return width * height <= kRowsOfItem; }
  [[nodiscard]] __device__ std::int64_t partsOfLine() const { return (height + kRowsOfItem - 1) / kRowsOfItem; }
  [[nodiscard]] __device__ std::int64_t count() const { return rect.empty() ? 0 : whole() ? 1 : width * partsOfLine(); }
  [[nodiscard]] __device__ kernels::RowRect at(std::int64_t item) const {
    if (whole()) return rect;
    const auto x = rect.x0 + static_cast<std::int32_t>(item / partsOfLine());
    const auto y = rect.y0 + static_cast<std::int32_t>(item % partsOfLine()) * kRowsOfItem;
    return {x, y, x, kernels::smaller(y + kRowsOfItem - 1, rect.y1)};
  }
};

/// The numbers that compute exactly with a triangle of this extent: 0 doubles, 1 64-bit and 2 128-bit integers.
template <class N>
inline constexpr int kNumbers = std::is_same_v<N, double>         ? 0
                                : std::is_same_v<N, std::int64_t> ? 1
                                                                  : 2;
__device__ inline int numbersFor(double extent) {
  return extent < kernels::kExactInDoubles ? 0 : extent < kernels::kExactInInt64 ? 1 : 2;
}

/// Writes each triangle's number of items, and the kinds of numbers that all of them need as bits.
static __global__ void countItems(DeviceMesh mesh, DeviceLattice lattice, std::int64_t* counts, unsigned* numbers) {
  const std::int64_t triangle = blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (triangle >= mesh.count) return;
  const TriangleRows rows = rowsOf(mesh, lattice, triangle);
  const std::int64_t count = RowItems(rows.rect).count();
  counts[triangle] = count;
  const unsigned bit = 1u << numbersFor(rows.extent);
  if (count > 0 && !(*static_cast<volatile unsigned*>(numbers) & bit)) atomicOr(numbers, bit);
}

/// The triangle that an item belongs to.
__device__ inline std::int64_t triangleOf(const DeviceMesh& mesh, std::int64_t item) {
  std::int64_t low = 0, high = mesh.count; // firstOfItems[low] <= item < firstOfItems[high]
  while (high - low > 1) {
    const std::int64_t middle = low + (high - low) / 2;
    (mesh.firstOfItems[middle] <= item ? low : high) = middle;
  }
  return low;
}

/// Calls visit(column, crossing) for the crossings of items [first, end) whose triangles need numbers of type N.
template <class N, class Visit>
__global__ void crossItems(DeviceMesh mesh, DeviceLattice lattice, std::int64_t first, std::int64_t end, Visit visit) {
  const std::int64_t item = first + blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (item >= end) return;
  const std::int64_t number = triangleOf(mesh, item);
  const TriangleRows rows = rowsOf(mesh, lattice, number);
  if (numbersFor(rows.extent) != kNumbers<N>) return;
  const auto corner = [&](int c) {
    const double* p = cornerOf(mesh, number, c);
    return kernels::Vec3<N>(static_cast<N>(p[0]), static_cast<N>(p[1]), static_cast<N>(p[2]));
  };
  const kernels::RowTriangle<N> triangle(corner(0), corner(1), corner(2));
  if (triangle.flat()) return;
  const RowItems items(rows.rect);
  const kernels::RowRect rect = items.at(item - mesh.firstOfItems[number]);
  const auto at = [](std::int32_t row) { return N(row) * N(1 << kernels::kFixedBits); };
  if (!items.whole() && !triangle.mayCross(at(rect.x0), at(rect.y0), at(rect.x1 + 1), at(rect.y1 + 1))) return;
  const int shift = lattice.brickLog2();
  for (int i = rect.x0 >> shift; i <= rect.x1 >> shift; ++i)
    for (int j = rect.y0 >> shift; j <= rect.y1 >> shift; ++j) {
      const kernels::RowColumn column = lattice.column(i, j);
      const std::int32_t last = column.edge() - 1;
      const kernels::RowRect part{kernels::larger(rect.x0, column.firstX), kernels::larger(rect.y0, column.firstY),
                                  kernels::smaller(rect.x1, column.firstX + last),
                                  kernels::smaller(rect.y1, column.firstY + last)};
      kernels::forEachCrossing(triangle, part, column,
                               [&](kernels::Crossing c) { visit(std::int64_t{i} * lattice.bricksY + j, c); });
    }
}

/// 1 for each brick that is crossed.
struct MarkBricks {
  std::uint32_t* touched;
  std::int32_t bricksZ;
  __device__ void operator()(std::int64_t column, kernels::Crossing c) const {
    touched[column * bricksZ + kernels::crossingBrick(c)] = 1;
  }
};

/// Of each column: the number of touched bricks before it.
static __global__ void slotsOfColumns(const std::uint32_t* slots, DeviceLattice lattice, std::uint32_t* first) {
  const std::int64_t column = blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (column <= lattice.columns()) first[column] = slots[column * lattice.bricksZ];
}

/// Extra crossings in the order in which threads came: slot << kSlotShift | row, sample and sign of the crossing.
using ExtraKey = unsigned long long;
inline constexpr int kSlotShift = 19;
inline constexpr kernels::Crossing kInBrick = (1u << kSlotShift) - 1;
struct ExtraList {
  ExtraKey* keys;
  unsigned long long* count; ///< of all, also of those that found no room
  std::int64_t capacity;
};

/// Columns whose bricks have their pages in memory.
template <class Word>
struct DevicePages {
  std::int64_t firstColumn, endColumn;
  std::int32_t bricksZ;
  std::int32_t rows;          ///< of a column
  const std::uint32_t* slots; ///< of all bricks: touched ones before each, and the number of all
  std::uint32_t firstSlot;    ///< whose page is the first
  Word* words;

  [[nodiscard]] __device__ Word* page(std::uint32_t slot) const {
    return words + static_cast<std::int64_t>(slot - firstSlot) * 2 * rows;
  }
};

/// Sets the bits of those crossings that belong to the pages' columns.
template <class Word>
struct SetBits {
  DevicePages<Word> pages;
  ExtraList extra;
  __device__ void operator()(std::int64_t column, kernels::Crossing c) const {
    if (column < pages.firstColumn || column >= pages.endColumn) return;
    const std::uint32_t slot = pages.slots[column * pages.bricksZ + kernels::crossingBrick(c)];
    Word* const word = pages.page(slot) + kernels::crossingRow(c) + (kernels::crossingRises(c) ? 0 : pages.rows);
    const Word bit = Word{1} << kernels::crossingSample(c);
    if (!(atomicOr(word, bit) & bit)) return;
    const unsigned long long at = atomicAdd(extra.count, 1ull);
    if (at < static_cast<unsigned long long>(extra.capacity))
      extra.keys[at] = ExtraKey{slot - pages.firstSlot} << kSlotShift | (c & kInBrick);
  }
};

/// Extra crossings [begin, end).
struct ExtraRange {
  std::int64_t begin, end;
};

/// Extra crossings by page.
struct DeviceExtra {
  kernels::Crossing* crossings;
  ExtraRange* ranges; ///< zeros where a page has none
  std::int64_t count;
};

/// From sorted keys.
static __global__ void splitExtra(const ExtraKey* keys, DeviceExtra extra) {
  const std::int64_t i = blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (i >= extra.count) return;
  const ExtraKey page = keys[i] >> kSlotShift;
  extra.crossings[i] = static_cast<kernels::Crossing>(keys[i]) & kInBrick;
  if (i == 0 || keys[i - 1] >> kSlotShift != page) extra.ranges[page].begin = i;
  if (i + 1 == extra.count || keys[i + 1] >> kSlotShift != page) extra.ranges[page].end = i + 1;
}

/// What the sweeps along columns read and write; bricks count from the first of the pages' columns.
template <class Word>
struct ColumnSweep {
  DevicePages<Word> pages;
  DeviceExtra extra;
  BrickFill* fills;       ///< zeros to begin with
  std::uint32_t* counted; ///< 1 for a brick that is Counted; summed up: those before it
  std::uint16_t* counts;
};

/// The rows of a column of 2^Log2 sub-voxels along a voxel's edge, and who takes them.
template <int Log2>
struct ColumnShape {
  using Word = std::conditional_t<Log2 == 3, unsigned long long, unsigned>; // what the device's atomics take
  static constexpr int kEdge = 8 << Log2, kRows = kEdge * kEdge;
  static constexpr int kThreads = kRows < 256 ? kRows : 256;
  static constexpr int kRowsOfThread = kRows / kThreads;
};

__device__ inline int bitsOf(unsigned word) { return __popc(word); }
__device__ inline int bitsOf(unsigned long long word) { return __popcll(word); }

/// The extra crossings of one row through one brick.
struct RowExtra {
  const kernels::Crossing* crossings = nullptr;
  int count = 0;
};

/// Row by row, the crossings of one touched brick.
template <int Log2>
class PageRows {
public:
  using Shape = ColumnShape<Log2>;
  using Word = typename Shape::Word;

  __device__ PageRows(const ColumnSweep<Word>& sweep, std::uint32_t slot)
      : mExtra(sweep.extra), mWords(sweep.pages.page(slot)) {
    if (mExtra.count > 0) mRange = mExtra.ranges[slot - sweep.pages.firstSlot];
  }

  [[nodiscard]] __device__ kernels::RowBits<Word> bits(int row) const {
    return {mWords[row], mWords[Shape::kRows + row]};
  }
  [[nodiscard]] __device__ RowExtra extra(int row) const {
    if (mRange.begin == mRange.end) return {};
    std::int64_t low = mRange.begin, high = mRange.end;
    while (low < high) {
      const std::int64_t middle = low + (high - low) / 2;
      if (kernels::crossingRow(mExtra.crossings[middle]) < row)
        low = middle + 1;
      else
        high = middle;
    }
    RowExtra found{mExtra.crossings + low, 0};
    while (low + found.count < mRange.end && kernels::crossingRow(found.crossings[found.count]) == row) ++found.count;
    return found;
  }

private:
  const DeviceExtra& mExtra;
  const Word* mWords;
  ExtraRange mRange{0, 0};
};

/// Tells which bricks of a column are empty, full or to be counted: a touched brick is counted, and so is one through
/// which some rows pass inside and some outside. A block a column.
template <int Log2>
__global__ void __launch_bounds__(ColumnShape<Log2>::kThreads)
    fillColumns(ColumnSweep<typename ColumnShape<Log2>::Word> sweep) {
  using Shape = ColumnShape<Log2>;
  const std::int32_t bricks = sweep.pages.bricksZ;
  const std::uint32_t* const slots = sweep.pages.slots + (sweep.pages.firstColumn + blockIdx.x) * bricks;
  if (slots[0] == slots[bricks]) return;
  std::int32_t winding[Shape::kRowsOfThread] = {};
  BrickFill beyond = BrickFill::Empty; // of bricks that are not touched
  for (std::int32_t z = 0; z < bricks; ++z) {
    const bool touched = slots[z] != slots[z + 1];
    if (touched) {
      const PageRows<Log2> page(sweep, slots[z]);
      bool any = false, all = true;
#pragma unroll
      for (int k = 0; k < Shape::kRowsOfThread; ++k) {
        const int row = static_cast<int>(threadIdx.x) + k * Shape::kThreads;
        const auto bits = page.bits(row);
        winding[k] += bitsOf(bits.rises) - bitsOf(bits.falls);
        const RowExtra extra = page.extra(row);
        for (int e = 0; e < extra.count; ++e) winding[k] += kernels::crossingRises(extra.crossings[e]) ? 1 : -1;
        any = any || winding[k] != 0;
        all = all && winding[k] != 0;
      }
      const bool blockAny = __syncthreads_or(any), blockAll = __syncthreads_and(all);
      beyond = !blockAny ? BrickFill::Empty : blockAll ? BrickFill::Full : BrickFill::Counted;
    }
    if (threadIdx.x == 0) {
      const BrickFill fill = touched ? BrickFill::Counted : beyond;
      const std::int64_t brick = static_cast<std::int64_t>(blockIdx.x) * bricks + z;
      sweep.fills[brick] = fill;
      sweep.counted[brick] = fill == BrickFill::Counted;
    }
  }
}

/// Bit k: sample k of a row is inside. `winding` is the number before the brick and becomes the one after it.
template <class Word>
__device__ inline Word insideOf(kernels::RowBits<Word> bits, const RowExtra& extra, int samples,
                                std::int32_t& winding) {
  // In a body that is inside out numbers are 0 and -1: the same row with all signs changed.
  const Word changes = bits.rises ^ bits.falls, firstChange = changes & (Word{0} - changes);
  const bool negative = winding < 0 || (winding == 0 && (bits.falls & firstChange) != 0);
  const kernels::RowBits<Word> upright = negative ? kernels::RowBits<Word>{bits.falls, bits.rises} : bits;
  Word after;
  if (extra.count == 0 && kernels::sweepRow<Word>(upright, static_cast<Word>(negative ? -winding : winding), after)) {
    const auto last = static_cast<std::int32_t>(after >> (8 * sizeof(Word) - 1));
    winding = negative ? -last : last;
    return after;
  }
  return kernels::insideBits<Word>(bits, extra.crossings, extra.count, nullptr, 0, samples, winding);
}

/// Of one voxel, from the rows of its brick.
template <int Log2>
__device__ inline std::uint16_t samplesInside(const typename ColumnShape<Log2>::Word* rows, int voxel) {
  constexpr int kSub = 1 << Log2;
  constexpr unsigned kField = (1u << kSub) - 1;
  const int x = voxel >> 6, y = voxel >> 3 & 7, firstBit = (voxel & 7) << Log2;
  int sum = 0;
  for (int i = 0; i < kSub; ++i)
    for (int j = 0; j < kSub; ++j)
      sum += __popc(static_cast<unsigned>(rows[(x * kSub + i) * ColumnShape<Log2>::kEdge + y * kSub + j] >> firstBit) &
                    kField);
  return static_cast<std::uint16_t>(sum);
}

/// Counts the samples inside each voxel of the bricks that are Counted. A block a column.
template <int Log2>
__global__ void __launch_bounds__(ColumnShape<Log2>::kThreads)
    countColumns(ColumnSweep<typename ColumnShape<Log2>::Word> sweep) {
  using Shape = ColumnShape<Log2>;
  using Word = typename Shape::Word;
  __shared__ Word inside[Shape::kRows];
  const std::int32_t bricks = sweep.pages.bricksZ;
  const std::uint32_t* const slots = sweep.pages.slots + (sweep.pages.firstColumn + blockIdx.x) * bricks;
  if (slots[0] == slots[bricks]) return;
  const std::int64_t first = static_cast<std::int64_t>(blockIdx.x) * bricks;
  std::int32_t winding[Shape::kRowsOfThread] = {};
  for (std::int32_t z = 0; z < bricks; ++z) {
    if (sweep.fills[first + z] != BrickFill::Counted) continue;
#pragma unroll
    for (int k = 0; k < Shape::kRowsOfThread; ++k) {
      const int row = static_cast<int>(threadIdx.x) + k * Shape::kThreads;
      if (slots[z] == slots[z + 1]) {
        inside[row] = winding[k] != 0 ? ~Word{0} : Word{0};
      } else {
        const PageRows<Log2> page(sweep, slots[z]);
        inside[row] = insideOf<Word>(page.bits(row), page.extra(row), Shape::kEdge, winding[k]);
      }
    }
    __syncthreads();
    std::uint16_t* const counts = sweep.counts + std::int64_t{sweep.counted[first + z]} * kVoxelsOfBrick;
    for (int v = static_cast<int>(threadIdx.x); v < kVoxelsOfBrick; v += Shape::kThreads)
      counts[v] = samplesInside<Log2>(inside, v);
    __syncthreads();
  }
}

/// Numbers with `more` added to each.
static __global__ void shiftNumbers(const std::uint32_t* numbers, std::int64_t count, std::uint32_t more,
                                    std::uint32_t* shifted) {
  const std::int64_t i = blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (i < count) shifted[i] = numbers[i] + more;
}

/// Sets `found` where any sample is inside.
static __global__ void findFull(const BrickFill* fills, std::int64_t count, unsigned* found) {
  const std::int64_t i = blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (i < count && fills[i] == BrickFill::Full && !*static_cast<volatile unsigned*>(found)) atomicOr(found, 1u);
}
static __global__ void findCounts(const std::uint16_t* counts, std::int64_t count, unsigned* found) {
  const std::int64_t i = blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (i < count && counts[i] != 0 && !*static_cast<volatile unsigned*>(found)) atomicOr(found, 1u);
}

} // namespace volcaustic
