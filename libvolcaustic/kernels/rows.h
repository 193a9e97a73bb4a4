// Crossings of triangles with rows of sub-voxels, decided exactly.
//
// A row is all samples of one (i, j) of a lattice of sub-voxels, along z; see SubLattice for where a sample lies inside
// its sub-voxel. Coordinates are whole numbers of 2^-16 sub-voxel, held in numbers N that compute exactly with them:
// doubles for triangles under kExactInDoubles, and 64 or 128-bit integers beyond. A sample stands for the point (x +
// eps, y + eps^2), which is the top-left rule written once for triangles of both orientations: an edge or a vertex on a
// sample belongs to exactly one side, for any number of triangles around it.
#pragma once

#include "kernels/lanes.h"

namespace volcaustic::kernels {

/// Fractional bits of a snapped coordinate: the lattice's unit is 2^-16 sub-voxel.
inline constexpr int kFixedBits = 16;
inline constexpr double kFixedOne = 1 << kFixedBits;
/// Extent of a triangle in x and y, in lattice units (512 sub-voxels), below which every number here is whole and under
/// 2^53.
inline constexpr double kExactInDoubles = 0x1p25;
/// The same for 64-bit integers.
inline constexpr double kExactInInt64 = 0x1p30;

/// Where the row that is the `phase`-th of its voxel along one axis is sampled along another: (phase + 1/2)/2^log2 of a
/// sub-voxel, in lattice units. \pre 0 <= log2 <= 6
VOLCAUSTIC_HD constexpr std::int32_t stagger(std::int32_t phase, int log2) {
  return ((2 * phase + 1) << (kFixedBits - 1)) >> log2;
}

/// A crossing, packed so that integers sort by brick along the row, then row of the column of bricks, then sample:
/// brick (12 bits), row (12 bits), first sample at or after the crossing (6 bits), 1 where the winding number rises.
using Crossing = std::uint32_t;
VOLCAUSTIC_HD constexpr Crossing packCrossing(std::int32_t sample, int brickLog2, std::int32_t row, bool rises) {
  const std::int32_t inBrick = sample & ((1 << brickLog2) - 1);
  return Crossing(sample >> brickLog2) << 19 | Crossing(row) << 7 | Crossing(inBrick) << 1 | Crossing(rises);
}
VOLCAUSTIC_HD constexpr std::int32_t crossingBrick(Crossing c) { return std::int32_t(c >> 19); }
VOLCAUSTIC_HD constexpr std::int32_t crossingRow(Crossing c) { return std::int32_t(c >> 7 & 0xfff); }
VOLCAUSTIC_HD constexpr std::int32_t crossingSample(Crossing c) { return std::int32_t(c >> 1 & 0x3f); }
VOLCAUSTIC_HD constexpr bool crossingRises(Crossing c) { return c & 1; }

/// A column of bricks: which rows it has, and how they are numbered.
struct RowColumn {
  std::int32_t firstX, firstY; ///< row
  std::int32_t log2;           ///< of the sub-voxels along a voxel's edge
  std::int32_t samples;        ///< along a row

  [[nodiscard]] VOLCAUSTIC_HD constexpr int brickLog2() const { return 3 + log2; }
  [[nodiscard]] VOLCAUSTIC_HD constexpr std::int32_t edge() const { return 1 << brickLog2(); }
};

/// Rows x0..x1 by y0..y1, both inclusive.
struct RowRect {
  std::int32_t x0, y0, x1, y1;
  [[nodiscard]] VOLCAUSTIC_HD constexpr bool empty() const { return x0 > x1 || y0 > y1; }
  [[nodiscard]] VOLCAUSTIC_HD constexpr std::int32_t count() const { return (x1 - x0 + 1) * (y1 - y0 + 1); }
};

/// Rows, of first..last, that may be sampled between two coordinates; `inset` is the least stagger. first > last for
/// none.
struct RowRange {
  std::int32_t first, last;
};
VOLCAUSTIC_HD inline RowRange rowRange(double least, double greatest, std::int32_t inset, std::int32_t first,
                                       std::int32_t last) {
  // Row i is sampled from i + inset to i + 1 - inset. The numbers are whole.
  constexpr std::int64_t kCeil = (std::int64_t{1} << kFixedBits) - 1;
  const std::int64_t low = ((static_cast<std::int64_t>(least) + inset + kCeil) >> kFixedBits) - 1,
                     high = (static_cast<std::int64_t>(greatest) - inset) >> kFixedBits;
  return {static_cast<std::int32_t>(clampTo<std::int64_t>(low, first, last + 1)),
          static_cast<std::int32_t>(clampTo<std::int64_t>(high, first - 1, last))};
}

/// Twice the area of (p, q, sample) less one where a sample on the edge is outside: inside is value >= 0 for both
/// kinds.
template <class N>
struct RowEdge {
  N dx, minusDy, constant, bias;

