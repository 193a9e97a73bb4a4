// Light in sixteen bytes a voxel, and sparse volumes of it.
#pragma once

#include "kernels/flat_medium.h"

namespace volcaustic::kernels {

/// Fluence in W/m2, RGB, and the sum of its luminance-weighted directions, |towards| <= luminance(fluence).
template <class F>
struct LightOf {
  Vec3<F> fluence{F(0), F(0), F(0)}, towards{F(0), F(0), F(0)};

  VOLCAUSTIC_HD LightOf& operator+=(const LightOf& b) {
    fluence += b.fluence;
    towards += b.towards;
    return *this;
  }
  VOLCAUSTIC_HD friend LightOf operator*(const LightOf& a, F s) { return {a.fluence * s, a.towards * s}; }

  /// Luminance-weighted mean direction, |d| <= 1.
  [[nodiscard]] VOLCAUSTIC_HD Vec3<F> meanDirection() const {
    const F l = luminance(fluence);
    const auto lit = l > F(1e-37f); // what is less has no reciprocal
    const Vec3<F> d = towards * select(lit, reciprocal(select(lit, l, F(1))), F(0));
    // Rounding may carry a beam beyond 1.
    return d * inverseRoot(larger(dot(d, d), F(1)));
  }
};
using Light = LightOf<float>;

/// A voxel's Light as six numbers of 20 bits with one exponent, good to a millionth of the largest channel: R, G, B in
/// steps of 2^(exponent - 127), the direction sum, which has a sign, in steps of twice that. Words: R | G << 20,
/// G >> 12 | B << 8 | exponent << 28, the same with x, y, z and the exponent's upper four bits. All zero is darkness.
struct alignas(16) FluenceVoxel {
  std::uint32_t words[4];
};

inline constexpr std::int32_t kFluenceMantissa = (1 << 20) - 1, kTowardsMantissa = (1 << 19) - 1;
/// From a float's exponent field to the one that is stored: the largest channel has its leading bit at 2^19.
inline constexpr std::int32_t kFluenceExponent = 19;

/// The nearest integer, of two the even one, for |a| < 2^22: a sum of which only the integer is left.
VOLCAUSTIC_HD inline std::int32_t nearest(float a) {
  return __builtin_bit_cast(std::int32_t, a + 12582912.0f) - __builtin_bit_cast(std::int32_t, 12582912.0f);
}

VOLCAUSTIC_HD inline FluenceVoxel pack(const Light& light) {
  const auto exponent =
      static_cast<std::int32_t>(__builtin_bit_cast(std::uint32_t, maxComponent(light.fluence)) >> 23) -
      kFluenceExponent;
  if (exponent <= 0) return {};
  const float scale = __builtin_bit_cast(float, (254 - exponent) << 23);
  const auto bits = [scale](float v, float unit, std::int32_t low, std::int32_t high) {
    return static_cast<std::uint32_t>(clampTo(nearest(v * (scale * unit)), low, high) & kFluenceMantissa);
  };
  const auto f = [&](float v) { return bits(v, 1, 0, kFluenceMantissa); };
  const auto t = [&](float v) { return bits(v, 0.5f, -kTowardsMantissa, kTowardsMantissa); };
  const std::uint32_t g = f(light.fluence.y), y = t(light.towards.y), e = static_cast<std::uint32_t>(exponent);
  return {{f(light.fluence.x) | g << 20, g >> 12 | f(light.fluence.z) << 8 | e << 28, t(light.towards.x) | y << 20,
           y >> 12 | t(light.towards.z) << 8 | e >> 4 << 28}};
}

VOLCAUSTIC_HD inline Light unpack(const FluenceVoxel& voxel) {
  const std::uint32_t* w = voxel.words;
  const float unit = __builtin_bit_cast(float, (w[1] >> 28 | w[3] >> 28 << 4) << 23);
  const auto f = [](std::uint32_t bits) { return static_cast<float>(bits & kFluenceMantissa); };
  const auto t = [](std::uint32_t bits) { return static_cast<float>(static_cast<std::int32_t>(bits << 12) >> 12); };
  return {Float3(f(w[0]), f(w[0] >> 20 | w[1] << 12), f(w[1] >> 8)) * unit,
          Float3(t(w[2]), t(w[2] >> 20 | w[3] << 12), t(w[3] >> 8)) * (2 * unit)};
}

/// The words of a voxel for each lane.
template <class F>
struct FluenceWords {
  IntOf<F> words[4];
};
/// Element `offset` of the `slot`th 512 voxels. One voxel at a time here; lanes have their own.
VOLCAUSTIC_HD inline FluenceWords<float> loadVoxel(const FluenceVoxel* voxels, std::int32_t slot, std::int32_t offset) {
  const FluenceVoxel& v = voxels[slot * std::int64_t{kStepVoxels} + offset];
  const auto word = [&](int i) { return static_cast<std::int32_t>(v.words[i]); };
  return {{word(0), word(1), word(2), word(3)}};
}

/// sum += weight * unpack(v); the direction only where `directed` says that somebody wants it.
template <class F>
VOLCAUSTIC_HD inline void addUnpacked(LightOf<F>& sum, const FluenceWords<F>& v, F weight, bool directed) {
  using I = IntOf<F>;
  const I* w = v.words;
  const F unit = weight * floatOfBits((w[1] >> 5 & I(0x07800000)) | (w[3] >> 1 & I(0x78000000)));
  const auto add = [](F& to, I bits, F scale) { to = mulAdd(toFloat(bits), scale, to); };
  const I mantissa(kFluenceMantissa);
  add(sum.fluence.x, w[0] & mantissa, unit);
  add(sum.fluence.y, (w[0] >> 20 & I(0xfff)) | (w[1] << 12 & I(0xff000)), unit);
  add(sum.fluence.z, w[1] >> 8 & mantissa, unit);
  if (!directed) return;
  const F twice = unit + unit;
  add(sum.towards.x, w[2] << 12 >> 12, twice);
  add(sum.towards.y, (w[2] >> 20 & I(0xfff)) | (w[3] << 24 >> 12), twice);
  add(sum.towards.z, w[3] << 4 >> 12, twice);
}

/// The eight voxels around a point, of which number i has the high one of each axis whose bit is set (x: 4, y: 2, z:
/// 1), and where between their centres it is; constant beyond the outermost centres.
template <class F>
struct LightCellOf {
  using I = IntOf<F>;
  Vec3<I> low, high;
  Vec3<F> t;
  /// Bits of the axes along which any lane's voxels lie in two bricks.
  std::int32_t crossed = 0;

