// Lanes over Google Highway: as many floats as the instruction set that this file is compiled for holds in a register.
// Included only by sources that are compiled once for each instruction set, with VOLCAUSTIC_INSTRUCTION_SET defined.
#pragma once

#include "kernels/fluence.h"

#define HWY_COMPILE_ONLY_STATIC
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET {

namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::ScalableTag<float>;
using IntTag = hn::ScalableTag<std::int32_t>;
inline constexpr int kLanes = static_cast<int>(HWY_LANES(float));

struct Mask {
  hn::Mask<FloatTag> m;
};
/// The same lanes seen by integers.
VOLCAUSTIC_HD inline hn::Mask<IntTag> integers(const Mask& a) { return hn::RebindMask(IntTag(), a.m); }

struct Float {
  hn::Vec<FloatTag> v;

  Float() = default;
  VOLCAUSTIC_HD explicit Float(hn::Vec<FloatTag> v_) : v(v_) {}
  template <class Number>
  requires std::is_arithmetic_v<Number> VOLCAUSTIC_HD explicit Float(Number s)
      : v(hn::Set(FloatTag(), static_cast<float>(s))) {}
  VOLCAUSTIC_HD Float operator-() const { return Float(hn::Neg(v)); }
  VOLCAUSTIC_HD friend Float operator+(Float a, Float b) { return Float(hn::Add(a.v, b.v)); }
  VOLCAUSTIC_HD friend Float operator-(Float a, Float b) { return Float(hn::Sub(a.v, b.v)); }
  VOLCAUSTIC_HD friend Float operator*(Float a, Float b) { return Float(hn::Mul(a.v, b.v)); }
  VOLCAUSTIC_HD friend Mask operator<(Float a, Float b) { return {hn::Lt(a.v, b.v)}; }
  VOLCAUSTIC_HD friend Mask operator>(Float a, Float b) { return {hn::Gt(a.v, b.v)}; }
  VOLCAUSTIC_HD friend Mask operator<=(Float a, Float b) { return {hn::Le(a.v, b.v)}; }
  VOLCAUSTIC_HD friend Mask operator>=(Float a, Float b) { return {hn::Ge(a.v, b.v)}; }
  VOLCAUSTIC_HD friend Mask operator==(Float a, Float b) { return {hn::Eq(a.v, b.v)}; }
};

struct Int {
  hn::Vec<IntTag> v;

  Int() = default;
  VOLCAUSTIC_HD explicit Int(hn::Vec<IntTag> v_) : v(v_) {}
  VOLCAUSTIC_HD explicit Int(std::int32_t s) : v(hn::Set(IntTag(), s)) {}
  VOLCAUSTIC_HD Int operator-() const { return Int(hn::Neg(v)); }
  VOLCAUSTIC_HD Int operator~() const { return Int(hn::Not(v)); }
  VOLCAUSTIC_HD friend Int operator+(Int a, Int b) { return Int(hn::Add(a.v, b.v)); }
  VOLCAUSTIC_HD friend Int operator-(Int a, Int b) { return Int(hn::Sub(a.v, b.v)); }
  VOLCAUSTIC_HD friend Int operator*(Int a, Int b) { return Int(hn::Mul(a.v, b.v)); }
  VOLCAUSTIC_HD friend Int operator&(Int a, Int b) { return Int(hn::And(a.v, b.v)); }
  VOLCAUSTIC_HD friend Int operator|(Int a, Int b) { return Int(hn::Or(a.v, b.v)); }
  VOLCAUSTIC_HD friend Int operator<<(Int a, int bits) { return Int(hn::ShiftLeftSame(a.v, bits)); }
  VOLCAUSTIC_HD friend Int operator>>(Int a, int bits) { return Int(hn::ShiftRightSame(a.v, bits)); }
  VOLCAUSTIC_HD friend Mask operator<(Int a, Int b) { return {hn::RebindMask(FloatTag(), hn::Lt(a.v, b.v))}; }
  VOLCAUSTIC_HD friend Mask operator>(Int a, Int b) { return {hn::RebindMask(FloatTag(), hn::Gt(a.v, b.v))}; }
  VOLCAUSTIC_HD friend Mask operator==(Int a, Int b) { return {hn::RebindMask(FloatTag(), hn::Eq(a.v, b.v))}; }
  VOLCAUSTIC_HD friend Mask operator!=(Int a, Int b) { return {hn::RebindMask(FloatTag(), hn::Ne(a.v, b.v))}; }
};

VOLCAUSTIC_HD inline Float select(const Mask& m, Float a, Float b) { return Float(hn::IfThenElse(m.m, a.v, b.v)); }
VOLCAUSTIC_HD inline Int select(const Mask& m, Int a, Int b) { return Int(hn::IfThenElse(integers(m), a.v, b.v)); }
VOLCAUSTIC_HD inline bool any(const Mask& m) { return !hn::AllFalse(FloatTag(), m.m); }
VOLCAUSTIC_HD inline Mask both(const Mask& a, const Mask& b) { return {hn::And(a.m, b.m)}; }
VOLCAUSTIC_HD inline Mask either(const Mask& a, const Mask& b) { return {hn::Or(a.m, b.m)}; }
VOLCAUSTIC_HD inline Mask negate(const Mask& a) { return {hn::Not(a.m)}; }

VOLCAUSTIC_HD inline Float smaller(Float a, Float b) { return Float(hn::Min(a.v, b.v)); }
VOLCAUSTIC_HD inline Float larger(Float a, Float b) { return Float(hn::Max(a.v, b.v)); }
VOLCAUSTIC_HD inline Int smaller(Int a, Int b) { return Int(hn::Min(a.v, b.v)); }
VOLCAUSTIC_HD inline Int larger(Int a, Int b) { return Int(hn::Max(a.v, b.v)); }
VOLCAUSTIC_HD inline Float absOf(Float a) { return Float(hn::Abs(a.v)); }
VOLCAUSTIC_HD inline Float mulAdd(Float a, Float b, Float c) { return Float(hn::MulAdd(a.v, b.v, c.v)); }
VOLCAUSTIC_HD inline Float exponential(Float a) { return Float(hn::Exp(FloatTag(), a.v)); }
VOLCAUSTIC_HD inline Float quotient(Float a, Float b) { return Float(hn::Div(a.v, b.v)); }
VOLCAUSTIC_HD inline Float squareRoot(Float a) { return Float(hn::Sqrt(a.v)); }
VOLCAUSTIC_HD inline Float arctangent(Float a) { return Float(hn::Atan(FloatTag(), a.v)); }
/// The processor's own conversion: all lanes are within 32 bits, or clamped afterwards to what any number is good for.
/// The library's guards against numbers beyond them, which costs four operations more.
VOLCAUSTIC_HD inline Int toInt(Float a) {
#if HWY_TARGET == HWY_AVX2
  return Int(hn::Vec<IntTag>{_mm256_cvttps_epi32(a.v.raw)});
#else
  return Int(hn::Vec<IntTag>{_mm512_cvttps_epi32(a.v.raw)});
#endif
}
VOLCAUSTIC_HD inline Float toFloat(Int a) { return Float(hn::ConvertTo(FloatTag(), a.v)); }
VOLCAUSTIC_HD inline Int powerOfTwo(Int a) { return Int(hn::Shl(hn::Set(IntTag(), 1), a.v)); }

/// The estimate of the instruction set, good to 12 or 14 bits, and one step of Newton. Zero gives infinity times zero;
/// callers select around it.
VOLCAUSTIC_HD inline Float reciprocal(Float a) {
  const auto r = hn::ApproximateReciprocal(a.v);
  return Float(hn::MulAdd(r, hn::NegMulAdd(a.v, r, hn::Set(FloatTag(), 1.0f)), r));
}
VOLCAUSTIC_HD inline Float inverseRoot(Float a) {
  const auto r = hn::ApproximateReciprocalSqrt(a.v);
  const auto half = hn::Mul(hn::Set(FloatTag(), 0.5f), r);
  return Float(hn::MulAdd(half, hn::NegMulAdd(hn::Mul(a.v, r), r, hn::Set(FloatTag(), 1.0f)), r));
}

VOLCAUSTIC_HD inline Int gather(const std::int32_t* base, Int index) {
  return Int(hn::GatherIndex(IntTag(), base, index.v));
}
VOLCAUSTIC_HD inline Float gather(const float* base, Int index) {
  return Float(hn::GatherIndex(FloatTag(), base, index.v));
}
VOLCAUSTIC_HD inline Int gatherByte(const std::uint8_t* bytes, Int index) {
  const auto four = hn::GatherOffset(IntTag(), reinterpret_cast<const std::int32_t*>(bytes), index.v);
  return Int(hn::And(four, hn::Set(IntTag(), 0xff)));
}
VOLCAUSTIC_HD inline Int lookUp(const std::int32_t (&table)[kernels::kLookUpSize], Int index) {
  const auto at = hn::IndicesFromVec(IntTag(), hn::And(index.v, hn::Set(IntTag(), kLanes - 1)));
  const auto low = hn::TableLookupLanes(hn::LoadU(IntTag(), table), at);
#if HWY_TARGET == HWY_AVX2
  const auto high = hn::TableLookupLanes(hn::LoadU(IntTag(), table + kLanes), at);
  return select(index < Int(kLanes), Int(low), Int(high));
#else
  return Int(low);
#endif
}

VOLCAUSTIC_HD inline std::uint64_t highBits(Float, const std::uint8_t* bytes) {
  const hn::ScalableTag<std::int8_t> d;
  std::uint8_t bits[8];
  for (std::size_t i = 0; i < 64; i += hn::Lanes(d))
    hn::StoreMaskBits(d, hn::Lt(hn::LoadU(d, reinterpret_cast<const std::int8_t*>(bytes + i)), hn::Zero(d)),
                      bits + i / 8);
  std::uint64_t all;
  __builtin_memcpy(&all, bits, sizeof all);
  return all;
}

using Four = hn::Vec<hn::FixedTag<float, 4>>;

VOLCAUSTIC_HD inline Float floatOfBits(Int a) { return Float(hn::BitCast(FloatTag(), a.v)); }
VOLCAUSTIC_HD inline std::int32_t oneOf(const Mask& m, Int v) {
  return hn::GetLane(hn::MaxOfLanes(IntTag(), hn::IfThenElse(integers(m), v.v, hn::Set(IntTag(), INT32_MIN))));
}
VOLCAUSTIC_HD inline int count(const Mask& m) { return static_cast<int>(hn::CountTrue(FloatTag(), m.m)); }

/// As many doubles, in two registers.
struct Double {
  using Tag = hn::ScalableTag<double>;
  hn::Vec<Tag> low, high;

  Double() = default;
  VOLCAUSTIC_HD Double(hn::Vec<Tag> low_, hn::Vec<Tag> high_) : low(low_), high(high_) {}
  VOLCAUSTIC_HD explicit Double(double s) : low(hn::Set(Tag(), s)), high(low) {}
  VOLCAUSTIC_HD friend Double operator+(Double a, Double b) { return {hn::Add(a.low, b.low), hn::Add(a.high, b.high)}; }
  VOLCAUSTIC_HD friend Double operator-(Double a, Double b) { return {hn::Sub(a.low, b.low), hn::Sub(a.high, b.high)}; }
  VOLCAUSTIC_HD friend Double operator*(Double a, Double b) { return {hn::Mul(a.low, b.low), hn::Mul(a.high, b.high)}; }
};

/// One register of doubles, half as many as there are floats in one.
struct RealMask {
  hn::Mask<Double::Tag> m;
};
struct Real {
  using Tag = Double::Tag;
  hn::Vec<Tag> v;

  Real() = default;
  VOLCAUSTIC_HD explicit Real(hn::Vec<Tag> v_) : v(v_) {}
  VOLCAUSTIC_HD explicit Real(double s) : v(hn::Set(Tag(), s)) {}
  VOLCAUSTIC_HD friend Real operator+(Real a, Real b) { return Real(hn::Add(a.v, b.v)); }
  VOLCAUSTIC_HD friend Real operator-(Real a, Real b) { return Real(hn::Sub(a.v, b.v)); }
  VOLCAUSTIC_HD friend Real operator*(Real a, Real b) { return Real(hn::Mul(a.v, b.v)); }
  VOLCAUSTIC_HD friend Real operator/(Real a, Real b) { return Real(hn::Div(a.v, b.v)); }
  VOLCAUSTIC_HD friend RealMask operator<(Real a, Real b) { return {hn::Lt(a.v, b.v)}; }
  VOLCAUSTIC_HD friend RealMask operator>(Real a, Real b) { return {hn::Gt(a.v, b.v)}; }
  VOLCAUSTIC_HD friend RealMask operator<=(Real a, Real b) { return {hn::Le(a.v, b.v)}; }
  VOLCAUSTIC_HD friend RealMask operator>=(Real a, Real b) { return {hn::Ge(a.v, b.v)}; }
  VOLCAUSTIC_HD friend RealMask operator==(Real a, Real b) { return {hn::Eq(a.v, b.v)}; }
};
inline constexpr int kRealLanes = static_cast<int>(HWY_LANES(double));

} // namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET

