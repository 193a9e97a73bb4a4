// The vocabulary of lanes: what a kernel may do with numbers when it does not know how many it holds.
//
// A kernel is written once over F: `float` is one number (a thread of a GPU, or the reference on the CPU); a backend's
// lane type holds 8 or 16 of them in a register. The functions below exist for both; for lane types they are found by
// argument-dependent lookup next to the type. Comparisons give MaskOf<F>; there is no `if` on lanes, but select().
#pragma once

#include "kernels/vec.h"

namespace volcaustic::kernels {

template <class F>
struct LaneTraits;
template <>
struct LaneTraits<float> {
  using Int = std::int32_t;
  using Mask = bool;
};
template <class F>
using IntOf = typename LaneTraits<F>::Int;
template <class F>
using MaskOf = typename LaneTraits<F>::Mask;

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
/// a b + c, fused where the machine fuses for free.
VOLCAUSTIC_HD constexpr float mulAdd(float a, float b, float c) { return a * b + c; }
/// Rounded towards zero.
VOLCAUSTIC_HD constexpr std::int32_t toInt(float a) { return static_cast<std::int32_t>(a); }
VOLCAUSTIC_HD constexpr float toFloat(std::int32_t a) { return static_cast<float>(a); }
/// 2^a for a in [0, 30].
VOLCAUSTIC_HD constexpr std::int32_t powerOfTwo(std::int32_t a) { return 1 << a; }

/// base[index], and bytes[index] widened.
VOLCAUSTIC_HD inline std::int32_t gather(const std::int32_t* base, std::int32_t index) { return base[index]; }
VOLCAUSTIC_HD inline float gather(const float* base, std::int32_t index) { return base[index]; }
VOLCAUSTIC_HD inline std::int32_t gatherByte(const std::uint8_t* bytes, std::int32_t index) { return bytes[index]; }

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
