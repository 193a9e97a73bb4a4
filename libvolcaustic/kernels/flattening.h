// From the smoothed index and the painted optics to the arrays of kernels/flat_medium.h: what volume/step_labels,
// volume/index_field and volume/flatten.cpp do, and to the bit what they make. docs/algorithms/cuda.md, "The medium".
#pragma once

#include "kernels/flat_medium.h"
#include "kernels/painting.h"

namespace volcaustic::kernels {

/// When a cube of voxels still counts as constant.
struct StepRules {
  double voxelSize, indexTolerance, indexTolerance2, attenuationTolerance;
};

/// Label of a cube: its level, and kStepCappedBit; kMixedLabel where finer ones are needed.
using CubeLabel = std::uint8_t;
inline constexpr CubeLabel kMixedLabel = 0xff;

/// Least and greatest of n and of the three attenuation channels.
struct CubeRange {
  float low[4], high[4];

  VOLCAUSTIC_HD void add(const CubeRange& r) {
    for (int c = 0; c < 4; ++c) {
      low[c] = smaller(low[c], r.low[c]);
      high[c] = larger(high[c], r.high[c]);
    }
  }
  VOLCAUSTIC_HD CubeLabel label(const StepRules& rules, int level) const {
    for (int c = 1; c < 4; ++c)
      if ((high[c] - low[c]) * rules.voxelSize > rules.attenuationTolerance) return kMixedLabel;
    const float range = high[0] - low[0];
    if (range < rules.indexTolerance) return static_cast<CubeLabel>(level);
    if (range < rules.indexTolerance2) return static_cast<CubeLabel>(level | kStepCappedBit);
    return kMixedLabel;
  }
};

/// The index, and the attenuation where it matters to the labels.
struct LabelledGrids {
  IndexGrid index;
  PaintedAttenuation attenuation;
  bool attenuationMatters;

  VOLCAUSTIC_HD CubeRange ambient() const {
    const Float3 a = attenuationMatters ? attenuation.ambient : Float3(0, 0, 0);
    return {{index.ambient, a.x, a.y, a.z}, {index.ambient, a.x, a.y, a.z}};
  }
};

/// An element a brick: counts of 0 or 1, whether it is in the band, and whether it has a field.
struct MarkBand {
  LabelledGrids grids;
  std::uint32_t *band, *fields;
  VOLCAUSTIC_HD void operator()(std::int64_t b) const {
    band[b] = grids.index.layout.anyAround(b, [&](std::int64_t other) {
      return occupied(grids.index, other) || (grids.attenuationMatters && occupied(grids.attenuation, other));
    });
    fields[b] = !uniformAround(grids.index, b);
  }
};

/// The bricks that a table of sums numbers, in order.
struct ListBricks {
  const std::uint32_t* numbers;
  std::int64_t* bricks;
  VOLCAUSTIC_HD void operator()(std::int64_t b) const {
    if (numbers[b] != numbers[b + 1]) bricks[numbers[b]] = b;
  }
};

inline constexpr int kCellsOfEdge = 4, kCellsOfBrick = kCellsOfEdge * kCellsOfEdge * kCellsOfEdge; // of 2^3 voxels

/// A brick of the band.
struct BandBrick {
  CubeRange range;                ///< of it and one voxel around it
  CubeLabel label;                ///< of the whole
  CubeLabel cells[kCellsOfBrick]; ///< where that is mixed: of level 2 and 1, 0 where neither
};

/// A block a brick of the band: ranges and labels; field and bends where n varies in or beside it.
struct BuildBandBricks {
  LabelledGrids grids;
  StepRules rules;
  const std::int64_t* bricks;
  const std::uint32_t* fieldNumbers; ///< fields before each brick
  BandBrick* out;
  std::int32_t* fieldSlots;
  float* indexOffsets;
  FieldVoxel* fields;  ///< from slot 1 on
  std::uint8_t* bends; ///< 512 for each field, from slot 1 on

