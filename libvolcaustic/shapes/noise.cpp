#include "shapes/noise.h"

#include "core/simd_clones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace volcaustic {

namespace {

// Gradient noise: at each point of a lattice of whole numbers there is a unit vector g, chosen by a hash, and the
// linear function g.(p - corner). Between the eight corners of a cell these are mixed with the weights of the fade
// s(t) = 6t^5 - 15t^4 + 10t^3, whose first and second derivatives are 0 at both ends: so the noise is twice
// continuously differentiable (Perlin, Improving noise, 2002).
//
// Its range. By Jensen's inequality |n| <= sum of w_c |p - c| <= sqrt(sum of w_c |p - c|^2), and the sum under the root
// falls into one for each axis, (1 - s) t^2 + s (1 - t)^2 = t^2 + s (1 - 2t). That is 1/4 at most: for t <= 1/2 it says
// s <= 1/4 + t/2, and s, convex there, lies below its chord t. So |n| <= sqrt(3/4).
//
// Its derivatives. Each is at every point a sum of a_c.g_c over the corners, where the vectors a_c depend on the place
// in the cell alone; it is at most the sum of their lengths. The greatest sums in a cell are 2.793 for a first
// derivative, 10 for a second one along an axis and 8.425 for a mixed one, found at steps of a hundredth; below they
// are rounded up by more than what can lie between these steps.
constexpr double kRange = 0.8660254037844387;
constexpr double kSlope = 2.82, kBend = 10.1, kTwist = 8.52;

/// A function's value at a point, and its gradient.
struct Sample {
  double value, x, y, z;
};

/// Wellons's two rounds of multiplication, which leave next to no bias.
[[gnu::always_inline]] inline std::uint32_t mixed(std::uint32_t h) {
  h = (h ^ h >> 16) * 0x7feb352du;
  h = (h ^ h >> 15) * 0x846ca68bu;
  return h ^ h >> 16;
}

/// g.(x, y, z): g is the stereographic projection of a point of a square, on one of both sides.
[[gnu::always_inline]] inline Sample cornerFunction(std::uint32_t corner, double x, double y, double z) {
  const std::uint32_t h = mixed(corner);
  const double u = static_cast<int>(h & 0x7fff) * (2. / 0x7fff) - 1;
  const double v = static_cast<int>(h >> 15 & 0x7fff) * (2. / 0x7fff) - 1;
  const double square = u * u + v * v, k = (static_cast<int>(h >> 30 & 1) * 2 - 1) / (1 + square);
  const double gx = 2 * u * k, gy = 2 * v * k, gz = (1 - square) * k;
  return {gx * x + gy * y + gz * z, gx, gy, gz};
}

[[gnu::always_inline]] inline Sample blend(const Sample& a, const Sample& b, double s) {
  return {a.value + s * (b.value - a.value), a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.z + s * (b.z - a.z)};
}

/// A coordinate as whole cells, modulo 2^32, and the part of one.
struct Cell {
  std::uint32_t index;
  double part;
};
[[gnu::always_inline]] inline Cell cellOf(double x) {
  const double whole = std::floor(x), turns = std::floor(whole * 0x1p-32);
  return {static_cast<std::uint32_t>(static_cast<std::int32_t>(whole - turns * 0x1p32 - 0x1p31)), x - whole};
}

[[gnu::always_inline]] inline double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }
[[gnu::always_inline]] inline double fadeSlope(double t) { return 30 * t * t * (1 - t) * (1 - t); }

/// One octave at a point of the lattice's space, and its gradient there.
[[gnu::always_inline]] inline Sample noiseAt(std::uint32_t seed, double px, double py, double pz) {
  const Cell i = cellOf(px), j = cellOf(py), k = cellOf(pz);
  const double x = i.part, y = j.part, z = k.part, sx = fade(x), sy = fade(y), sz = fade(z);
  const std::uint32_t kX = 0x9e3779b1u, kY = 0x85ebca77u, kZ = 0xc2b2ae3du;
  const std::uint32_t x0 = i.index * kX, x1 = x0 + kX, y0 = j.index * kY, y1 = y0 + kY, z0 = seed + k.index * kZ;
  const auto alongX = [&](std::uint32_t yz, double dy, double dz) __attribute__((always_inline)) {
    const Sample a = cornerFunction(x0 ^ yz, x, dy, dz), b = cornerFunction(x1 ^ yz, x - 1, dy, dz);
    Sample m = blend(a, b, sx);
    m.x += fadeSlope(x) * (b.value - a.value);
    return m;
  };
  const auto alongY = [&](std::uint32_t hash, double dz) __attribute__((always_inline)) {
    const Sample a = alongX(y0 ^ hash, y, dz), b = alongX(y1 ^ hash, y - 1, dz);
    Sample m = blend(a, b, sy);
    m.y += fadeSlope(y) * (b.value - a.value);
    return m;
  };
  const Sample a = alongY(z0, z), b = alongY(z0 + kZ, z - 1);
  Sample m = blend(a, b, sz);
  m.z += fadeSlope(z) * (b.value - a.value);
  return m;
}

