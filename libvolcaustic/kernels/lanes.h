// The vocabulary of lanes: what a kernel may do with numbers when it does not know how many it holds.
//
// A kernel is written once over F: `float` is one number (a thread of a GPU, or the reference on the CPU); a backend's
// lane type holds 8 or 16 of them in a register. The functions below exist for both; for lane types they are found by
// argument-dependent lookup next to the type. Comparisons give MaskOf<F>; there is no `if` on lanes, but select().
#pragma once

#include "kernels/vec.h"

#include <type_traits>

namespace volcaustic::kernels {

template <class F>
struct LaneTraits;
template <>
struct LaneTraits<float> {
  using Int = std::int32_t;
  using Mask = bool;
  using Double = double;
};
/// Numbers that compute exactly with whole numbers: doubles within 2^53, and integers.
template <class N>
requires std::is_same_v<N, double> || std::is_integral_v<N> || std::is_same_v<N, __int128>
struct LaneTraits<N> {
  using Mask = bool;
  using Double = double;
};
template <class F>
using IntOf = typename LaneTraits<F>::Int;
template <class F>
using MaskOf = typename LaneTraits<F>::Mask;
template <class F>
using DoubleOf = typename LaneTraits<F>::Double;

template <class T>
VOLCAUSTIC_HD constexpr T select(bool mask, T a, T b) {
  return mask ? a : b;
}
VOLCAUSTIC_HD constexpr bool any(bool mask) { return mask; }
VOLCAUSTIC_HD constexpr bool both(bool a, bool b) { return a && b; }
VOLCAUSTIC_HD constexpr bool either(bool a, bool b) { return a || b; }
VOLCAUSTIC_HD constexpr bool negate(bool a) { return !a; }

VOLCAUSTIC_HD inline float absOf(float a) { return std::abs(a); }
VOLCAUSTIC_HD inline float reciprocal(float a) { return 1 / a; }
/// 1/sqrt(a), a > 0; lanes may be a unit in the last place off.
VOLCAUSTIC_HD inline float inverseRoot(float a) { return 1 / std::sqrt(a); }
VOLCAUSTIC_HD inline float exponential(float a) { return std::exp(a); }
/// Rounded to the nearest on every machine, unlike the two above: what is decided with them is decided alike
/// everywhere.
VOLCAUSTIC_HD inline float quotient(float a, float b) { return a / b; }
VOLCAUSTIC_HD inline float squareRoot(float a) { return std::sqrt(a); }
VOLCAUSTIC_HD inline float arctangent(float a) { return std::atan(a); }
/// What is written over lanes and wanted in double precision too.
VOLCAUSTIC_HD inline double inverseRoot(double a) { return 1 / std::sqrt(a); }
VOLCAUSTIC_HD inline double reciprocal(double a) { return 1 / a; }
VOLCAUSTIC_HD inline double arctangent(double a) { return std::atan(a); }
/// a b + c, fused where the machine fuses for free.
VOLCAUSTIC_HD constexpr float mulAdd(float a, float b, float c) { return a * b + c; }
/// The same of numbers that are exact either way.
template <class N>
VOLCAUSTIC_HD constexpr N exactMulAdd(N a, N b, N c) {
  return a * b + c;
}
/// a b + c d, fused on no machine.
VOLCAUSTIC_HD inline double unfusedSum(double a, double b, double c, double d) {
#if defined(__CUDA_ARCH__)
  return __dadd_rn(__dmul_rn(a, b), __dmul_rn(c, d));
#else
  return a * b + c * d;
#endif
}
/// The nearest double.
template <class N>
VOLCAUSTIC_HD constexpr double toReal(N a) {
  return static_cast<double>(a);
}
/// Rounded towards zero.
VOLCAUSTIC_HD constexpr std::int32_t toInt(float a) { return static_cast<std::int32_t>(a); }
VOLCAUSTIC_HD constexpr float toFloat(std::int32_t a) { return static_cast<float>(a); }
/// 2^a for a in [0, 30].
VOLCAUSTIC_HD constexpr std::int32_t powerOfTwo(std::int32_t a) { return 1 << a; }

/// The float of these bits.
VOLCAUSTIC_HD inline float floatOfBits(std::int32_t a) { return __builtin_bit_cast(float, a); }
/// v of any one lane that the mask, which has some, holds.
VOLCAUSTIC_HD constexpr std::int32_t oneOf(bool, std::int32_t v) { return v; }

/// What a ray's start needs of doubles.
VOLCAUSTIC_HD inline double squareRoot(double a) { return std::sqrt(a); }
VOLCAUSTIC_HD inline float narrow(double a) { return static_cast<float>(a); }
/// a, or something tiny in place of 0.
VOLCAUSTIC_HD inline double awayFromZero(double a) { return std::abs(a) < 1e-100 ? 1e-100 : a; }

/// base[index], and bytes[index] widened.
VOLCAUSTIC_HD inline std::int32_t gather(const std::int32_t* base, std::int32_t index) { return base[index]; }
VOLCAUSTIC_HD inline float gather(const float* base, std::int32_t index) { return base[index]; }
VOLCAUSTIC_HD inline std::int32_t gatherByte(const std::uint8_t* bytes, std::int32_t index) { return bytes[index]; }
/// table[index] of a table that registers hold.
inline constexpr int kLookUpSize = 16;
VOLCAUSTIC_HD inline std::int32_t lookUp(const std::int32_t (&table)[kLookUpSize], std::int32_t index) {
  return table[index];
}
/// The highest bit of each of 64 bytes. The first argument names the lanes to do it with.
VOLCAUSTIC_HD inline std::uint64_t highBits(float, const std::uint8_t* bytes) {
  std::uint64_t bits = 0;
  for (int i = 0; i < 64; ++i) bits |= static_cast<std::uint64_t>(bytes[i] >> 7) << i;
  return bits;
}

/// smaller, larger and clampTo of vec.h are the scalar forms; these take lanes too.
template <class F>
VOLCAUSTIC_HD inline Vec3<F> select(const MaskOf<F>& mask, const Vec3<F>& a, const Vec3<F>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}
template <class F>
VOLCAUSTIC_HD inline Vec3<F> mulAdd(const Vec3<F>& a, F s, const Vec3<F>& c) {
  return {mulAdd(a.x, s, c.x), mulAdd(a.y, s, c.y), mulAdd(a.z, s, c.z)};
}

} // namespace volcaustic::kernels
