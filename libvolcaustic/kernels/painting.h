// Bodies painted over the ambient medium by their coverage, and the Gaussian on the index: what volume/optics does
// brick by brick and grid by grid, for all grids at once. docs/algorithms/cuda.md, "The medium".
#pragma once

#include "kernels/bricks.h"
#include "kernels/index_taps.h"

namespace volcaustic::kernels {

/// What is inside of a brick of a body's patch: nothing, everything, or as its counts say.
enum class BrickFill : std::uint8_t { Empty, Full, Counted };

/// What a medium says of a point; coefficients in 1/world.
struct PointOptics {
  float index = 1, coverage = 0;
  Float3 attenuation{0, 0, 0}, scattering{0, 0, 0};
  float asymmetry = 0;
};

/// Exact at both ends, and where both ends are equal.
VOLCAUSTIC_HD inline float mixTo(float from, float to, float t) { return t == 1.0f ? to : from + t * (to - from); }
VOLCAUSTIC_HD inline Float3 mixTo(const Float3& from, const Float3& to, float t) {
  return {mixTo(from.x, to.x, t), mixTo(from.y, to.y, t), mixTo(from.z, to.z, t)};
}

/// Coverage as of bodies that are placed independently inside a voxel.
VOLCAUSTIC_HD inline float coverTo(float coverage, float t) { return 1.0f - (1.0f - coverage) * (1.0f - t); }

/// A body: samples inside of each voxel of a box of bricks, and what it is made of.
struct PaintedBody {
  Int3 first, bricks;           ///< of the domain's bricks
  const BrickFill* fills;       ///< of each brick of the box
  const std::uint32_t* counted; ///< bricks before each that are Counted
  const std::uint16_t* counts;  ///< of their voxels
  float fraction;               ///< of the voxel, that one sample is
  PointOptics optics;

  /// The brick of the box, or -1.
  VOLCAUSTIC_HD std::int64_t at(const Int3& brick) const {
    const Int3 b = brick - first;
    if (b.x < 0 || b.y < 0 || b.z < 0 || b.x >= bricks.x || b.y >= bricks.y || b.z >= bricks.z) return -1;
    return (std::int64_t{b.x} * bricks.y + b.y) * bricks.z + b.z;
  }
  VOLCAUSTIC_HD void paint(PointOptics& o, float c) const {
    o.index = mixTo(o.index, optics.index, c);
    o.coverage = coverTo(o.coverage, c);
    o.attenuation = mixTo(o.attenuation, optics.attenuation, c);
    o.scattering = mixTo(o.scattering, optics.scattering, c);
    o.asymmetry = mixTo(o.asymmetry, optics.asymmetry, c);
  }
};

/// In the order in which they are painted.
struct PaintedBodies {
  const PaintedBody* bodies;
  std::int32_t count;
};

/// Grids as bits; that of the index is looked at by all, the others where a body changes them.
enum PaintedGrids : std::uint8_t {
  kIndexBit = 1,
  kCoverageBit = 2,
  kAttenuationBit = 4,
  kScatteringBit = 8,
  kAsymmetryBit = 16
};
inline constexpr std::uint8_t kOpticsBits = kAttenuationBit | kScatteringBit | kAsymmetryBit;

/// The painted medium. A brick that some body's counts vary in has voxels in all grids that are there, and bits for
/// those of them in which its voxels differ.
struct PaintedBricks {
  BrickLayout layout;
  PointOptics ambient;
  std::uint8_t grids;  ///< that are there
  std::int32_t* slots; ///< 0: ambient; s > 0: voxels of s - 1; s < 0: constants[-s - 1]
  PointOptics* constants;
  std::int64_t* bricks;    ///< of each slot
  std::uint8_t* varies;    ///< of each slot: bits of the grids that differ inside it
  float *index, *coverage; ///< of the slots' voxels
  Float3 *attenuation, *scattering;
  float* asymmetry;

  VOLCAUSTIC_HD bool isConstant(std::int64_t b, std::uint8_t grid) const {
    return slots[b] <= 0 || !(varies[slots[b] - 1] & grid);
  }
  VOLCAUSTIC_HD PointOptics at(std::int64_t b, int offset) const {
    const std::int32_t slot = slots[b];
    if (slot <= 0) return slot == 0 ? ambient : constants[-slot - 1];
    const std::int64_t v = (std::int64_t{slot} - 1) * kVoxelsOfBrick + offset;
    PointOptics o = ambient;
    o.index = index[v];
    o.coverage = coverage[v];
    if (grids & kAttenuationBit) o.attenuation = attenuation[v];
    if (grids & kScatteringBit) o.scattering = scattering[v];
    if (grids & kAsymmetryBit) o.asymmetry = asymmetry[v];
    return o;
  }
};

/// The painted index as a grid.
struct PaintedIndex {
  BrickLayout layout;
  float ambient;
  PaintedBricks painted;

