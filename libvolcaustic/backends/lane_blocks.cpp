// Work in lanes on blocks and bricks: far chords, direct light, the Gaussian (docs/algorithms/photons.md, "Lanes").
// Compiled once for each instruction set of lanes.h.

#include "backends/highway_lanes.h"
#include "backends/lanes.h"
#include "kernels/slab.h"

namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET {

namespace {

using kernels::Vec3;

/// Up to a register of far chords, number by number.
struct FarLanes {
  Vec3<Float> start, direction;
  Float length;

  FarLanes(const FarChord* chords, const std::uint32_t* ids, std::int64_t count) {
    alignas(64) float v[7][kLanes];
    for (std::int64_t k = 0; k < kLanes; ++k) {
      const FarChord& c = chords[ids[k < count ? k : 0]];
      for (int i = 0; i < 3; ++i) v[i][k] = c.start[i], v[3 + i][k] = c.direction[i];
      v[6][k] = c.length;
    }
    start = load3(v[0], v[1], v[2]);
    direction = load3(v[3], v[4], v[5]);
    length = load(v[6]);
  }
};

/// Where chords are inside the cube [0, kSumsEdge]: distances along them; `to` <= `from` when they are not.
void clipToBlock(const Vec3<Float>& start, const Vec3<Float>& direction, Float length, Float& from, Float& to) {
  from = Float(0);
  to = length;
  const auto axis = [&](Float s, Float d) {
    // A chord along the other axes stays in the voxel that it starts in; in a face, that is the one behind the face.
    const Mask moves = absOf(d) > Float(1e-9f), inside = both(negate(s < Float(0)), s < Float(kSumsEdge));
    const Float inverse = reciprocal(select(moves, d, Float(1)));
    const Float low = -s * inverse, high = (Float(kSumsEdge) - s) * inverse;
    from = select(moves, larger(from, smaller(low, high)), from);
    to = select(moves, smaller(to, larger(low, high)), select(inside, to, Float(0)));
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
    const kernels::SlabChord<Float, kernels::DenseCells> slabs({{kSumsEdge, kSumsEdge, kSumsEdge}}, all(start),
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
  }

private:
  void deposit(const FarChord& chord, int crossings) {
    const bool decays = chord.slope[0] != 0 || chord.slope[1] != 0 || chord.slope[2] != 0;
    const hn::FixedTag<float, 8> eight;
    const hn::FixedTag<std::int32_t, 8> integers;
    const auto rate = rateOf(chord.power, chord.direction), slope = rateOf(chord.slope, chord.direction);
    const auto add = [&](int i, auto value) {
      std::int32_t* at = mSums + mAt[i];
      hn::Store(hn::Add(hn::Load(integers, at), roundedProduct(value, hn::Set(eight, mLength[i]))), integers, at);
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
  std::int32_t mAt[3 * kSumsEdge + 4 * kLanes];
  float mLength[3 * kSumsEdge + 4 * kLanes], mMiddle[3 * kSumsEdge + 4 * kLanes];
};

} // namespace

void rasterise(const FarChord* chords, const std::uint32_t* ids, std::int64_t count, const kernels::Int3& corner,
               float scale, BlockSums& sums) {
  constexpr std::int64_t kBetweenCarries = 4096; // deposits of 2^17 at most: half of 32 bits
  BlockRasteriser rasteriser(scale, sums);
  alignas(64) float from[kLanes], to[kLanes], x[kLanes], y[kLanes], z[kLanes];
  for (std::int64_t i = 0; i < count; i += kLanes) {
    if (i > 0 && i % kBetweenCarries == 0) sums.carry();
    FarLanes c(chords, ids + i, count - i);
    c.start = c.start - Vec3<Float>(Float(corner.x - 1), Float(corner.y - 1), Float(corner.z - 1));
    Float in, out;
    clipToBlock(c.start, c.direction, c.length, in, out);
    const Vec3<Float> entry = kernels::mulAdd(c.direction, in, c.start);
    store(in, from), store(out, to), store(entry.x, x), store(entry.y, y), store(entry.z, z);
    for (std::int64_t k = 0; k < kLanes && i + k < count; ++k)
      if (to[k] > from[k]) rasteriser.add(chords[ids[i + k]], {x[k], y[k], z[k]}, from[k], to[k]);
  }
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

void lightAround(const kernels::Lamp& lamp, const kernels::Int3& low, const kernels::Int3& dims, const float* parts,
                 float* sums) {
  constexpr int kEdge = 10, kVoxels = kEdge * kEdge * kEdge;
  for (std::int32_t k = 0; k < kVoxels; k += kLanes) {
    const Int i = Int(hn::Iota(IntTag(), k));
    const Int x = toInt((toFloat(i) + Float(0.5f)) * Float(1.0f / (kEdge * kEdge)));
    const Int rest = i - x * Int(kEdge * kEdge);
    const Int y = toInt((toFloat(rest) + Float(0.5f)) * Float(1.0f / kEdge)), z = rest - y * Int(kEdge);
    const auto centre = [](Int c, std::int32_t first, std::int32_t dim) {
      return toFloat(kernels::clampTo(c + Int(first), Int(0), Int(dim - 1))) + Float(0.5f);
    };
    const kernels::LampLight<Float> light =
        kernels::lampLight<Float>(lamp, {centre(x, low.x, dims.x), centre(y, low.y, dims.y), centre(z, low.z, dims.z)});
    const Vec3<Float> fluence = light.fluence * load(parts + k);
    const Vec3<Float> towards = light.direction * kernels::luminance(fluence);
    const hn::FixedTag<float, 4> four;
    alignas(64) float voxels[2][4 * kLanes];
    const auto zero = hn::Zero(FloatTag());
    hn::StoreInterleaved4(fluence.x.v, fluence.y.v, fluence.z.v, zero, FloatTag(), voxels[0]);
    hn::StoreInterleaved4(towards.x.v, towards.y.v, towards.z.v, zero, FloatTag(), voxels[1]);
    for (int v = 0; v < kLanes && k + v < kVoxels; ++v)
      for (int half = 0; half < 2; ++half) {
        float* to = sums + std::ptrdiff_t{8} * (k + v) + 4 * half;
        hn::StoreU(hn::Add(hn::LoadU(four, to), hn::Load(four, voxels[half] + 4 * v)), four, to);
      }
  }
}

namespace {

/// Packs the 8x8 numbers of eight voxels (kernels::LightSums) as kernels::pack does; returns whether there is any
/// light.
bool packVoxels(const float* v, kernels::FluenceVoxel* out) {
  using kernels::kFluenceMantissa, kernels::kTowardsMantissa;
  const FloatTag d;
  const IntTag i;
  // A register holds R, x, R, x and so on, the next G, y, the third B, z: of colour in even lanes, of direction in odd.
  const auto even = hn::RebindMask(i, hn::Eq(hn::And(hn::Iota(i, 0), hn::Set(i, 1)), hn::Zero(i)));
  const auto factors = hn::IfThenElse(hn::RebindMask(d, even), hn::Set(d, 1.0f), hn::Set(d, 0.5f));
  const auto low = hn::IfThenElse(even, hn::Zero(i), hn::Set(i, -kTowardsMantissa));
  const auto high = hn::IfThenElse(even, hn::Set(i, kFluenceMantissa), hn::Set(i, kTowardsMantissa));
  auto any = hn::Zero(i);
  for (int k = 0; k < 64; k += 4 * kLanes) {
    hn::Vec<FloatTag> rx, gy, bz, unused;
    hn::LoadInterleaved4(d, v + k, rx, gy, bz, unused);
    const auto strongest = hn::DupEven(hn::Max(rx, hn::Max(gy, bz)));
    const auto exponent = hn::Sub(hn::ShiftRight<23>(hn::BitCast(i, strongest)), hn::Set(i, kernels::kFluenceExponent));
    const auto lit = hn::Gt(exponent, hn::Zero(i));
    const auto scale = hn::BitCast(d, hn::ShiftLeft<23>(hn::Sub(hn::Set(i, 254), exponent)));
    const auto bits = [&](auto value) __attribute__((always_inline)) {
      const auto rounded = hn::NearestInt(hn::Mul(value, hn::Mul(scale, factors)));
      return hn::And(hn::Min(hn::Max(rounded, low), high), hn::Set(i, kFluenceMantissa));
    };
    const auto a = bits(rx), b = bits(gy), c = bits(bz);
    const auto part = hn::IfThenElse(even, exponent, hn::ShiftRight<4>(exponent));
    const auto first = hn::IfThenElseZero(lit, hn::Or(a, hn::ShiftLeft<20>(b)));
    const auto second =
        hn::IfThenElseZero(lit, hn::Or(hn::Or(hn::ShiftRight<12>(b), hn::ShiftLeft<8>(c)), hn::ShiftLeft<28>(part)));
    hn::StoreInterleaved2(first, second, i, reinterpret_cast<std::int32_t*>(out) + k / 2);
    any = hn::Or(any, hn::Or(first, second));
  }
  return !hn::AllTrue(i, hn::Eq(any, hn::Zero(i)));
}

} // namespace

std::uint64_t finishBlock(const kernels::LightSums<std::int32_t>& sums, kernels::FluenceVoxel* const* bricks) {
  return kernels::finishBricks<kBlockEdge>(sums, bricks, packVoxels);
}

void finishBrick(const kernels::LightSums<float>& sums, kernels::FluenceVoxel* out) {
  kernels::finishBricks<8>(sums, &out, packVoxels);
}

} // namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET
