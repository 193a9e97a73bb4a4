#include "volume/coverage_rows.h"

#include <cmath>
#include <utility>

namespace volcaustic {

namespace {

using Wide = __int128;                                        // for triangles longer than 2^14 sub-voxels
constexpr std::int64_t kNarrowExtent = std::int64_t{1} << 30; // edge functions of shorter ones fit 64 bits

/// Where the row that is the `phase`-th of its voxel along one axis is sampled along another: (phase + 1/2)/2^log2 of a
/// sub-voxel.
constexpr std::int64_t stagger(int phase, int log2) { return ((2 * phase + 1) << (kFixedBits - 1)) >> log2; }

/// Twice the area of (a, b, sample), stepping from row to row. `value` is one less where a sample on the edge is
/// outside, so that inside is value >= 0 for both kinds.
template <class Int>
struct EdgeFunction {
  EdgeFunction(const FixedPoint& a, const FixedPoint& b, std::int64_t x, std::int64_t y)
      : dx(b.x - a.x), dy(b.y - a.y) {
    // The sample stands for (x + eps, y + eps^2): on the edge, the function's sign is that of -dy eps + dx eps^2.
    bias = dy < 0 || (dy == 0 && dx > 0) ? 0 : 1;
    value = dx * Int(y - a.y) - dy * Int(x - a.x) - bias;
    stepX = -dy * kFixedOne;
    stepY = dx * kFixedOne;
  }
  [[nodiscard]] double exact(Int v) const { return double(v + bias); }