  VOLCAUSTIC_HD explicit PaintedIndex(const PaintedBricks& p)
      : layout(p.layout), ambient(p.ambient.index), painted(p) {}
  VOLCAUSTIC_HD bool isConstant(std::int64_t b) const { return painted.isConstant(b, kIndexBit); }
  VOLCAUSTIC_HD float constant(std::int64_t b) const { return voxel(b, 0); }
  VOLCAUSTIC_HD float voxel(std::int64_t b, int offset) const {
    const std::int32_t slot = painted.slots[b];
    if (slot > 0) return painted.index[(std::int64_t{slot} - 1) * kVoxelsOfBrick + offset];
    return slot == 0 ? ambient : painted.constants[-slot - 1].index;
  }
};
/// The painted attenuation as a grid.
struct PaintedAttenuation {
  BrickLayout layout;
  Float3 ambient;
  PaintedBricks painted;

  VOLCAUSTIC_HD explicit PaintedAttenuation(const PaintedBricks& p)
      : layout(p.layout), ambient(p.ambient.attenuation), painted(p) {}
  VOLCAUSTIC_HD bool isConstant(std::int64_t b) const { return painted.isConstant(b, kAttenuationBit); }
  VOLCAUSTIC_HD Float3 constant(std::int64_t b) const { return voxel(b, 0); }
  VOLCAUSTIC_HD Float3 voxel(std::int64_t b, int offset) const {
    const std::int32_t slot = painted.slots[b];
    if (slot <= 0) return slot == 0 ? ambient : painted.constants[-slot - 1].attenuation;
    if (!(painted.grids & kAttenuationBit)) return ambient;
    return painted.attenuation[(std::int64_t{slot} - 1) * kVoxelsOfBrick + offset];
  }
};

/// An element a brick: counts of 0 or 1, whether it has voxels of its own, or a constant of its own.
struct ClassifyPainted {
  BrickLayout layout;
  PaintedBodies painted;
  std::uint32_t *voxels, *constants;

  VOLCAUSTIC_HD void operator()(std::int64_t b) const {
    const Int3 brick = layout.coord(b);
    bool counted = false, full = false;
    for (std::int32_t i = 0; i < painted.count; ++i) {
      const std::int64_t at = painted.bodies[i].at(brick);
      if (at < 0) continue;
      counted = counted || painted.bodies[i].fills[at] == BrickFill::Counted;
      full = full || painted.bodies[i].fills[at] == BrickFill::Full;
    }
    voxels[b] = counted;
    constants[b] = !counted && full;
  }
};

/// An element a brick, once the counts of ClassifyPainted are sums of those before.
struct PlacePainted {
  PaintedBricks out;
  PaintedBodies painted;
  const std::uint32_t *voxels, *constants;

  VOLCAUSTIC_HD void operator()(std::int64_t b) const {
    out.slots[b] = 0;
    if (voxels[b] != voxels[b + 1]) {
      out.slots[b] = static_cast<std::int32_t>(voxels[b]) + 1;
      out.bricks[voxels[b]] = b;
    } else if (constants[b] != constants[b + 1]) {
      out.slots[b] = -static_cast<std::int32_t>(constants[b]) - 1;
      PointOptics o = out.ambient;
      const Int3 brick = out.layout.coord(b);
      for (std::int32_t i = 0; i < painted.count; ++i)
        if (const std::int64_t at = painted.bodies[i].at(brick);
            at >= 0 && painted.bodies[i].fills[at] == BrickFill::Full)
          painted.bodies[i].paint(o, 1.0f);
      out.constants[constants[b]] = o;
    }
  }
};

/// A block a slot: its voxels in all grids.
struct PaintVoxels {
  PaintedBricks out;
  PaintedBodies painted;

