// Light as the camera's rays read it: half floats in bricks that hold all corners of their cells.
//
// A ray reads light at every step, so reading has to be cheap: the two voxels of a cell's edge along z are one load of
// sixteen bytes, and a brick needs no neighbour. The packed light of fluence.h is turned into this form once a picture,
// for the bricks in which something scatters. Halves are good to 2^-11 of each number, in bricks whose greatest number
// is scaled to 2^15.
#pragma once

#include "kernels/lamp.h"

namespace volcaustic::kernels {

/// Three numbers of a voxel as IEEE half floats.
struct alignas(8) HalfVoxel {
  std::uint16_t x, y, z, unused;
};

VOLCAUSTIC_HD inline float floatOfHalf(std::uint16_t h) {
  const std::uint32_t sign = static_cast<std::uint32_t>(h & 0x8000) << 16, rest = static_cast<std::uint32_t>(h & 0x7fff)
                                                                                  << 13;
  // The exponents of floats count from 2^-127, those of halves from 2^-15; subnormal halves come out right, too.
  return __builtin_bit_cast(float,
                            sign | __builtin_bit_cast(std::uint32_t, __builtin_bit_cast(float, rest) * 0x1p112f));
}
/// The nearest half, of two the even one, for |v| < 65520.
VOLCAUSTIC_HD inline std::uint16_t halfOf(float v) {
  const auto bits = __builtin_bit_cast(std::uint32_t, v);
  const auto rest = __builtin_bit_cast(std::uint32_t, __builtin_bit_cast(float, bits & 0x7fffffffu) * 0x1p-112f);
  return static_cast<std::uint16_t>(bits >> 16 & 0x8000) |
         static_cast<std::uint16_t>((rest + 0xfff + (rest >> 13 & 1)) >> 13);
}

/// What an entry of a LightTexture's table says of a brick of cells; a cell belongs to the brick of its low corner.
/// 0: dark; above 0: 729 voxels from voxels + 729 * textureSlot() on, in units of textureUnit(); below 0 (direct light
/// only): all its cells are lit by the lamps of set ~entry and by nothing else.
inline constexpr std::int32_t kTextureSlotMask = (1 << 23) - 1;
template <class I>
VOLCAUSTIC_HD inline I textureSlot(const I& entry) {
  return entry & I(kTextureSlotMask);
}
template <class I>
VOLCAUSTIC_HD inline auto textureUnit(const I& entry) {
  return floatOfBits(entry & I(~kTextureSlotMask));
}

/// The bits of an entry that say how big a unit is, for numbers up to `most`: halves up to 2^15. 0 where all are less
/// than anybody can see.
VOLCAUSTIC_HD inline std::int32_t textureUnitFor(float most) {
  const std::int32_t exponent = (__builtin_bit_cast(std::int32_t, most) >> 23) - 14;
  return exponent > 0 ? exponent << 23 : 0;
}
/// What turns numbers into units.
VOLCAUSTIC_HD inline float inverseOfUnit(std::int32_t bits) { return floatOfBits((254 << 23) - bits); }

struct LightTexture {
  const std::int32_t* entries = nullptr;
  const HalfVoxel* voxels = nullptr;
};

/// Trilinear mean of the eight voxels from `offset` on, z fastest. One cell at a time here; lanes have their own.
VOLCAUSTIC_HD inline Float3 mixCell(const HalfVoxel* voxels, std::int32_t offset, const Float3& t) {
  constexpr int kX = kFieldEdge * kFieldEdge, kY = kFieldEdge;
  const HalfVoxel* c = voxels + offset;
  const auto at = [c](int i) { return Float3(floatOfHalf(c[i].x), floatOfHalf(c[i].y), floatOfHalf(c[i].z)); };
  const float xy = t.x * t.y, w00 = 1 - t.x - t.y + xy, w01 = t.y - xy, w10 = t.x - xy;
  const auto layer = [&](int z) { return at(z) * w00 + at(kY + z) * w01 + at(kX + z) * w10 + at(kX + kY + z) * xy; };
  const Float3 low = layer(0);
  return low + (layer(1) - low) * t.z;
}

/// The cell of eight voxel centres around a point, by its low corner, and where in it the point is; constant beyond the
/// outermost centres.
template <class F>
struct TextureCell {
  Vec3<IntOf<F>> low;
  Vec3<F> t;

  VOLCAUSTIC_HD TextureCell(const Int3& dims, const Vec3<F>& p) {
    axis(p.x, dims.x, low.x, t.x);
    axis(p.y, dims.y, low.y, t.y);
    axis(p.z, dims.z, low.z, t.z);
  }

private:
  VOLCAUSTIC_HD static void axis(F p, std::int32_t dim, IntOf<F>& from, F& within) {
    const F q = clampTo(p - F(0.5f), F(0), F(static_cast<float>(dim - 1)));
    from = toInt(q);
    within = q - toFloat(from);
  }
};

/// Light at a point: fluence of both parts, and the luminance-weighted directions of their sum.
template <class F>
struct ViewLightSample {
  Vec3<F> caustic{F(0), F(0), F(0)}, direct{F(0), F(0), F(0)}, towards{F(0), F(0), F(0)};
};

struct ViewLight {
  Int3 dims, brickDims;
  LightTexture caustic, direct, towards; ///< `towards` is of both; without entries where nothing has asymmetry
  DirectField lamps;

  /// For the lanes `on`; directions only where `directed`.
  template <class F>
  [[nodiscard]] VOLCAUSTIC_HD ViewLightSample<F> sample(const Vec3<F>& p, const MaskOf<F>& on, bool directed) const {
    using I = IntOf<F>;
    const TextureCell<F> cell(dims, p);
    const I brick = brickIndexOf(brickDims, cell.low);
    ViewLightSample<F> light;
    light.caustic = mixStored(caustic, gather(caustic.entries, brick), cell, on);
    const I entry = gather(direct.entries, brick);
    light.direct = mixStored(direct, entry, cell, on);
    if (directed) light.towards = mixStored(towards, gather(towards.entries, brick), cell, on);
    addLamps(light, entry, p, on, directed);
    return light;
  }
  /// Of the lamps alone, for lanes `on` in cells that nothing else lights.
  template <class F>
  VOLCAUSTIC_HD void addLamps(ViewLightSample<F>& light, const IntOf<F>& entry, const Vec3<F>& p, const MaskOf<F>& on,
                              bool directed) const {
    const MaskOf<F> lamplit = both(on, entry < IntOf<F>(0));
    if (!any(lamplit)) return;
    const LightOf<F> l = lamps.lit<F>(~entry, p, lamplit, directed);
    light.direct += l.fluence;
    light.towards += l.towards;
  }

private:
  template <class F>
  VOLCAUSTIC_HD static Vec3<F> mixStored(const LightTexture& texture, const IntOf<F>& entry, const TextureCell<F>& cell,
                                         const MaskOf<F>& on) {
    using I = IntOf<F>;
    const MaskOf<F> stored = both(on, entry > I(0));
    if (!any(stored)) return Vec3<F>(F(0));
    const I safe = select(stored, entry, I(0)); // slot 0 is dark
    return mixCell(texture.voxels, fieldOffset(textureSlot(safe), cell.low), cell.t) * textureUnit(safe);
  }
};

} // namespace volcaustic::kernels