struct Octave {
  double frequency, height;
  Vec3d offset; ///< of the lattice: no two octaves are 0 in the same places
  std::uint32_t seed;

  [[nodiscard]] [[gnu::always_inline]] Sample at(double x, double y, double z) const {
    return noiseAt(seed, x * frequency + offset[0], y * frequency + offset[1], z * frequency + offset[2]);
  }
};

VOLCAUSTIC_SIMD_CLONES void addValues(const Octave octave, const ShapePoints p, double* __restrict value) {
  for (int i = 0; i < p.count; ++i) value[i] += octave.height * octave.at(p.x[i], p.y[i], p.z[i]).value;
}

VOLCAUSTIC_SIMD_CLONES void addGradients(const Octave octave, const ShapePoints p, double* __restrict gx,
                                         double* __restrict gy, double* __restrict gz) {
  const double slope = octave.height * octave.frequency;
  for (int i = 0; i < p.count; ++i) {
    const Sample s = octave.at(p.x[i], p.y[i], p.z[i]);
    gx[i] += slope * s.x;
    gy[i] += slope * s.y;
    gz[i] += slope * s.z;
  }
}

/// Of one octave, without its height: within its range, and by Taylor's formula about the middle of the box.
Interval boundOf(const Octave& octave, const Box& box) {
  Vec3d middle, half;
  double size = 1, sum = 0, squares = 0;
  for (int a = 0; a < 3; ++a) {
    middle[a] = .5 * (box.min[a] + box.max[a]);
    half[a] = .5 * (box.max[a] - box.min[a]) * octave.frequency;
    size += std::max(std::abs(box.min[a]), std::abs(box.max[a])) * octave.frequency + std::abs(octave.offset[a]);
    sum += half[a];
    squares += half[a] * half[a];
  }
  const double slack = kSlope * kRoundingSlack * size, first = kSlope * sum;
  if (!(first + slack < 2 * kRange)) return {-kRange - kRoundingSlack, kRange + kRoundingSlack};
  const Sample m = octave.at(middle[0], middle[1], middle[2]);
  const double second = std::abs(m.x) * half[0] + std::abs(m.y) * half[1] + std::abs(m.z) * half[2] +
                        .5 * (kBend * squares + kTwist * (sum * sum - squares));
  const double spread = std::min(first, second) + slack;
  return {std::max(m.value - spread, -kRange - kRoundingSlack), std::min(m.value + spread, kRange + kRoundingSlack)};
}

class NoiseFunction final : public ShapeFunction {
public:
  explicit NoiseFunction(const shapes::NoiseDisplacement& s) {
    double sum = 0, part = 1;
    for (int o = 0; o < s.octaves; ++o, part *= s.gain) {
      Octave octave{std::ldexp(1 / s.size, o), part, {}, mixed(static_cast<std::uint32_t>(s.seed) + 0x9e3779b9u * o)};
      constexpr Vec3d kStep{.8191725133961645, .6710436067037893, .5497004779019703}; // they fill a cube evenly
      for (int a = 0; a < 3; ++a) octave.offset[a] = o * kStep[a] - s.drift[a] * octave.frequency;
      mOctaves.push_back(octave);
      sum += part;
    }
    for (Octave& octave : mOctaves) octave.height *= s.amplitude / (kRange * sum);
  }

  void evaluate(const ShapePoints& p, const ShapeValues& v) const override {
    std::fill_n(v.value, p.count, 0.0);
    for (const Octave& octave : mOctaves) addValues(octave, p, v.value);
    if (!v.wantsGradient()) return;
    for (double* g : v.gradient) std::fill_n(g, p.count, 0.0);
    for (const Octave& octave : mOctaves) addGradients(octave, p, v.gradient[0], v.gradient[1], v.gradient[2]);
  }

  [[nodiscard]] Interval bound(const Box& box) const override {
    Interval sum;
    for (const Octave& octave : mOctaves) {
      const Interval one = boundOf(octave, box);
      sum = sum + Interval{octave.height * one.low, octave.height * one.high};
    }
    return widened(sum, kRoundingSlack * magnitude(sum));
  }

private:
  std::vector<Octave> mOctaves;
};

} // namespace

std::unique_ptr<ShapeFunction> makeNoise(const shapes::NoiseDisplacement& noise) {
  return std::make_unique<NoiseFunction>(noise);
}

} // namespace volcaustic
