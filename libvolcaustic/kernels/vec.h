// Three-component vectors of the kernels, for host and device. Grid space throughout: one voxel is one unit.
#pragma once

#include <cmath>
#include <cstdint>

/// Marks what both machines compile. Where a file is compiled for one instruction set of the CPU, everything is
/// inlined: a shared copy made there would be picked by the linker for the whole program (backends/lanes.h).
#if defined(__CUDACC__)
#define VOLCAUSTIC_HD __host__ __device__
#elif defined(VOLCAUSTIC_INSTRUCTION_SET)
#define VOLCAUSTIC_HD [[gnu::always_inline]]
#else
#define VOLCAUSTIC_HD
#endif

namespace volcaustic::kernels {

template <class T>
struct Vec3 {
  T x{}, y{}, z{};

  Vec3() = default;
  VOLCAUSTIC_HD constexpr Vec3(T x_, T y_, T z_) : x(x_), y(y_), z(z_) {}
  VOLCAUSTIC_HD constexpr explicit Vec3(T s) : x(s), y(s), z(s) {}
  template <class U>
  VOLCAUSTIC_HD constexpr explicit Vec3(const Vec3<U>& v)
      : x(static_cast<T>(v.x)), y(static_cast<T>(v.y)), z(static_cast<T>(v.z)) {}

  VOLCAUSTIC_HD constexpr T operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  VOLCAUSTIC_HD constexpr Vec3 operator-() const { return {-x, -y, -z}; }
  VOLCAUSTIC_HD constexpr Vec3& operator+=(const Vec3& b) { return *this = *this + b; }
  VOLCAUSTIC_HD constexpr Vec3& operator*=(const Vec3& b) { return *this = *this * b; }
  VOLCAUSTIC_HD constexpr Vec3& operator*=(T s) { return *this = *this * s; }

  VOLCAUSTIC_HD friend constexpr Vec3 operator+(const Vec3& a, const Vec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  VOLCAUSTIC_HD friend constexpr Vec3 operator-(const Vec3& a, const Vec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  VOLCAUSTIC_HD friend constexpr Vec3 operator*(const Vec3& a, const Vec3& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
  }
  VOLCAUSTIC_HD friend constexpr Vec3 operator*(const Vec3& a, T s) { return {a.x * s, a.y * s, a.z * s}; }
  VOLCAUSTIC_HD friend constexpr Vec3 operator*(T s, const Vec3& a) { return a * s; }
};

using Float3 = Vec3<float>;
using Double3 = Vec3<double>;
using Int3 = Vec3<std::int32_t>;

template <class T>
VOLCAUSTIC_HD constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
VOLCAUSTIC_HD constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
VOLCAUSTIC_HD inline T length(const Vec3<T>& a) {
  return std::sqrt(dot(a, a));
}
template <class T>
VOLCAUSTIC_HD inline Vec3<T> normalize(const Vec3<T>& a) {
  return a * (T(1) / length(a));
}

template <class T>
VOLCAUSTIC_HD constexpr T smaller(T a, T b) {
  return b < a ? b : a;
}
template <class T>
VOLCAUSTIC_HD constexpr T larger(T a, T b) {
  return a < b ? b : a;
}
/// v kept in [lo, hi]. smaller and larger have their own forms for lanes.
template <class T>
VOLCAUSTIC_HD constexpr T clampTo(T v, T lo, T hi) {
  return smaller(larger(v, lo), hi);
}

/// Rec. 709 luminance of a linear RGB triple.
template <class T>
VOLCAUSTIC_HD constexpr T luminance(const Vec3<T>& c) {
  return T(0.2126) * c.x + T(0.7152) * c.y + T(0.0722) * c.z;
}
template <class T>
VOLCAUSTIC_HD constexpr T maxComponent(const Vec3<T>& c) {
  return larger(c.x, larger(c.y, c.z));
}

} // namespace volcaustic::kernels