  RowEdge() = default;
  VOLCAUSTIC_HD RowEdge(N px, N py, N qx, N qy) : dx(qx - px), minusDy(py - qy) {
    // On the edge, the function's sign is that of -dy eps + dx eps^2.
    const N none(0), one(1);
    bias = select(either(minusDy > none, both(minusDy == none, dx > none)), none, one);
    constant = none - minusDy * px - dx * py - bias;
  }
  [[nodiscard]] VOLCAUSTIC_HD N at(N x, N y) const { return exactMulAdd(dx, y, exactMulAdd(minusDy, x, constant)); }
  /// at(x, y) less at(0, 0).
  [[nodiscard]] VOLCAUSTIC_HD N change(N x, N y) const { return exactMulAdd(dx, y, minusDy * x); }
};

/// The plane of a triangle, over twice the areas that its second and its third corner are opposite of.
template <class N>
struct RowPlane {
  using Real = DoubleOf<N>;
  N biasB, biasC;
  Real area, z, riseB, riseC;

  /// In lattice units, where RowTriangle::valuesAt() gives b and c. The same bits on every machine: nothing here may be
  /// fused.
  [[nodiscard]] VOLCAUSTIC_HD Real height(N b, N c) const {
    return z + unfusedSum(toReal(b + biasB), riseB, toReal(c + biasC), riseC) / area;
  }
};

/// A triangle as rows see it: from below, with samples relative to its first corner.
template <class N>
class RowTriangle {
public:
  using Real = DoubleOf<N>;
  struct Values {
    N a, b, c;
  };

  VOLCAUSTIC_HD RowTriangle(const Vec3<N>& a, Vec3<N> b, Vec3<N> c) : mOrigin(a) {
    b = b - a;
    c = c - a;
    const N none(0);
    N area = b.x * c.y - b.y * c.x;
    mFlat = area == none;
    // Seen from +z, counter-clockwise faces look up: a row leaves the body there.
    mRises = area < none;
    const Vec3<N> first = chosen(mRises, c, b), second = chosen(mRises, b, c);
    area = select(mRises, none - area, area);
    mOfA = RowEdge<N>(first.x, first.y, second.x, second.y);
    mOfB = RowEdge<N>(second.x, second.y, none, none);
    mOfC = RowEdge<N>(none, none, first.x, first.y);
    mPlane = {mOfB.bias, mOfC.bias, toReal(area), toReal(a.z), toReal(first.z), toReal(second.z)};
  }

  /// Without area, as rows see it: no row crosses it.
  [[nodiscard]] VOLCAUSTIC_HD MaskOf<N> flat() const { return mFlat; }
  /// Whether the winding number rises where a row crosses.
  [[nodiscard]] VOLCAUSTIC_HD MaskOf<N> rises() const { return mRises; }

  /// Of the row that is sampled at (x, y).
  [[nodiscard]] VOLCAUSTIC_HD Values valuesAt(N x, N y) const {
    x = x - mOrigin.x;
    y = y - mOrigin.y;
    return {mOfA.at(x, y), mOfB.at(x, y), mOfC.at(x, y)};
  }
  /// The two parts of it: valuesAt(x + dx, y + dy) = valuesOfLine(x, dy) + valuesAcross(dx, y), whole numbers all of
  /// them. So the rows of a rectangle need the products of its sides only.
  [[nodiscard]] VOLCAUSTIC_HD Values valuesOfLine(N x, N dy) const {
    x = x - mOrigin.x;
    return {mOfA.at(x, dy), mOfB.at(x, dy), mOfC.at(x, dy)};
  }
  [[nodiscard]] VOLCAUSTIC_HD Values valuesAcross(N dx, N y) const {
    y = y - mOrigin.y;
    return {mOfA.change(dx, y), mOfB.change(dx, y), mOfC.change(dx, y)};
  }
  [[nodiscard]] VOLCAUSTIC_HD MaskOf<N> crosses(const Values& v) const {
    const N none(0);
    return both(both(v.a >= none, v.b >= none), v.c >= none);
  }
  /// Height of the crossing, in lattice units.
  [[nodiscard]] VOLCAUSTIC_HD Real height(const Values& v) const { return mPlane.height(v.b, v.c); }
  [[nodiscard]] VOLCAUSTIC_HD const RowPlane<N>& plane() const { return mPlane; }