  static constexpr int kLow = 3, kEdge = kBrickEdge + kLow + 4, kPlane = kEdge * kEdge, kBlock = kEdge * kPlane;
  static constexpr int kAround = kBrickEdge + 2; ///< voxels along the edge of a brick with one around it
  struct Filtered {
    float v[kFieldEdge * kPlane], s[kFieldEdge * kPlane];
    float vv[kFieldEdge * kFieldEdge * kEdge], vs[kFieldEdge * kFieldEdge * kEdge], sv[kFieldEdge * kFieldEdge * kEdge];
  };
  struct Shared {
    CubeRange cells[kCellsOfBrick], cubes[8]; ///< of 2^3 and 4^3 voxels, with one around them
    float lines[kEdge][2];
    float index[kBlock];
    union {
      Float3 attenuation[kAround * kAround * kAround];
      Filtered filtered;
      std::uint8_t curved[kAround * kAround * kAround];
    };
    VOLCAUSTIC_HD Shared() {}
  };

  template <class Block>
  VOLCAUSTIC_HD void operator()(Block& block, Shared& s, std::int64_t i) const {
    const std::int64_t b = bricks[i];
    const Int3 brick = grids.index.layout.coord(b);
    const bool varies = fieldNumbers[b] != fieldNumbers[b + 1];
    findRanges(block, s, b, brick, varies);
    label(block, s, out[i]);
    const float n = grids.index.isConstant(b) ? grids.index.constant(b) : grids.index.voxel(b, 0);
    const bool keeps = varies && !(out[i].range.high[0] - out[i].range.low[0] < kFlatIndex && flat(block, s));
    const std::int32_t slot = keeps ? static_cast<std::int32_t>(fieldNumbers[b]) + 1 : 0;
    block.forEach(1, [&](int) {
      indexOffsets[b] = n != grids.index.ambient ? n - grids.index.ambient : 0;
      fieldSlots[b] = slot;
    });
    if (slot == 0) return;
    filter(block, s, fields + std::int64_t{slot} * kFieldVoxels);
    findBends(block, s, bends + std::int64_t{slot} * kVoxelsOfBrick);
  }

private:
  /// Of the cells and one voxel around each, as far as the domain goes.
  template <class Block>
  VOLCAUSTIC_HD void findRanges(Block& block, Shared& s, std::int64_t b, const Int3& brick, bool varies) const {
    const BrickLayout& layout = grids.index.layout;
    const Int3 origin{brick.x * kBrickEdge, brick.y * kBrickEdge, brick.z * kBrickEdge};
    const bool attenuates = grids.attenuationMatters && !uniformAround(grids.attenuation, b);
    if (attenuates)
      block.forEach(kAround * kAround * kAround, [&](int v) {
        const Int3 at(v / (kAround * kAround) - 1, v / kAround % kAround - 1, v % kAround - 1);
        s.attenuation[v] = clampedAt(grids.attenuation, origin + at);
      });
    if (varies)
      block.forEach(kBlock, [&](int v) {
        const Int3 at(v / kPlane - kLow, v / kEdge % kEdge - kLow, v % kEdge - kLow);
        s.index[v] = extendedAt(grids.index, origin + at);
      });
    block.forEach(kCellsOfBrick, [&](int cell) {
      const Int3 first((cell >> 4) * 2 - 1, (cell >> 2 & 3) * 2 - 1, (cell & 3) * 2 - 1);
      const Float3 a = grids.attenuationMatters && !attenuates ? grids.attenuation.constant(b) : Float3(0, 0, 0);
      CubeRange r{{0, a.x, a.y, a.z}, {0, a.x, a.y, a.z}};
      if (!varies) r.low[0] = r.high[0] = grids.index.constant(b);
      for (int v = 0; v < 64 && (varies || attenuates); ++v) {
        const Int3 at = layout.clamped(origin + first + Int3(v >> 4, v >> 2 & 3, v & 3)) - origin;
        if (varies) {
          const float n = s.index[((at.x + kLow) * kEdge + at.y + kLow) * kEdge + at.z + kLow];
          r.low[0] = v == 0 ? n : smaller(r.low[0], n);
          r.high[0] = v == 0 ? n : larger(r.high[0], n);
        }
        if (attenuates) {
          const Float3& w = s.attenuation[((at.x + 1) * kAround + at.y + 1) * kAround + at.z + 1];
          for (int c = 0; c < 3; ++c) {
            r.low[c + 1] = v == 0 ? w[c] : smaller(r.low[c + 1], w[c]);
            r.high[c + 1] = v == 0 ? w[c] : larger(r.high[c + 1], w[c]);
          }
        }
      }
      s.cells[cell] = r;
    });
  }

  template <class Block>
  VOLCAUSTIC_HD void label(Block& block, Shared& s, BandBrick& result) const {
    block.forEach(8, [&](int cube) {
      const Int3 first((cube >> 2) * 2, (cube >> 1 & 1) * 2, (cube & 1) * 2);
      CubeRange r = s.cells[cellAt(first)];
      for (int i = 1; i < 8; ++i) r.add(s.cells[cellAt(first + Int3(i >> 2, i >> 1 & 1, i & 1))]);
      s.cubes[cube] = r;
    });
    block.forEach(1, [&](int) {
      CubeRange r = s.cubes[0];
      for (int cube = 1; cube < 8; ++cube) r.add(s.cubes[cube]);
      result.range = r;
      result.label = r.label(rules, 3);
    });
    if (result.label != kMixedLabel) return;
    block.forEach(kCellsOfBrick, [&](int cell) {
      const int cube = (cell >> 5) * 4 + (cell >> 3 & 1) * 2 + (cell >> 1 & 1);
      const CubeLabel four = s.cubes[cube].label(rules, 2);
      const CubeLabel two = four != kMixedLabel ? four : s.cells[cell].label(rules, 1);
      result.cells[cell] = two != kMixedLabel ? two : CubeLabel{0};
    });
  }
  VOLCAUSTIC_HD static int cellAt(const Int3& c) { return (c.x * kCellsOfEdge + c.y) * kCellsOfEdge + c.z; }

  /// Whether n is one value as far as the filter reaches.
  template <class Block>
  VOLCAUSTIC_HD bool flat(Block& block, Shared& s) const {
    float *low = s.filtered.v, *high = s.filtered.s;
    const auto reduce = [](const float* numbers, int stride, int count, float& least, float& most) {
      for (int i = 0; i < count; ++i) {
        least = smaller(least, numbers[i * stride]);
        most = larger(most, numbers[i * stride]);
      }
    };
    // Rows, then lines of rows, then all.
    block.forEach(kPlane, [&](int row) {
      low[row] = high[row] = s.index[row];
      reduce(&s.index[row], kPlane, kEdge, low[row], high[row]);
    });
    block.forEach(kEdge, [&](int line) {
      float least = low[line], most = high[line], ignored = least;
      reduce(low + line, kEdge, kEdge, least, ignored);
      ignored = most;
      reduce(high + line, kEdge, kEdge, ignored, most);
      s.lines[line][0] = least;
      s.lines[line][1] = most;
    });
    float least = s.lines[0][0], most = s.lines[0][1];
    for (int line = 1; line < kEdge; ++line) {
      least = smaller(least, s.lines[line][0]);
      most = larger(most, s.lines[line][1]);
    }
    return most - least < kFlatIndex;
  }

  /// Each letter is what was done along an axis: V value, S slope.
  template <class Block>
  VOLCAUSTIC_HD void filter(Block& block, Shared& s, FieldVoxel* field) const {
    constexpr int kLine = kFieldEdge * kEdge;
    Filtered& f = s.filtered;
    block.forEach(kFieldEdge * kPlane, [&](int v) {
      f.v[v] = valueTap<kPlane>(&s.index[v + kLow * kPlane]);
      f.s[v] = slopeTap<kPlane>(&s.index[v + kLow * kPlane]);
    });
    block.forEach(kFieldEdge * kLine, [&](int v) {
      const int from = v / kLine * kPlane + v % kLine + kLow * kEdge;
      f.vv[v] = valueTap<kEdge>(&f.v[from]);
      f.vs[v] = slopeTap<kEdge>(&f.v[from]);
      f.sv[v] = valueTap<kEdge>(&f.s[from]);
    });
    block.forEach(kFieldVoxels, [&](int v) {
      const int from = v / kFieldEdge * kEdge + v % kFieldEdge + kLow;
      field[v] = {valueTap<1>(&f.vv[from]), valueTap<1>(&f.sv[from]), valueTap<1>(&f.vs[from]),
                  slopeTap<1>(&f.vv[from])};
    });
  }