  VOLCAUSTIC_HD LightCellOf(const Int3& dims, const Vec3<F>& p) {
    axis(p.x, dims.x, 4, low.x, high.x, t.x);
    axis(p.y, dims.y, 2, low.y, high.y, t.y);
    axis(p.z, dims.z, 1, low.z, high.z, t.z);
  }
  [[nodiscard]] VOLCAUSTIC_HD Vec3<I> corner(std::int32_t i) const {
    return {i & 4 ? high.x : low.x, i & 2 ? high.y : low.y, i & 1 ? high.z : low.z};
  }
  [[nodiscard]] VOLCAUSTIC_HD F weight(std::int32_t i) const {
    return (i & 4 ? t.x : F(1) - t.x) * (i & 2 ? t.y : F(1) - t.y) * (i & 1 ? t.z : F(1) - t.z);
  }

private:
  VOLCAUSTIC_HD void axis(F p, std::int32_t dim, std::int32_t bit, I& from, I& to, F& within) {
    const F q = clampTo(p - F(0.5f), F(0), F(static_cast<float>(dim - 1)));
    from = toInt(q);
    to = smaller(from + I(1), I(dim - 1));
    within = q - toFloat(from);
    if (any((from >> 3) != (to >> 3))) crossed |= bit;
  }
};

template <class I>
VOLCAUSTIC_HD inline I brickIndexOf(const Int3& brickDims, const Vec3<I>& v) {
  return ((v.x >> 3) * I(brickDims.y) + (v.y >> 3)) * I(brickDims.z) + (v.z >> 3);
}

/// A table's entries for the bricks of a cell's voxels; looked up once for all that lie in the same brick in every
/// lane.
template <class F>
struct CornerEntries {
  IntOf<F> of[8];