  /// False when no row that is sampled between `low` and `high` crosses. \pre not flat
  [[nodiscard]] VOLCAUSTIC_HD bool mayCross(N lowX, N lowY, N highX, N highY) const {
    const auto best = [&](const RowEdge<N>& e) {
      return e.at((e.minusDy < N(0) ? lowX : highX) - mOrigin.x, (e.dx < N(0) ? lowY : highY) - mOrigin.y);
    };
    return best(mOfA) >= N(0) && best(mOfB) >= N(0) && best(mOfC) >= N(0);
  }

private:
  VOLCAUSTIC_HD static Vec3<N> chosen(const MaskOf<N>& mask, const Vec3<N>& a, const Vec3<N>& b) {
    return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
  }

  Vec3<N> mOrigin;
  RowEdge<N> mOfA, mOfB, mOfC;
  RowPlane<N> mPlane;
  MaskOf<N> mFlat, mRises;
};

/// First of a row's samples, the k-th of which lies at k + offset sub-voxels, that is at or after z (both in lattice
/// units), clamped to [0, samples].
VOLCAUSTIC_HD inline std::int32_t firstSampleFrom(double z, std::int32_t offset, std::int32_t samples) {
  const double position = smaller(larger((z - offset) * (1.0 / kFixedOne), 0.0), static_cast<double>(samples));
  const auto whole = static_cast<std::int32_t>(position);
  return whole + (position > whole);
}

/// Of numbers one by one: calls visit(crossing) for the rows of the rectangle, all of them the column's, that the
/// triangle crosses before their last sample.
template <class N, class Visit>
VOLCAUSTIC_HD void forEachCrossing(const RowTriangle<N>& triangle, const RowRect& rect, const RowColumn& column,
                                   Visit&& visit) {
  const std::int32_t mask = (1 << column.log2) - 1;
  for (std::int32_t i = rect.x0; i <= rect.x1; ++i)
    for (std::int32_t j = rect.y0; j <= rect.y1; ++j) {
      const std::int32_t p = i & mask, q = j & mask;
      const N x = N(i) * N(1 << kFixedBits) + N(stagger(q, column.log2));
      const N y = N(j) * N(1 << kFixedBits) + N(stagger(p, column.log2));
      const auto values = triangle.valuesAt(x, y);
      if (!triangle.crosses(values)) continue;
      const std::int32_t k =
          firstSampleFrom(triangle.height(values), stagger(p << column.log2 | q, 2 * column.log2), column.samples);
      if (k >= column.samples) continue;
      const std::int32_t row = ((i - column.firstX) << column.brickLog2()) + (j - column.firstY);
      visit(packCrossing(k, column.brickLog2(), row, triangle.rises()));
    }
}

/// Samples of a row through a brick as bits: those at which the winding number rises and falls, by one.
template <class Word>
struct RowBits {
  Word rises, falls;
};

/// The winding number of a row in which it is 0 or 1 all along, without a loop over the samples: bit k of `after`
/// becomes the number at sample k. `carry` is the number before the brick. False for any other row, and then `after` is
/// of no use.
template <class Word>
VOLCAUSTIC_HD inline bool sweepRow(const RowBits<Word>& bits, Word carry, Word& after) {
  const Word changes = bits.rises ^ bits.falls;
  after = changes;
  for (int shift = 1; shift < static_cast<int>(8 * sizeof(Word)); shift *= 2) after ^= after << shift;
  after ^= Word{0} - carry;
  // Samples at which the number changes and is not 1 after a rise, or not 0 after a fall.
  const Word wrong = changes & ~(after ^ bits.falls);
  return wrong == 0 && carry <= 1;
}

/// Bit k: sample k is inside, which is winding number + offset != 0. `winding` is the number before the brick and
/// becomes the one after it. `extra` are crossings of this row beside those of the bits; `offsets` has one for each
/// sample, or is null.
template <class Word>
VOLCAUSTIC_HD inline Word insideBits(const RowBits<Word>& bits, const Crossing* extra, int extraCount,
                                     const std::int16_t* offsets, int offset, int samples, std::int32_t& winding) {
  Word inside = 0;
  for (int k = 0; k < samples; ++k) {
    winding += static_cast<int>(bits.rises >> k & 1) - static_cast<int>(bits.falls >> k & 1);
    for (int e = 0; e < extraCount; ++e)
      if (crossingSample(extra[e]) == k) winding += crossingRises(extra[e]) ? 1 : -1;
    if (winding + (offsets ? offsets[k] : offset) != 0) inside |= Word{1} << k;
  }
  return inside;
}

} // namespace volcaustic::kernels