  struct Shared {};
  template <class Block>
  VOLCAUSTIC_HD void operator()(Block& block, Shared&, std::int64_t slot) const {
    const Int3 brick = out.layout.coord(out.bricks[slot]);
    const std::int64_t first = slot * kVoxelsOfBrick;
    block.forEach(kVoxelsOfBrick, [&](int v) { write(first + v, voxel(brick, v)); });
    std::uint8_t bits = 0;
    const auto look = [&](std::uint8_t grid, const auto* values) {
      if (!(out.grids & grid)) return;
      values += first;
      if (block.any(kVoxelsOfBrick, [&](int v) { return differ(values[v], values[0]); })) bits |= grid;
    };
    look(kIndexBit, out.index);
    look(kCoverageBit, out.coverage);
    look(kAttenuationBit, out.attenuation);
    look(kScatteringBit, out.scattering);
    look(kAsymmetryBit, out.asymmetry);
    block.forEach(1, [&](int) { out.varies[slot] = bits; });
  }

private:
  VOLCAUSTIC_HD PointOptics voxel(const Int3& brick, int v) const {
    PointOptics o = out.ambient;
    for (std::int32_t i = 0; i < painted.count; ++i) {
      const PaintedBody& body = painted.bodies[i];
      const std::int64_t at = body.at(brick);
      if (at < 0 || body.fills[at] == BrickFill::Empty) continue;
      const bool full = body.fills[at] == BrickFill::Full;
      body.paint(o, full ? 1.0f : body.fraction * body.counts[std::int64_t{body.counted[at]} * kVoxelsOfBrick + v]);
    }
    return o;
  }
  VOLCAUSTIC_HD void write(std::int64_t v, const PointOptics& o) const {
    out.index[v] = o.index;
    out.coverage[v] = o.coverage;
    if (out.grids & kAttenuationBit) out.attenuation[v] = o.attenuation;
    if (out.grids & kScatteringBit) out.scattering[v] = o.scattering;
    if (out.grids & kAsymmetryBit) out.asymmetry[v] = o.asymmetry;
  }
};

/// An element a brick: 1 where smoothing may change the brick, or it varies.
struct MarkBlurred {
  PaintedIndex in;
  std::uint32_t* marks;
  VOLCAUSTIC_HD void operator()(std::int64_t b) const { marks[b] = !uniformAround(in, b); }
};
/// An element a brick: the list of those that are marked, and what the index is where they turn out constant.
struct ListBlurred {
  PaintedIndex in;
  const std::uint32_t* marks; ///< summed up
  std::int64_t* bricks;
  std::int32_t* slots;
  float* constants;
  VOLCAUSTIC_HD void operator()(std::int64_t b) const {
    slots[b] = 0;
    constants[b] = in.constant(b);
    if (marks[b] != marks[b + 1]) bricks[marks[b]] = b;
  }
};

/// A Gaussian's weights beside the middle one.
inline constexpr int kMostBlurRadius = 5;
struct BlurWeights {
  float of[kMostBlurRadius];
};

/// A block a brick of the list: first whether it needs voxels of its own, then, with slots given, their values.
template <int Radius>
struct BlurBricks {
  static constexpr int kEdge = kBrickEdge + 2 * Radius, kPlane = kEdge * kEdge;

  PaintedIndex in;
  BlurWeights weights;
  const std::int64_t* bricks;
  std::uint32_t* varies;        ///< written first
  const std::uint32_t* numbers; ///< of those that vary, before each; null at first
  std::int32_t* slots;
  float* voxels;

  struct Shared {
    float in[kEdge * kPlane], x[kBrickEdge * kPlane], y[kBrickEdge * kBrickEdge * kEdge], z[kVoxelsOfBrick];
  };

  template <class Block>
  VOLCAUSTIC_HD void operator()(Block& block, Shared& s, std::int64_t i) const {
    const std::int64_t b = bricks[i];
    if (numbers && numbers[i] == numbers[i + 1]) return;
    gather(block, s, in.layout.coord(b));
    if (!numbers) {
      const bool differs = block.any(kEdge * kPlane, [&](int v) { return s.in[v] != s.in[0]; });
      bool needs = !in.isConstant(b) && (differs || Radius == 0);
      if (differs && !needs) {
        blur(block, s);
        needs = block.any(kVoxelsOfBrick, [&](int v) { return s.z[v] != s.z[0]; });
      }
      block.forEach(1, [&](int) { varies[i] = needs; });
      return;
    }
    blur(block, s);
    block.forEach(kVoxelsOfBrick, [&](int v) { voxels[std::int64_t{numbers[i]} * kVoxelsOfBrick + v] = s.z[v]; });
    block.forEach(1, [&](int) { slots[b] = static_cast<std::int32_t>(numbers[i]) + 1; });
  }

private:
  template <class Block>
  VOLCAUSTIC_HD void gather(Block& block, Shared& s, const Int3& brick) const {
    const Int3 first{brick.x * kBrickEdge - Radius, brick.y * kBrickEdge - Radius, brick.z * kBrickEdge - Radius};
    block.forEach(kEdge * kPlane, [&](int v) {
      s.in[v] = clampedAt(in, {first.x + v / kPlane, first.y + v / kEdge % kEdge, first.z + v % kEdge});
    });
  }
  /// Along x, then y, then z.
  template <class Block>
  VOLCAUSTIC_HD void blur(Block& block, Shared& s) const {
    block.forEach(kBrickEdge * kPlane,
                  [&](int v) { s.x[v] = blurTap<Radius, kPlane>(&s.in[v + Radius * kPlane], weights.of); });
    block.forEach(kBrickEdge * kBrickEdge * kEdge, [&](int v) {
      const int x = v / (kBrickEdge * kEdge), rest = v % (kBrickEdge * kEdge);
      s.y[v] = blurTap<Radius, kEdge>(&s.x[x * kPlane + rest + Radius * kEdge], weights.of);
    });
    block.forEach(kVoxelsOfBrick, [&](int v) {
      s.z[v] = blurTap<Radius, 1>(&s.y[v / kBrickEdge * kEdge + v % kBrickEdge + Radius], weights.of);
    });
  }
};

} // namespace volcaustic::kernels