  VOLCAUSTIC_HD CornerEntries(const std::int32_t* table, const Int3& brickDims, const LightCellOf<F>& cell) {
    for (std::int32_t i = 0; i < 8; ++i)
      of[i] = i & ~cell.crossed ? of[i & cell.crossed] : gather(table, brickIndexOf(brickDims, cell.corner(i)));
  }
};

/// A sparse volume of light as kernels read it: for each brick of 8x8x8 voxels (z fastest) an entry e; 0: dark; e > 0:
/// 512 voxels from voxels + 512 (e - 1) on, z fastest; e < 0: constants[~e] all over.
struct FluenceField {
  Int3 dims, brickDims;
  const std::int32_t* entries = nullptr;
  const FluenceVoxel* voxels = nullptr;
  const FluenceVoxel* constants = nullptr;

  [[nodiscard]] VOLCAUSTIC_HD std::int64_t brickOf(const Int3& v) const {
    return (static_cast<std::int64_t>(v.x >> 3) * brickDims.y + (v.y >> 3)) * brickDims.z + (v.z >> 3);
  }
  /// The light of a voxel whose brick's entry is known.
  [[nodiscard]] VOLCAUSTIC_HD Light at(std::int32_t entry, const Int3& v) const {
    if (entry == 0) return {};
    return unpack(entry < 0 ? constants[~entry]
                            : voxels[(entry - 1) * std::int64_t{kStepVoxels} + FlatMedium::voxelOffset(v)]);
  }
  [[nodiscard]] VOLCAUSTIC_HD Light at(const Int3& v) const { return at(entries[brickOf(v)], v); }

  /// sum += weight times the light of a voxel whose brick's entry is known, for the lanes `on`.
  template <class F>
  VOLCAUSTIC_HD void addVoxel(LightOf<F>& sum, const IntOf<F>& entry, const Vec3<IntOf<F>>& v, F weight,
                              const MaskOf<F>& on, bool directed) const {
    using I = IntOf<F>;
    const MaskOf<F> stored = both(on, entry > I(0)), constant = both(on, entry < I(0));
    if (any(stored)) {
      const I slot = select(stored, entry - I(1), I(0));
      addUnpacked<F>(sum, loadVoxel(voxels, slot, FlatMedium::voxelOffset(v)), select(stored, weight, F(0)), directed);
    }
    if (any(constant)) {
      const I number = select(constant, ~entry, I(0));
      addUnpacked<F>(sum, loadVoxel(constants, number >> 9, number & I(kStepVoxels - 1)),
                     select(constant, weight, F(0)), directed);
    }
  }
  /// Trilinear between voxel centres, for the lanes `on`; towards only where `directed`.
  template <class F>
  [[nodiscard]] VOLCAUSTIC_HD LightOf<F> sample(const LightCellOf<F>& cell, const MaskOf<F>& on, bool directed) const {
    using I = IntOf<F>;
    LightOf<F> sum;
    const CornerEntries<F> entry(entries, brickDims, cell);
    for (std::int32_t i = 0; i < 8; ++i)
      if (any(both(on, entry.of[i] != I(0)))) addVoxel(sum, entry.of[i], cell.corner(i), cell.weight(i), on, directed);
    return sum;
  }
  [[nodiscard]] VOLCAUSTIC_HD Light sample(const Float3& p) const {
    return sample<float>(LightCellOf<float>(dims, p), true, true);
  }
};

} // namespace volcaustic::kernels