  Int dx, dy, value, stepX, stepY, bias;
};

template <class Int>
Int twiceArea(const FixedTriangle& t) {
  return Int(t[1].x - t[0].x) * Int(t[2].y - t[0].y) - Int(t[1].y - t[0].y) * Int(t[2].x - t[0].x);
}

bool isNarrow(const FixedTriangle& t) {
  const auto [x0, x1] = std::minmax({t[0].x, t[1].x, t[2].x});
  const auto [y0, y1] = std::minmax({t[0].y, t[1].y, t[2].y});
  return x1 - x0 < kNarrowExtent && y1 - y0 < kNarrowExtent;
}

template <class Int>
bool mayMeetAs(FixedTriangle t, const RowRect& rect) {
  const Int area = twiceArea<Int>(t);
  if (area == 0) return false;
  if (area < 0) std::swap(t[1], t[2]);
  for (int i = 0; i < 3; ++i) {
    const EdgeFunction<Int> edge(t[i], t[(i + 1) % 3], rect.x0 * kFixedOne, rect.y0 * kFixedOne);
    const Int best = edge.value + std::max<Int>(0, edge.stepX * (rect.x1 - rect.x0 + 1)) +
                     std::max<Int>(0, edge.stepY * (rect.y1 - rect.y0 + 1));
    if (best < 0) return false;
  }
  return true;
}

/// First of a row's samples, the k-th of which lies at k + offset sub-voxels, that is at or after z (both fixed-point),
/// clamped to [0, samples].
int firstSampleFrom(double z, std::int64_t offset, int samples) {
  const double position = std::min(std::max((z - double(offset)) * (1.0 / double(kFixedOne)), 0.0), double(samples));
  const int whole = static_cast<int>(position);
  return whole + (position > whole);
}

struct ColumnFrame {
  int x0, y0;    // first row
  int brickLog2; // of samples along a brick's edge
  int samples;   // along a row
  [[nodiscard]] int log2() const { return brickLog2 - kBrickLog2; }
};

/// What staggered rows add to an edge function: for each phase, the row's offset along x and along y.
template <class Int>
struct Staggered {
  Staggered(const EdgeFunction<Int>& edge, int log2) {
    for (int phase = 0; phase < 1 << log2; ++phase) {
      alongX[phase] = -edge.dy * Int(stagger(phase, log2));
      alongY[phase] = edge.dx * Int(stagger(phase, log2));
    }
  }
  std::array<Int, 8> alongX, alongY;
};

template <class Int>
void rasterise(FixedTriangle t, const RowRect& rect, const ColumnFrame& column, std::vector<Crossing>& crossings) {
  Int area = twiceArea<Int>(t);
  if (area == 0) return;
  // Seen from +z, counter-clockwise faces look up: a row leaves the body there.
  const bool rises = area < 0;
  if (rises) {
    std::swap(t[1], t[2]);
    area = -area;
  }
  const auto& [a, b, c] = t;
  const std::int64_t x = rect.x0 * kFixedOne, y = rect.y0 * kFixedOne;
  EdgeFunction<Int> ofA(b, c, x, y), ofB(c, a, x, y), ofC(a, b, x, y);
  const int log2 = column.log2(), mask = (1 << log2) - 1;
  const Staggered<Int> shiftA(ofA, log2), shiftB(ofB, log2), shiftC(ofC, log2);
  const double zA = double(a.z), dzB = double(b.z - a.z), dzC = double(c.z - a.z), twice = double(area);

  for (int i = rect.x0; i <= rect.x1; ++i) {
    const int p = i & mask;
    Int rowA = ofA.value + shiftA.alongY[p], rowB = ofB.value + shiftB.alongY[p], rowC = ofC.value + shiftC.alongY[p];
    for (int j = rect.y0; j <= rect.y1; ++j) {
      const int q = j & mask;
      const Int vA = rowA + shiftA.alongX[q], vB = rowB + shiftB.alongX[q], vC = rowC + shiftC.alongX[q];
      if ((vA | vB | vC) >= 0) {
        const double z = zA + (ofB.exact(vB) * dzB + ofC.exact(vC) * dzC) / twice;
        if (const int k = firstSampleFrom(z, stagger(p << log2 | q, 2 * log2), column.samples); k < column.samples)
          crossings.push_back(
              packCrossing(k, column.brickLog2, ((i - column.x0) << column.brickLog2) + (j - column.y0), rises));
      }
      rowA += ofA.stepY, rowB += ofB.stepY, rowC += ofC.stepY;
    }
    ofA.value += ofA.stepX, ofB.value += ofB.stepX, ofC.value += ofC.stepX;
  }
}

constexpr std::uint64_t bitsBelow(int n) { return n >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1; }

/// Set bits of each of the eight fields of 2^Log2 bits that a row through a brick holds, one byte for each voxel.
template <int Log2>
constexpr std::uint64_t bitsPerVoxel(std::uint64_t x) {
  // Sums within the fields, as a population count does.
  if constexpr (Log2 >= 1) x -= x >> 1 & 0x5555555555555555ull;
  if constexpr (Log2 >= 2) x = (x & 0x3333333333333333ull) + (x >> 2 & 0x3333333333333333ull);
  if constexpr (Log2 >= 3) x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0full;
  // Then narrow fields apart: bits to pairs, pairs to nibbles, nibbles to bytes.
  if constexpr (Log2 <= 0) {
    x = (x | x << 4) & 0x0f0f;
    x = (x | x << 2) & 0x3333;
    x = (x | x << 1) & 0x5555;
  }
  if constexpr (Log2 <= 1) {
    x = (x | x << 8) & 0x00ff00ff;
    x = (x | x << 4) & 0x0f0f0f0f;
    x = (x | x << 2) & 0x33333333;
  }
  if constexpr (Log2 <= 2) {
    x = (x | x << 16) & 0x0000ffff0000ffffull;
    x = (x | x << 8) & 0x00ff00ff00ff00ffull;
    x = (x | x << 4) & 0x0f0f0f0f0f0f0f0full;
  }
  return x;
}

template <int Log2>
void countSamplesOf(const std::uint64_t* rows, std::uint16_t* counts) {
  constexpr int kSub = 1 << Log2, kRows = kBrickSize << Log2;
  for (int x = 0; x < kBrickSize; ++x) {
    for (int y = 0; y < kBrickSize; ++y, counts += kBrickSize) {
      for (int v = 0; v < kBrickSize; ++v) counts[v] = 0;
      for (int i = 0; i < kSub; ++i) {
        const std::uint64_t* row = rows + (x * kSub + i) * kRows + y * kSub;
        std::uint64_t bytes = 0; // at most 8 rows of 8 samples: no byte overflows
        for (int j = 0; j < kSub; ++j) bytes += bitsPerVoxel<Log2>(row[j]);
        for (int v = 0; v < kBrickSize; ++v) counts[v] += static_cast<std::uint16_t>(bytes >> 8 * v & 0xff);
      }
    }
  }
}

} // namespace

FixedPoint SubLattice::snap(const Vec3d& pWorld) const {
  const auto axis = [&](int a) {
    const double units = (pWorld[a] - corner[a]) * scale * double(kFixedOne);
    return static_cast<std::int64_t>(units + std::copysign(0.5, units)) - first[a] * kFixedOne;
  };
  return {axis(0), axis(1), axis(2)};
}

RowRect rowsMet(const FixedTriangle& t, const SubLattice& lattice) {
  const auto [x0, x1] = std::minmax({t[0].x, t[1].x, t[2].x});
  const auto [y0, y1] = std::minmax({t[0].y, t[1].y, t[2].y});
  if (std::min({t[0].z, t[1].z, t[2].z}) > lattice.size[2] * kFixedOne) return {0, 0, -1, -1};
  const auto row = [](std::int64_t at, int samples) {
    return static_cast<int>(std::clamp<std::int64_t>(at >> kFixedBits, -1, samples));
  };
  return {std::max(row(x0, lattice.size[0]), 0), std::max(row(y0, lattice.size[1]), 0),
          std::min(row(x1, lattice.size[0]), lattice.size[0] - 1),
          std::min(row(y1, lattice.size[1]), lattice.size[1] - 1)};
}

bool mayMeet(const FixedTriangle& triangle, const RowRect& rect) {
  return isNarrow(triangle) ? mayMeetAs<std::int64_t>(triangle, rect) : mayMeetAs<Wide>(triangle, rect);
}

void appendCrossings(const FixedTriangle& triangle, int columnX, int columnY, const SubLattice& lattice,
                     std::vector<Crossing>& crossings) {
  const int log2 = kBrickLog2 + lattice.log2, n = 1 << log2;
  const ColumnFrame column{columnX * n, columnY * n, log2, lattice.size[2]};
  RowRect rect = rowsMet(triangle, lattice);
  rect = {std::max(rect.x0, column.x0), std::max(rect.y0, column.y0), std::min(rect.x1, column.x0 + n - 1),
          std::min(rect.y1, column.y0 + n - 1)};
  if (rect.empty()) return;
  if (isNarrow(triangle))
    rasterise<std::int64_t>(triangle, rect, column, crossings);
  else
    rasterise<Wide>(triangle, rect, column, crossings);
}

std::uint64_t insideBits(std::span<const Crossing> crossings, int offset, int samples, int& winding) {
  std::uint64_t bits = 0;
  int from = 0;
  const auto fill = [&](int to) {
    if (winding + offset != 0) bits |= bitsBelow(to) & ~bitsBelow(from);
    from = to;
  };
  for (const Crossing c : crossings) {
    fill(crossingSample(c));
    winding += crossingSign(c);
  }
  fill(samples);
  return bits;
}

std::uint64_t insideBits(std::span<const Crossing> crossings, std::span<const std::int16_t> offsets, int& winding) {
  std::uint64_t bits = 0;
  std::size_t next = 0;
  for (int k = 0; k < static_cast<int>(offsets.size()); ++k) {
    for (; next < crossings.size() && crossingSample(crossings[next]) == k; ++next)
      winding += crossingSign(crossings[next]);
    if (winding + offsets[k] != 0) bits |= std::uint64_t{1} << k;
  }
  return bits;
}

void countSamples(std::span<const std::uint64_t> rows, int log2, std::span<std::uint16_t, kBrickVoxels> counts) {
  switch (log2) {
  case 0:
    return countSamplesOf<0>(rows.data(), counts.data());
  case 1:
    return countSamplesOf<1>(rows.data(), counts.data());
  case 2:
    return countSamplesOf<2>(rows.data(), counts.data());
  default:
    return countSamplesOf<3>(rows.data(), counts.data());
  }
}

} // namespace volcaustic
