// Work in lanes on blocks and bricks: far chords, direct light, smoothing (docs/algorithms/photons.md, "Lanes").
// Compiled once for each instruction set of lanes.h.

#include "backends/highway_lanes.h"
#include "backends/lanes.h"
#include "kernels/slab.h"
#include "kernels/smooth.h"

namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET {

namespace {

using kernels::Vec3;

/// Up to a register of far chords, number by number.
struct FarLanes {
  Vec3<Float> start, direction;
  Float length;

  FarLanes(const FarChord* chords, const std::uint32_t* ids, std::int64_t count) {
    alignas(64) float v[7][kLanes] = {};
    for (std::int64_t k = 0; k < kLanes; ++k) {
      const FarChord& c = chords[ids ? ids[k < count ? k : 0] : (k < count ? k : 0)];
      for (int i = 0; i < 3; ++i) v[i][k] = c.start[i], v[3 + i][k] = c.direction[i];
      v[6][k] = c.length;
    }
    start = load3(v[0], v[1], v[2]);
    direction = load3(v[3], v[4], v[5]);
    length = load(v[6]);
  }
};

/// Where chords are inside the box [0, edge]: distances along them; `to` <= `from` when they are not.
void clipToBlock(const Vec3<Float>& start, const Vec3<Float>& direction, Float length, Float& from, Float& to) {
  from = Float(0);
  to = length;
  // A chord that stays in a face belongs to the block that it was found in.
  const auto axis = [&](Float s, Float d) {
    const Mask moves = absOf(d) > Float(1e-12f);
    const Float inverse = reciprocal(select(moves, d, Float(1)));
    const Float low = -s * inverse, high = (Float(kBlockEdge) - s) * inverse;
    from = select(moves, larger(from, smaller(low, high)), from);
    to = select(moves, smaller(to, larger(low, high)), to);
  };
  axis(start.x, direction.x);
  axis(start.y, direction.y);
  axis(start.z, direction.z);
}

/// Adds one chord's crossings inside a block.
class BlockRasteriser {
public:
  BlockRasteriser(float scale, BlockSums& sums) : mScale(scale), mSums(sums.low()) {}

  /// The part of the chord from `from` to `to`; `start` is where it begins, in the block.
  void add(const FarChord& chord, const float (&start)[3], float from, float to) {
    const auto all = [](const float(&v)[3]) { return Vec3<Float>(Float(v[0]), Float(v[1]), Float(v[2])); };
    const kernels::SlabChord<Float, kernels::DenseCells> slabs({{kBlockEdge, kBlockEdge, kBlockEdge}}, all(start),
                                                               all(chord.direction), Float(to - from));
    const Float shift(from - 0.5f * chord.length);
    const int count = hn::GetLane(slabs.slabs().v);
    int crossings = 0;
    for (int k = 0; k < count; k += kLanes) {
      const auto c = slabs.crossing(Int(hn::Iota(IntTag(), k)));
      const Mask on = firstLanes(count - k);
      for (const auto& cell : {c.first, c.second, c.third}) {
        const Squeeze squeeze(both(on, cell.length > Float(0)));
        store(squeeze(cell.at << 3), mAt + crossings);
        store(squeeze(cell.length), mLength + crossings);
        store(squeeze(cell.middle + shift), mMiddle + crossings);
        crossings += squeeze.count();
      }
    }
    deposit(chord, crossings);
    mCrossed += crossings;
  }

  [[nodiscard]] std::int64_t crossed() const { return mCrossed; }

private:
  void deposit(const FarChord& chord, int crossings) {
    const bool decays = chord.slope[0] != 0 || chord.slope[1] != 0 || chord.slope[2] != 0;
    const hn::FixedTag<float, 8> eight;
    const hn::FixedTag<std::int32_t, 8> integers;
    const auto rate = rateOf(chord.power, chord.direction), slope = rateOf(chord.slope, chord.direction);
    const auto add = [&](int i, auto value) {
      std::int32_t* at = mSums + mAt[i];
      const auto added = hn::NearestInt(hn::Mul(value, hn::Set(eight, mLength[i])));
      hn::Store(hn::Add(hn::Load(integers, at), added), integers, at);
    };
    if (decays)
      for (int i = 0; i < crossings; ++i) add(i, hn::MulAdd(slope, hn::Set(eight, mMiddle[i]), rate));
    else
      for (int i = 0; i < crossings; ++i) add(i, rate);
  }

  /// What a voxel is given for each unit of length: power RGB, 0, luminance-weighted direction, 0. Put together in
  /// registers; both arrays are followed by a number that belongs to the chord too.
  [[nodiscard]] hn::Vec<hn::FixedTag<float, 8>> rateOf(const float* power, const float* direction) const {
    const hn::FixedTag<float, 4> four;
    const auto three = hn::FirstN(four, 3);
    const float l = kernels::luminance(kernels::Float3(power[0], power[1], power[2])) * mScale;
    return hn::Combine(hn::FixedTag<float, 8>(),
                       hn::IfThenElseZero(three, hn::Mul(hn::LoadU(four, direction), hn::Set(four, l))),
                       hn::IfThenElseZero(three, hn::Mul(hn::LoadU(four, power), hn::Set(four, mScale))));
  }

  float mScale;
  std::int32_t* mSums;
  std::int64_t mCrossed = 0;
  std::int32_t mAt[3 * kBlockEdge + 4 * kLanes];
  float mLength[3 * kBlockEdge + 4 * kLanes], mMiddle[3 * kBlockEdge + 4 * kLanes];
};

} // namespace

std::int64_t findBlocks(const FarChord* chords, std::int64_t count, const kernels::Int3& blockDims,
                        BlockCrossing* crossings) {
  std::int64_t found = 0;
  alignas(64) std::int32_t blocks[3 * kLanes + kLanes], numbers[3 * kLanes + kLanes];
  for (std::int64_t i = 0; i < count; i += kLanes) {
    const FarLanes c(chords + i, nullptr, count - i);
    constexpr float kScale = 1.0f / kBlockEdge;
    const kernels::SlabChord<Float, kernels::DenseCells> slabs({blockDims}, c.start * Float(kScale), c.direction,
                                                               c.length * Float(kScale));
    const Mask on = firstLanes(static_cast<int>(count - i < kLanes ? count - i : kLanes));
    const Int number = Int(hn::Iota(IntTag(), static_cast<std::int32_t>(i)));
    for (Int k(0);; k = k + Int(1)) {
      const Mask reaching = both(on, k < slabs.slabs());
      if (!any(reaching)) break;
      const auto crossing = slabs.crossing(k);
      int n = 0;
      for (const auto& cell : {crossing.first, crossing.second, crossing.third}) {
        const Squeeze squeeze(both(reaching, cell.length > Float(0)));
        store(squeeze(number), numbers + n);
        store(squeeze(cell.at), blocks + n);
        n += squeeze.count();
      }
      for (int j = 0; j < n; ++j) crossings[found++] = {blocks[j], numbers[j]};
    }
  }
  return found;
}

std::int64_t rasterise(const FarChord* chords, const std::uint32_t* ids, std::int64_t count,
                       const kernels::Int3& corner, float scale, BlockSums& sums) {
  constexpr std::int64_t kBetweenCarries = 4096; // deposits of 2^17 at most: half of 32 bits
  BlockRasteriser rasteriser(scale, sums);
  alignas(64) float from[kLanes], to[kLanes], x[kLanes], y[kLanes], z[kLanes];
  for (std::int64_t i = 0; i < count; i += kLanes) {
    if (i > 0 && i % kBetweenCarries == 0) sums.carry();
    FarLanes c(chords, ids + i, count - i);
    c.start = c.start - Vec3<Float>(Float(corner.x), Float(corner.y), Float(corner.z));
    Float in, out;
    clipToBlock(c.start, c.direction, c.length, in, out);
    const Vec3<Float> entry = kernels::mulAdd(c.direction, in, c.start);
    store(in, from), store(out, to), store(entry.x, x), store(entry.y, y), store(entry.z, z);
    for (std::int64_t k = 0; k < kLanes && i + k < count; ++k)
      if (to[k] > from[k]) rasteriser.add(chords[ids[i + k]], {x[k], y[k], z[k]}, from[k], to[k]);
  }
  return rasteriser.crossed();
}

kernels::LitLengths<float> litLengths(const kernels::LitView& view, const float* entry) {
  Float all(0), lit(0);
  const Int last(view.cells - 1);
  for (std::int32_t i = 0; i < view.cells; i += kLanes) {
    const Int number = Int(hn::Iota(IntTag(), i));
    const kernels::LitLengths<Float> some = kernels::litLengths<Float>(view, entry, smaller(number, last));
    const Mask on = number < Int(view.cells);
    all = all + select(on, some.all, Float(0));
    lit = lit + select(on, some.lit, Float(0));
  }
  return {hn::GetLane(hn::SumOfLanes(FloatTag(), all.v)), hn::GetLane(hn::SumOfLanes(FloatTag(), lit.v))};
}

void lightBrick(const kernels::LampView& lamp, float* fluence, float* direction) {
  const FloatTag d;
  const auto add = [&](const Vec3<Float>& v, float* to) {
    Float x, y, z;
    hn::LoadInterleaved3(d, to, x.v, y.v, z.v);
    hn::StoreInterleaved3((x + v.x).v, (y + v.y).v, (z + v.z).v, d, to);
  };
  for (std::int32_t k = 0; k < kernels::kStepVoxels; k += kLanes) {
    const kernels::LampLight<Float> light = kernels::lampLight<Float>(lamp, Int(hn::Iota(IntTag(), k)));
    add(light.fluence, fluence + std::ptrdiff_t{3} * k);
    add(light.direction * kernels::luminance(light.fluence), direction + std::ptrdiff_t{3} * k);
  }
}

void smoothBrick(const float* in, float* out) { kernels::smoothBrick(in, out); }

} // namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET
