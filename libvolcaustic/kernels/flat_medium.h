// The medium as the kernels read it: a table of bricks over the domain, and packed voxels for the bricks where
// something varies.
//
//   bricks[brickDims.x][brickDims.y][brickDims.z]     one BrickRecord each (z fastest)
//     .field  -> fields + 729 * slot                  n and grad n at 9x9x9 voxel centres: the brick's 8x8x8 and one
//     more
//                                                     layer on the high sides, so a trilinear lookup touches one brick
//     .steps  -> steps + 512 * slot                   a step byte for each voxel
//     .optics -> voxelOptics + 512 * slot             index into `optics` for each voxel
//
// Grid space: voxel (i, j, k) is the cube [i, i+1] x [j, j+1] x [k, k+1], its centre at +1/2; gradients are per voxel.
#pragma once

#include "kernels/vec.h"

namespace volcaustic::kernels {

inline constexpr int kFieldEdge = 9;
inline constexpr int kFieldVoxels = kFieldEdge * kFieldEdge * kFieldEdge;
inline constexpr int kStepVoxels = 512;

/// Index and its gradient at a voxel centre; one aligned load.
struct alignas(16) FieldVoxel {
  float n = 1, gx = 0, gy = 0, gz = 0;
};

/// Coefficients in 1/voxel.
struct Optics {
  Float3 attenuation{0, 0, 0};
  Float3 scattering{0, 0, 0};
  float asymmetry = 0;
};

/// A step byte: the level of the voxel's constant cube, whether its steps are capped, and whether light bends here (or
/// the optics are not the ambient ones), so that photons which meet it have to be marched.
inline constexpr std::uint8_t kStepLevelMask = 0x1f;
inline constexpr std::uint8_t kStepCappedBit = 0x40;
inline constexpr std::uint8_t kStepBendsBit = 0x80;

struct BrickRecord {
  std::int32_t field = -1;  ///< slot, or -1: the index is `index` all over, and its gradient zero
  std::int32_t steps = -1;  ///< slot, or -1: `step` holds all over
  std::int32_t optics = -1; ///< slot, or -1: `constantOptics` holds all over
  std::int32_t constantOptics = 0;
  float index = 1;
  std::uint8_t step = 0;
  std::uint8_t bends = 0; ///< 1 when any voxel has kStepBendsBit
};

struct FlatMedium {
  Int3 dims, brickDims;
  const BrickRecord* bricks = nullptr;
  const FieldVoxel* fields = nullptr;
  const std::uint8_t* steps = nullptr;
  const std::uint32_t* voxelOptics = nullptr;
  const Optics* optics = nullptr; ///< entry 0 is the ambient medium
  float cap = 2;                  ///< longest step where kStepCappedBit is set, voxels

  VOLCAUSTIC_HD const BrickRecord& brickOf(int x, int y, int z) const {
    return bricks[((x >> 3) * brickDims.y + (y >> 3)) * brickDims.z + (z >> 3)];
  }
  /// The voxel that holds p, clamped into the domain.
  VOLCAUSTIC_HD Int3 voxelOf(const Float3& p) const {
    return {clampTo(static_cast<int>(std::floor(p.x)), 0, dims.x - 1),
            clampTo(static_cast<int>(std::floor(p.y)), 0, dims.y - 1),
            clampTo(static_cast<int>(std::floor(p.z)), 0, dims.z - 1)};
  }
  VOLCAUSTIC_HD static int voxelOffset(const Int3& v) { return ((v.x & 7) << 6) | ((v.y & 7) << 3) | (v.z & 7); }

  VOLCAUSTIC_HD std::uint8_t stepAt(const Int3& v) const {
    const BrickRecord& b = brickOf(v.x, v.y, v.z);
    return b.steps < 0 ? b.step : steps[b.steps * kStepVoxels + voxelOffset(v)];
  }
  VOLCAUSTIC_HD const Optics& opticsAt(const Int3& v) const {
    const BrickRecord& b = brickOf(v.x, v.y, v.z);
    return optics[b.optics < 0 ? b.constantOptics : voxelOptics[b.optics * kStepVoxels + voxelOffset(v)]];
  }
};

/// n and grad n at a point.
struct FieldSample {
  float n;
  Float3 gradient;
};

VOLCAUSTIC_HD inline FieldVoxel mix(const FieldVoxel& a, const FieldVoxel& b, float t) {
  return {a.n + t * (b.n - a.n), a.gx + t * (b.gx - a.gx), a.gy + t * (b.gy - a.gy), a.gz + t * (b.gz - a.gz)};
}

/// Trilinear in n and in grad n, which is itself a central difference at voxel centres. The gradient differentiated
/// from trilinear n would jump at every voxel centre; this one does not. Within half a voxel of the domain's faces both
/// are extrapolated from the two nearest layers.
VOLCAUSTIC_HD inline FieldSample sampleField(const FlatMedium& m, const Float3& p) {
  const Float3 q = p - Float3(0.5f);
  const Int3 base{clampTo(static_cast<int>(std::floor(q.x)), 0, larger(m.dims.x - 2, 0)),
                  clampTo(static_cast<int>(std::floor(q.y)), 0, larger(m.dims.y - 2, 0)),
                  clampTo(static_cast<int>(std::floor(q.z)), 0, larger(m.dims.z - 2, 0))};
  const BrickRecord& brick = m.brickOf(base.x, base.y, base.z);
  if (brick.field < 0) return {brick.index, Float3(0, 0, 0)};

  constexpr int kX = kFieldEdge * kFieldEdge, kY = kFieldEdge;
  const FieldVoxel* c = m.fields + static_cast<std::int64_t>(brick.field) * kFieldVoxels + (base.x & 7) * kX +
                        (base.y & 7) * kY + (base.z & 7);
  const Float3 t = q - Float3(static_cast<float>(base.x), static_cast<float>(base.y), static_cast<float>(base.z));
  const FieldVoxel x00 = mix(mix(c[0], c[1], t.z), mix(c[kY], c[kY + 1], t.z), t.y);
  const FieldVoxel x01 = mix(mix(c[kX], c[kX + 1], t.z), mix(c[kX + kY], c[kX + kY + 1], t.z), t.y);
  const FieldVoxel f = mix(x00, x01, t.x);
  return {f.n, Float3(f.gx, f.gy, f.gz)};
}

} // namespace volcaustic::kernels
