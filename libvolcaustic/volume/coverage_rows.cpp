#include "volume/coverage_rows.h"

#include "core/simd_clones.h"

#include <cmath>

namespace volcaustic {

namespace {

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

/// A voxel's samples lie in 2^Log2 rows along x and along y: rows are added up along x side by side, then along y.
template <int Log2, class Word>
inline void countSamplesOf(const Word* __restrict rows, std::uint16_t* __restrict counts) {
  constexpr int kSub = 1 << Log2, kRows = kBrickSize << Log2;
  for (int x = 0; x < kBrickSize; ++x, rows += kSub * kRows) {
    std::array<std::uint64_t, kRows> bytes; // at most 8 rows of 8 samples: no byte overflows
    for (int j = 0; j < kRows; ++j) bytes[j] = bitsPerVoxel<Log2>(rows[j]);
    for (int i = 1; i < kSub; ++i)
      for (int j = 0; j < kRows; ++j) bytes[j] += bitsPerVoxel<Log2>(rows[i * kRows + j]);
    for (int y = 0; y < kBrickSize; ++y, counts += kBrickSize)
      if constexpr (Log2 < 3) {
        std::uint64_t sum = 0;
        for (int j = 0; j < kSub; ++j) sum += bytes[y * kSub + j];
        for (int v = 0; v < kBrickSize; ++v) counts[v] = static_cast<std::uint16_t>(sum >> 8 * v & 0xff);
      } else {
        for (int v = 0; v < kBrickSize; ++v) {
          std::uint64_t sum = 0;
          for (int j = 0; j < kSub; ++j) sum += bytes[y * kSub + j] >> 8 * v & 0xff;
          counts[v] = static_cast<std::uint16_t>(sum);
        }
      }
  }
}

template <class Signed, class Word>
inline void insideOf(const Signed* winding, const std::int16_t* offsets, int rows, int samples, Word* inside) {
  for (int row = 0; row < rows; ++row, offsets += samples) {
    const auto none = static_cast<Word>(-winding[row]);
    Word bits = 0;
    for (int k = 0; k < samples; ++k) bits |= Word{static_cast<Word>(static_cast<Signed>(offsets[k])) != none} << k;
    inside[row] = bits;
  }
}

} // namespace

VOLCAUSTIC_SIMD_CLONES void insideOfOffsets(const std::int32_t* winding, const std::int16_t* offsets, int rows,
                                            int samples, std::uint32_t* inside) {
  insideOf(winding, offsets, rows, samples, inside);
}
VOLCAUSTIC_SIMD_CLONES void insideOfOffsets(const std::int64_t* winding, const std::int16_t* offsets, int rows,
                                            int samples, std::uint64_t* inside) {
  insideOf(winding, offsets, rows, samples, inside);
}

VOLCAUSTIC_SIMD_CLONES void countSamples(const std::uint32_t* rows, int log2,
                                         std::span<std::uint16_t, kBrickVoxels> counts) {
  if (log2 == 0)
    countSamplesOf<0>(rows, counts.data());
  else if (log2 == 1)
    countSamplesOf<1>(rows, counts.data());
  else
    countSamplesOf<2>(rows, counts.data());
}
VOLCAUSTIC_SIMD_CLONES void countSamples(const std::uint64_t* rows, int,
                                         std::span<std::uint16_t, kBrickVoxels> counts) {
  countSamplesOf<3>(rows, counts.data());
}

VOLCAUSTIC_SIMD_CLONES void SubLattice::snap(const double* pWorld, std::int64_t count, double* snapped) const {
  // Twelve numbers at a time: whole points, and whole registers of any width.
  std::array<double, 12> from, origin;
  for (int i = 0; i < 12; ++i) {
    from[i] = corner[i % 3];
    origin[i] = first[i % 3] * kernels::kFixedOne;
  }
  const double one = kernels::kFixedOne, factor = scale;
  const auto axis = [&](double p, int i) {
    const double units = (p - from[i]) * factor * one;
    return std::trunc(units + std::copysign(0.5, units)) - origin[i];
  };
  std::int64_t at = 0;
  for (; at + 12 <= 3 * count; at += 12)
    for (int i = 0; i < 12; ++i) snapped[at + i] = axis(pWorld[at + i], i);
  for (int i = 0; at + i < 3 * count; ++i) snapped[at + i] = axis(pWorld[at + i], i);
}

LatticePoint SubLattice::snap(const Vec3d& pWorld) const {
  Vec3d snapped;
  snap(pWorld.data(), 1, snapped.data());
  return {snapped[0], snapped[1], snapped[2]};
}

} // namespace volcaustic