  /// For each voxel, whether a trilinear lookup inside it can see a gradient.
  template <class Block>
  VOLCAUSTIC_HD void findBends(Block& block, Shared& s, std::uint8_t* bend) const {
    block.forEach(kAround * kAround * kAround, [&](int v) {
      const Int3 at(v / (kAround * kAround), v / kAround % kAround, v % kAround);
      constexpr int kFirst = kLow - 1;
      const float* p = &s.index[((at.x + kFirst) * kEdge + at.y + kFirst) * kEdge + at.z + kFirst];
      s.curved[v] = curvedAt<kPlane, kEdge>(p) ? kStepBendsBit : 0;
    });
    block.forEach(kVoxelsOfBrick, [&](int v) {
      const Int3 at = BrickLayout::voxelOf(v);
      std::uint8_t any = 0;
      for (int i = 0; i < 27; ++i)
        any |= s.curved[((at.x + i / 9) * kAround + at.y + i / 3 % 3) * kAround + at.z + i % 3];
      bend[v] = any;
    });
  }
};

/// A cube of a level above the bricks.
struct CubeState {
  CubeRange range;
  CubeLabel label;
  bool inBand; ///< one of its bricks is; the range is not set otherwise
};

/// The label of what no brick of the band is in.
VOLCAUSTIC_HD inline CubeLabel ambientLabel(const LabelledGrids& grids, const StepRules& rules, int level) {
  const CubeLabel label = grids.ambient().label(rules, level);
  return label != kMixedLabel ? label : CubeLabel{0};
}

/// An element a cube, of twice the edge of those below: bricks of the band for the first level, then cubes.
struct CoarsenCubes {
  LabelledGrids grids;
  StepRules rules;
  int level; ///< of the result
  Int3 fineDims, dims;
  const std::uint32_t* band; ///< numbers of the band's bricks; null where `fine` is the level below
  const BandBrick* bricks;
  const CubeState* fine;
  CubeState* out;

  VOLCAUSTIC_HD void operator()(std::int64_t i) const {
    const Int3 cube = BrickLayout{{}, dims}.coord(i);
    CubeState state{grids.ambient(), 0, false};
    bool outside = false;
    for (int k = 0; k < 8; ++k) {
      const Int3 child(2 * cube.x + (k >> 2), 2 * cube.y + (k >> 1 & 1), 2 * cube.z + (k & 1));
      if (child.x >= fineDims.x || child.y >= fineDims.y || child.z >= fineDims.z) continue;
      const CubeRange* range = rangeOf(BrickLayout{{}, fineDims}.index(child));
      if (!range) {
        outside = true;
      } else if (state.inBand) {
        state.range.add(*range);
      } else {
        state.range = *range;
        state.inBand = true;
      }
    }
    if (state.inBand && outside) state.range.add(grids.ambient());
    state.label = state.inBand ? state.range.label(rules, level) : ambientLabel(grids, rules, level);
    out[i] = state;
  }

private:
  VOLCAUSTIC_HD const CubeRange* rangeOf(std::int64_t child) const {
    if (band) return band[child] != band[child + 1] ? &bricks[band[child]].range : nullptr;
    return fine[child].inBand ? &fine[child].range : nullptr;
  }
};

/// The labels of all levels.
struct LabelPyramid {
  static constexpr int kMostLevels = 10; // bricks, and cubes up to 4096 voxels
  LabelledGrids grids;
  StepRules rules;
  const std::uint32_t* band;
  const BandBrick* bricks;
  const CubeState* levels[kMostLevels]; ///< from 1 on
  Int3 dims[kMostLevels];
  int count;

  /// The label of the largest cube around a brick that has one, or kMixedLabel.
  VOLCAUSTIC_HD CubeLabel ofBrick(const Int3& brick, std::int64_t b) const {
    for (int level = count - 1; level > 0; --level) {
      const Int3 cube(brick.x >> level, brick.y >> level, brick.z >> level);
      if (const CubeLabel label = levels[level][BrickLayout{{}, dims[level]}.index(cube)].label; label != kMixedLabel)
        return label;
    }
    return band[b] != band[b + 1] ? bricks[band[b]].label : ambientLabel(grids, rules, 3);
  }
  /// Of a voxel of a mixed brick; 0 beyond the domain.
  VOLCAUSTIC_HD CubeLabel ofVoxel(const Int3& brick, std::int64_t b, int offset) const {
    const Int3 v = BrickLayout::voxelOf(offset), d = grids.index.layout.dims;
    if (brick.x * kBrickEdge + v.x >= d.x || brick.y * kBrickEdge + v.y >= d.y || brick.z * kBrickEdge + v.z >= d.z)
      return 0;
    return bricks[band[b]].cells[((v.x >> 1) * kCellsOfEdge + (v.y >> 1)) * kCellsOfEdge + (v.z >> 1)];
  }
};

/// An element a brick: its step byte where that is one all over, and how many have it; else a count of 1.
struct ClassifySteps {
  static constexpr std::uint16_t kOwnBytes = 256;
  LabelPyramid labels;
  const std::int32_t *fieldSlots, *opticsSlots;
  std::uint16_t* bytes;     ///< of each brick; kOwnBytes where they differ
  std::uint32_t* frequency; ///< of each of the 256 bytes
  std::uint32_t* own;       ///< counts
  std::uint8_t* bends;