namespace volcaustic::kernels {
template <>
struct LaneTraits<VOLCAUSTIC_INSTRUCTION_SET::Real> {
  using Mask = VOLCAUSTIC_INSTRUCTION_SET::RealMask;
  using Double = VOLCAUSTIC_INSTRUCTION_SET::Real;
};
template <>
struct LaneTraits<VOLCAUSTIC_INSTRUCTION_SET::Float> {
  using Int = VOLCAUSTIC_INSTRUCTION_SET::Int;
  using Mask = VOLCAUSTIC_INSTRUCTION_SET::Mask;
  using Double = VOLCAUSTIC_INSTRUCTION_SET::Double;
};
} // namespace volcaustic::kernels

namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET {

VOLCAUSTIC_HD inline Real select(const RealMask& m, Real a, Real b) { return Real(hn::IfThenElse(m.m, a.v, b.v)); }
VOLCAUSTIC_HD inline bool any(const RealMask& m) { return !hn::AllFalse(Real::Tag(), m.m); }
VOLCAUSTIC_HD inline RealMask both(const RealMask& a, const RealMask& b) { return {hn::And(a.m, b.m)}; }
VOLCAUSTIC_HD inline RealMask either(const RealMask& a, const RealMask& b) { return {hn::Or(a.m, b.m)}; }
VOLCAUSTIC_HD inline Real smaller(Real a, Real b) { return Real(hn::Min(a.v, b.v)); }
VOLCAUSTIC_HD inline Real larger(Real a, Real b) { return Real(hn::Max(a.v, b.v)); }
VOLCAUSTIC_HD inline Real exactMulAdd(Real a, Real b, Real c) { return Real(hn::MulAdd(a.v, b.v, c.v)); }
VOLCAUSTIC_HD inline Real unfusedSum(Real a, Real b, Real c, Real d) { return a * b + c * d; }
VOLCAUSTIC_HD inline Real toReal(Real a) { return a; }

VOLCAUSTIC_HD inline Double smaller(Double a, Double b) { return {hn::Min(a.low, b.low), hn::Min(a.high, b.high)}; }
VOLCAUSTIC_HD inline Double larger(Double a, Double b) { return {hn::Max(a.low, b.low), hn::Max(a.high, b.high)}; }
VOLCAUSTIC_HD inline Double squareRoot(Double a) { return {hn::Sqrt(a.low), hn::Sqrt(a.high)}; }
VOLCAUSTIC_HD inline Double reciprocal(Double a) {
  const auto one = hn::Set(Double::Tag(), 1.0);
  return {hn::Div(one, a.low), hn::Div(one, a.high)};
}
VOLCAUSTIC_HD inline Double awayFromZero(Double a) {
  const auto tiny = hn::Set(Double::Tag(), 1e-100);
  const auto away = [tiny](auto v) __attribute__((always_inline)) {
    return hn::IfThenElse(hn::Lt(hn::Abs(v), tiny), tiny, v);
  };
  return {away(a.low), away(a.high)};
}
VOLCAUSTIC_HD inline Float narrow(Double a) {
  const hn::Half<FloatTag> half;
  return Float(hn::Combine(FloatTag(), hn::DemoteTo(half, a.high), hn::DemoteTo(half, a.low)));
}
VOLCAUSTIC_HD inline Double load(const double* p) {
  return {hn::LoadU(Double::Tag(), p), hn::LoadU(Double::Tag(), p + hn::Lanes(Double::Tag()))};
}

/// Side by side in one register.
#if HWY_TARGET == HWY_AVX2
VOLCAUSTIC_HD inline hn::Vec<FloatTag> join(const Four& a, const Four& b) { return hn::Combine(FloatTag(), b, a); }
#else
VOLCAUSTIC_HD inline hn::Vec<FloatTag> join(const Four& a, const Four& b, const Four& c, const Four& d) {
  const hn::FixedTag<float, 8> eight;
  return hn::Combine(FloatTag(), hn::Combine(eight, d, c), hn::Combine(eight, b, a));
}
#endif

/// The first numbers of all lanes, the second, ..., from four numbers of each lane, lane(i). They come together in
/// registers: a detour over memory would wait for every store to be finished.
struct FourFloats {
  Float of[4];
};
template <class Lane>
VOLCAUSTIC_HD inline FourFloats transposed(const Lane& lane) {
#if HWY_TARGET == HWY_AVX2
  const auto a = join(lane(0), lane(4)), b = join(lane(1), lane(5)), c = join(lane(2), lane(6)),
             d = join(lane(3), lane(7));
#else
  const auto a = join(lane(0), lane(4), lane(8), lane(12)), b = join(lane(1), lane(5), lane(9), lane(13)),
             c = join(lane(2), lane(6), lane(10), lane(14)), d = join(lane(3), lane(7), lane(11), lane(15));
#endif
  // A transposition of 4x4 numbers in each 128 bits.
  const hn::Repartition<double, FloatTag> two;
  const auto ab0 = hn::BitCast(two, hn::InterleaveLower(FloatTag(), a, b));
  const auto ab1 = hn::BitCast(two, hn::InterleaveUpper(FloatTag(), a, b));
  const auto cd0 = hn::BitCast(two, hn::InterleaveLower(FloatTag(), c, d));
  const auto cd1 = hn::BitCast(two, hn::InterleaveUpper(FloatTag(), c, d));
  const auto single = [](auto v) __attribute__((always_inline)) { return Float(hn::BitCast(FloatTag(), v)); };
  return {{single(hn::InterleaveLower(two, ab0, cd0)), single(hn::InterleaveUpper(two, ab0, cd0)),
           single(hn::InterleaveLower(two, ab1, cd1)), single(hn::InterleaveUpper(two, ab1, cd1))}};
}

/// The eight corners of each lane's cell, as four loads of two neighbours along z. Working on {n, gx, gy, gz} of a lane
/// at a time costs four loads of 32 bytes where gathers of single numbers would cost 32 of 4.
VOLCAUSTIC_HD inline kernels::FieldSample<Float> mixCell(const kernels::FieldVoxel* fields, Int offset,
                                                         const kernels::Vec3<Float>& t) {
  constexpr int kX = kernels::kFieldEdge * kernels::kFieldEdge, kY = kernels::kFieldEdge;
  HWY_ALIGN std::int32_t at[kLanes];
  HWY_ALIGN float w00[kLanes], w01[kLanes], w10[kLanes], w11[kLanes], z[kLanes];
  const Float w1 = t.x * t.y;
  hn::Store(offset.v, IntTag(), at);
  hn::Store(w1.v, FloatTag(), w11);
  hn::Store((t.x - w1).v, FloatTag(), w10);
  hn::Store((t.y - w1).v, FloatTag(), w01);
  hn::Store((Float(1) - t.x - t.y + w1).v, FloatTag(), w00);
  hn::Store(t.z.v, FloatTag(), z);
  const auto lane = [&](int i) __attribute__((always_inline)) {
    const hn::FixedTag<float, 8> pair;
    const hn::FixedTag<float, 4> one;
    const float* c = &fields[at[i]].n;
    const auto a = hn::MulAdd(hn::Set(pair, w01[i]), hn::LoadU(pair, c + 4 * kY),
                              hn::Mul(hn::Set(pair, w00[i]), hn::LoadU(pair, c)));
    const auto b = hn::MulAdd(hn::Set(pair, w11[i]), hn::LoadU(pair, c + 4 * (kX + kY)),
                              hn::Mul(hn::Set(pair, w10[i]), hn::LoadU(pair, c + 4 * kX)));
    const auto sum = hn::Add(a, b);
    const auto low = hn::LowerHalf(one, sum), high = hn::UpperHalf(one, sum);
    return hn::MulAdd(hn::Set(one, z[i]), hn::Sub(high, low), low);
  };
  const FourFloats f = transposed(lane);
  return {f.of[0], kernels::Vec3<Float>(f.of[1], f.of[2], f.of[3])};
}

VOLCAUSTIC_HD inline kernels::FieldSample<Float> loadVoxel(const kernels::FieldVoxel* fields, Int offset) {
  const Int at = offset << 2;
  const float* base = &fields->n;
  return {gather(base, at), kernels::Vec3<Float>(gather(base + 1, at), gather(base + 2, at), gather(base + 3, at))};
}

/// One load of 16 bytes for each lane, from addresses that need not fit into 32 bits.
VOLCAUSTIC_HD inline kernels::FluenceWords<Float> loadVoxel(const kernels::FluenceVoxel* voxels, Int slot, Int offset) {
  const hn::ScalableTag<std::int64_t> wide;
  const hn::Half<IntTag> half;
  HWY_ALIGN std::int64_t at[kLanes];
  const auto bytes = [&](auto s, auto o) __attribute__((always_inline)) {
    constexpr int kVoxelBits = 4, kBrickBits = 13;
    return hn::Add(hn::ShiftLeft<kBrickBits>(hn::PromoteTo(wide, s)),
                   hn::ShiftLeft<kVoxelBits>(hn::PromoteTo(wide, o)));
  };
  hn::Store(bytes(hn::LowerHalf(half, slot.v), hn::LowerHalf(half, offset.v)), wide, at);
  hn::Store(bytes(hn::UpperHalf(half, slot.v), hn::UpperHalf(half, offset.v)), wide, at + kLanes / 2);
  asm("" : "+m"(at)); // g++ would take them out of the registers one by one, through the port that the rest needs
  const auto lane = [&](int i) __attribute__((always_inline)) {
    return hn::LoadU(hn::FixedTag<float, 4>(),
                     reinterpret_cast<const float*>(reinterpret_cast<const char*>(voxels) + at[i]));
  };
  const FourFloats f = transposed(lane);
  const auto word = [&](int i) __attribute__((always_inline)) { return Int(hn::BitCast(IntTag(), f.of[i].v)); };
  return {{word(0), word(1), word(2), word(3)}};
}

#if HWY_TARGET == HWY_AVX2
/// Lane numbers that bring the lanes of each 8-bit mask to the front. Highway 1.0's own table is a local constant,
/// which g++ 12 copies to the stack on every call.
struct SqueezeOrders {
  alignas(32) std::int32_t of[256][8];
  constexpr SqueezeOrders() : of() {
    for (int bits = 0; bits < 256; ++bits)
      for (int lane = 0, to = 0; lane < 8; ++lane)
        if (bits >> lane & 1) of[bits][to++] = lane;
  }
};
static constexpr SqueezeOrders kSqueezeOrders{};
#endif

/// Moves the chosen lanes side by side to the front. Made once for a mask, used for many values.
class Squeeze {
public:
  VOLCAUSTIC_HD explicit Squeeze(const Mask& on) : mCount(static_cast<int>(hn::CountTrue(FloatTag(), on.m))) {
#if HWY_TARGET == HWY_AVX2
    std::uint8_t bits = 0;
    hn::StoreMaskBits(FloatTag(), on.m, &bits);
    mOrder = hn::Load(IntTag(), kSqueezeOrders.of[bits]);
#else
    mOn = on;
#endif
  }
  [[nodiscard]] VOLCAUSTIC_HD int count() const { return mCount; }

#if HWY_TARGET == HWY_AVX2
  [[nodiscard]] VOLCAUSTIC_HD Float operator()(Float v) const {
    return Float(hn::TableLookupLanes(v.v, hn::IndicesFromVec(FloatTag(), mOrder)));
  }
  [[nodiscard]] VOLCAUSTIC_HD Int operator()(Int v) const {
    return Int(hn::TableLookupLanes(v.v, hn::IndicesFromVec(IntTag(), mOrder)));
  }

private:
  hn::Vec<IntTag> mOrder;
#else
  [[nodiscard]] VOLCAUSTIC_HD Float operator()(Float v) const { return Float(hn::Compress(v.v, mOn.m)); }
  [[nodiscard]] VOLCAUSTIC_HD Int operator()(Int v) const { return Int(hn::Compress(v.v, integers(mOn))); }

private:
  Mask mOn;
#endif
  int mCount;
};

/// a b, rounded to the nearest integer, for products within 2^22: of the sum with 1.5 2^23 only the integer is left.
/// The library's own way guards against products beyond 32 bits, which costs six operations.
VOLCAUSTIC_HD inline hn::Vec<hn::FixedTag<std::int32_t, 8>> roundedProduct(hn::Vec<hn::FixedTag<float, 8>> a,
                                                                           hn::Vec<hn::FixedTag<float, 8>> b) {
  const hn::FixedTag<float, 8> eight;
  const hn::FixedTag<std::int32_t, 8> integers;
  const auto big = hn::Set(eight, 12582912.0f);
  return hn::Sub(hn::BitCast(integers, hn::MulAdd(a, b, big)), hn::BitCast(integers, big));
}

/// Registers from memory and back, at any address.
VOLCAUSTIC_HD inline Float load(const float* p) { return Float(hn::LoadU(FloatTag(), p)); }
VOLCAUSTIC_HD inline Int load(const std::int32_t* p) { return Int(hn::LoadU(IntTag(), p)); }
VOLCAUSTIC_HD inline void store(Float v, float* p) { hn::StoreU(v.v, FloatTag(), p); }
VOLCAUSTIC_HD inline void store(Int v, std::int32_t* p) { hn::StoreU(v.v, IntTag(), p); }
VOLCAUSTIC_HD inline kernels::Vec3<Float> load3(const float* x, const float* y, const float* z) {
  return {load(x), load(y), load(z)};
}
VOLCAUSTIC_HD inline Mask firstLanes(int n) { return {hn::FirstN(FloatTag(), static_cast<std::size_t>(n))}; }

} // namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET
