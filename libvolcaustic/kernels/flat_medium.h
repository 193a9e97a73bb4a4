// The medium as the kernels read it: tables with an entry for each 8x8x8 brick of the domain, and packed voxels for the
// bricks where something varies.
//
//   table (z fastest)          entry e of a brick                   voxels
//   fieldSlots                 e > 0: slot                          fields + 729 e: n, grad n at 9x9x9 centres,
//                              0: n is one value, its gradient 0      the brick's 8x8x8 and one more layer on the high
//                                                                     sides, so a trilinear lookup touches one brick
//   indexOffsets               n - ambientIndex where fieldSlots is 0
//   stepSlots                  e > 0: slot; 0: the ambient byte;    steps + 512 e: a step byte for each voxel
//                              e < 0: the byte ~e all over
//   opticsSlots                e > 0: slot; e <= 0: entry -e all    voxelOptics + 512 e: entries of `optics`
//                              over
//   bends                      1 when any voxel's step byte has kStepBendsBit
//
// Zero is the ambient medium in every table: pages of a table that nothing was written to cost no memory. Slots begin
// at 1; slot 0 of each voxel array is the ambient medium too, so that lanes need no mask to read it.
//
// Grid space: voxel (i, j, k) is the cube [i, i+1] x [j, j+1] x [k, k+1], its centre at +1/2; gradients are per voxel.
#pragma once

#include "kernels/lanes.h"

namespace volcaustic::kernels {

inline constexpr int kFieldEdge = 9;
inline constexpr int kFieldVoxels = kFieldEdge * kFieldEdge * kFieldEdge;
inline constexpr int kStepVoxels = 512;

/// Index and its gradient at a voxel centre; one aligned load. Two neighbours along z are one load of 32 bytes.
struct alignas(16) FieldVoxel {
  float n, gx, gy, gz;
};

/// Coefficients in 1/voxel.
struct Optics {
  Float3 attenuation{0, 0, 0};
  Float3 scattering{0, 0, 0};
  float asymmetry = 0;
};
inline constexpr int kOpticsFloats = sizeof(Optics) / sizeof(float);

/// A step byte: the level of the voxel's constant cube, whether its steps are capped, and whether light bends here (or
/// the optics are not the ambient ones), so that photons which meet it have to be marched.
inline constexpr std::uint8_t kStepLevelMask = 0x1f;
inline constexpr std::uint8_t kStepCappedBit = 0x40;
inline constexpr std::uint8_t kStepBendsBit = 0x80;
/// Lanes fetch a byte as the low part of four: the array is longer by this much.
inline constexpr int kStepPadding = 3;

struct FlatMedium {
  Int3 dims, brickDims;
  const std::int32_t* fieldSlots = nullptr;
  const float* indexOffsets = nullptr;
  const std::int32_t* stepSlots = nullptr;
  const std::int32_t* opticsSlots = nullptr;
  const std::uint8_t* bends = nullptr;
  const FieldVoxel* fields = nullptr;
  const std::uint8_t* steps = nullptr;
  const std::int32_t* voxelOptics = nullptr;
  const Optics* optics = nullptr; ///< entry 0 is the ambient medium
  float ambientIndex = 1;
  std::int32_t ambientStep = 0;
  float cap = 2;           ///< longest step where kStepCappedBit is set, voxels
  bool attenuates = false; ///< whether any entry of `optics` does
  /// Elements of the voxel arrays, for whoever copies them to another machine; each table has one for each brick.
  std::int64_t fieldCount = 0, stepCount = 0, voxelOpticsCount = 0, opticsCount = 0;

  VOLCAUSTIC_HD std::int64_t brickCount() const {
    return static_cast<std::int64_t>(brickDims.x) * brickDims.y * brickDims.z;
  }
  template <class I>
  VOLCAUSTIC_HD I brickIndex(const Vec3<I>& v) const {
    return ((v.x >> 3) * I(brickDims.y) + (v.y >> 3)) * I(brickDims.z) + (v.z >> 3);
  }
  /// The voxel that holds p, clamped into the domain. Below zero rounding towards it makes no difference then.
  template <class F>
  VOLCAUSTIC_HD Vec3<IntOf<F>> voxelOf(const Vec3<F>& p) const {
    using I = IntOf<F>;
    return {clampTo(toInt(p.x), I(0), I(dims.x - 1)), clampTo(toInt(p.y), I(0), I(dims.y - 1)),
            clampTo(toInt(p.z), I(0), I(dims.z - 1))};
  }
  template <class I>
  VOLCAUSTIC_HD static I voxelOffset(const Vec3<I>& v) {
    return ((v.x & I(7)) << 6) | ((v.y & I(7)) << 3) | (v.z & I(7));
  }

  /// The step byte of a voxel.
  template <class I>
  VOLCAUSTIC_HD I stepAt(const Vec3<I>& v) const {
    const I slot = gather(stepSlots, brickIndex(v));
    const I byte = gatherByte(steps, larger(slot, I(0)) * I(kStepVoxels) + voxelOffset(v));
    return select(slot < I(0), ~slot, byte);
  }
  /// The voxel's entry in `optics`.
  template <class I>
  VOLCAUSTIC_HD I opticsIndex(const Vec3<I>& v) const {
    const I slot = gather(opticsSlots, brickIndex(v));
    const I entry = gather(voxelOptics, larger(slot, I(0)) * I(kStepVoxels) + voxelOffset(v));
    return select(slot > I(0), entry, -slot);
  }
  VOLCAUSTIC_HD const Optics& opticsAt(const Int3& v) const { return optics[opticsIndex(v)]; }
};

/// n and grad n at a point.
template <class F>
struct FieldSample {
  F n;
  Vec3<F> gradient;
};

VOLCAUSTIC_HD inline FieldVoxel mix(const FieldVoxel& a, const FieldVoxel& b, float t) {
  return {a.n + t * (b.n - a.n), a.gx + t * (b.gx - a.gx), a.gy + t * (b.gy - a.gy), a.gz + t * (b.gz - a.gz)};
}

/// Trilinear mean of the eight field voxels from `offset` on, z fastest. One number at a time here; lanes have their
/// own.
VOLCAUSTIC_HD inline FieldSample<float> mixCell(const FieldVoxel* fields, std::int32_t offset, const Float3& t) {
  constexpr int kX = kFieldEdge * kFieldEdge, kY = kFieldEdge;
  const FieldVoxel* c = fields + offset;
  const FieldVoxel x00 = mix(mix(c[0], c[1], t.z), mix(c[kY], c[kY + 1], t.z), t.y);
  const FieldVoxel x01 = mix(mix(c[kX], c[kX + 1], t.z), mix(c[kX + kY], c[kX + kY + 1], t.z), t.y);
  const FieldVoxel f = mix(x00, x01, t.x);
  return {f.n, Float3(f.gx, f.gy, f.gz)};
}
VOLCAUSTIC_HD inline FieldSample<float> loadVoxel(const FieldVoxel* fields, std::int32_t offset) {
  const FieldVoxel& f = fields[offset];
  return {f.n, Float3(f.gx, f.gy, f.gz)};
}

/// Element of `fields` for a voxel in a brick's slot.
template <class I>
VOLCAUSTIC_HD inline I fieldOffset(I slot, const Vec3<I>& v) {
  return slot * I(kFieldVoxels) + (v.x & I(7)) * I(kFieldEdge * kFieldEdge) + (v.y & I(7)) * I(kFieldEdge) +
         (v.z & I(7));
}

/// Where n is one value over a brick, its table entry holds it.
template <class F>
VOLCAUSTIC_HD inline FieldSample<F> withBrickIndex(const FlatMedium& m, FieldSample<F> f, IntOf<F> brick,
                                                   IntOf<F> slot) {
  const auto flat = slot == IntOf<F>(0);
  if (any(flat)) f.n = select(flat, gather(m.indexOffsets, brick) + F(m.ambientIndex), f.n);
  return f;
}

/// Trilinear in n and in grad n, which is itself a central difference at voxel centres. The gradient differentiated
/// from trilinear n would jump at every voxel centre; this one does not. Within half a voxel of the domain's faces both
/// are extrapolated from the two nearest layers.
template <class F>
VOLCAUSTIC_HD inline FieldSample<F> sampleField(const FlatMedium& m, const Vec3<F>& p) {
  using I = IntOf<F>;
  const Vec3<F> q = p - Vec3<F>(F(0.5f));
  const Vec3<I> base{clampTo(toInt(q.x), I(0), I(larger(m.dims.x - 2, 0))),
                     clampTo(toInt(q.y), I(0), I(larger(m.dims.y - 2, 0))),
                     clampTo(toInt(q.z), I(0), I(larger(m.dims.z - 2, 0)))};
  const I brick = m.brickIndex(base);
  const I slot = gather(m.fieldSlots, brick);
  if (!any(slot != I(0))) return {gather(m.indexOffsets, brick) + F(m.ambientIndex), Vec3<F>(F(0))};
  const Vec3<F> t = q - Vec3<F>(toFloat(base.x), toFloat(base.y), toFloat(base.z));
  return withBrickIndex(m, mixCell(m.fields, fieldOffset(slot, base), t), brick, slot);
}

/// n and grad n of the voxel that holds the point.
template <class F>
VOLCAUSTIC_HD inline FieldSample<F> nearestField(const FlatMedium& m, const Vec3<F>& p) {
  const Vec3<IntOf<F>> voxel = m.voxelOf(p);
  const IntOf<F> brick = m.brickIndex(voxel), slot = gather(m.fieldSlots, brick);
  return withBrickIndex(m, loadVoxel(m.fields, fieldOffset(slot, voxel)), brick, slot);
}

} // namespace volcaustic::kernels