  VOLCAUSTIC_HD void operator()(std::int64_t b) const {
    const Int3 brick = labels.grids.index.layout.coord(b);
    CubeLabel label = kMixedLabel;
    if (opticsSlots[b] <= 0 && fieldSlots[b] == 0) {
      label = labels.ofBrick(brick, b);
      if (label == kMixedLabel) label = commonLabel(brick, b);
    }
    const bool turns = label != kMixedLabel && opticsSlots[b] != 0;
    bends[b] = turns;
    own[b] = label == kMixedLabel;
    bytes[b] = kOwnBytes;
    if (label == kMixedLabel) return;
    bytes[b] = static_cast<std::uint16_t>(label | (turns ? kStepBendsBit : 0));
    addShared(frequency + bytes[b], 1);
  }

private:
  VOLCAUSTIC_HD CubeLabel commonLabel(const Int3& brick, std::int64_t b) const {
    const CubeLabel first = labels.ofVoxel(brick, b, 0);
    for (int v = 1; v < kVoxelsOfBrick; ++v)
      if (labels.ofVoxel(brick, b, v) != first) return kMixedLabel;
    return first;
  }
};

/// An element a brick.
struct PlaceSteps {
  const std::uint16_t* bytes;
  const std::uint32_t* own; ///< summed up
  std::int32_t ambient;     ///< the most frequent byte
  std::int32_t* slots;
  std::int64_t* bricks; ///< with bytes of their own
  VOLCAUSTIC_HD void operator()(std::int64_t b) const {
    slots[b] = bytes[b] != ambient ? ~std::int32_t{bytes[b]} : 0;
    if (own[b] == own[b + 1]) return;
    slots[b] = static_cast<std::int32_t>(own[b]) + 1;
    bricks[own[b]] = b;
  }
};

/// A block a brick with step bytes of its own.
struct FillSteps {
  LabelPyramid labels;
  const std::int32_t *fieldSlots, *opticsSlots, *voxelOptics;
  const std::uint8_t* fieldBends;
  const std::int64_t* bricks;
  std::uint8_t* steps; ///< from slot 1 on
  std::uint8_t* bends;

  struct Shared {};
  template <class Block>
  VOLCAUSTIC_HD void operator()(Block& block, Shared&, std::int64_t i) const {
    const std::int64_t b = bricks[i];
    const Int3 brick = labels.grids.index.layout.coord(b);
    const CubeLabel whole = labels.ofBrick(brick, b);
    std::uint8_t* out = steps + (i + 1) * kStepVoxels;
    block.forEach(kStepVoxels, [&](int v) {
      const CubeLabel label = whole != kMixedLabel ? whole : labels.ofVoxel(brick, b, v);
      out[v] = static_cast<std::uint8_t>(label | turns(b, v));
    });
    const bool any = block.any(kStepVoxels, [&](int v) { return (out[v] & kStepBendsBit) != 0; });
    block.forEach(1, [&](int) { bends[b] = any; });
  }

private:
  VOLCAUSTIC_HD std::uint8_t turns(std::int64_t b, int v) const {
    const std::int32_t field = fieldSlots[b], optics = opticsSlots[b];
    if (optics < 0 || (optics > 0 && voxelOptics[std::int64_t{optics} * kStepVoxels + v] != 0)) return kStepBendsBit;
    return field > 0 ? fieldBends[std::int64_t{field} * kVoxelsOfBrick + v] : std::uint8_t{0};
  }
};

} // namespace volcaustic::kernels
