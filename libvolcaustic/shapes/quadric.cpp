#include "shapes/quadric.h"

#include "core/simd_clones.h"
#include "shapes/affine.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volcaustic {

namespace {

QuadraticForm centred(const Vec3d& squares, double c) { return {{}, {squares[0], squares[1], squares[2]}, {}, c}; }

Vec3d unit(const Vec3d& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

double inverseSquare(double r) { return 1 / (r * r); }

struct FormOf {
  QuadraticForm operator()(const shapes::Quadric& s) const {
    const auto& c = s.coefficients;
    return {{}, {c[0], c[1], c[2], .5 * c[3], .5 * c[4], .5 * c[5]}, {c[6], c[7], c[8]}, c[9]};
  }
  QuadraticForm operator()(const shapes::Plane& s) const {
    const Vec3d n = unit(s.normal);
    return {{}, {}, {-n[0], -n[1], -n[2]}, s.offset};
  }
  QuadraticForm operator()(const shapes::Slab& s) const {
    const Vec3d n = unit(s.normal);
    const double k = -4 * inverseSquare(s.thickness);
    return {{},
            {k * n[0] * n[0], k * n[1] * n[1], k * n[2] * n[2], k * n[0] * n[1], k * n[1] * n[2], k * n[2] * n[0]},
            {},
            1};
  }
  QuadraticForm operator()(const shapes::Sphere& s) const {
    const double k = -inverseSquare(s.radius);
    return centred({k, k, k}, 1);
  }
  QuadraticForm operator()(const shapes::Ellipsoid& s) const {
    return centred({-inverseSquare(s.semiAxes[0]), -inverseSquare(s.semiAxes[1]), -inverseSquare(s.semiAxes[2])}, 1);
  }
  QuadraticForm operator()(const shapes::Cylinder& s) const {
    return centred({-inverseSquare(s.radii[0]), -inverseSquare(s.radii[1]), 0}, 1);
  }
  QuadraticForm operator()(const shapes::Cone& s) const {
    const double k = -inverseSquare(s.radius);
    return {{0, 0, s.height}, {k, k, inverseSquare(s.height)}, {}, 0};
  }
  QuadraticForm operator()(const shapes::Paraboloid& s) const {
    const double k = -inverseSquare(s.radius);
    return {{}, {k, k, 0}, {0, 0, 1 / s.height}, 0};
  }
  QuadraticForm operator()(const shapes::Hyperboloid& s) const {
    const double half = .5 * s.height, waist = inverseSquare(s.waist);
    if (s.sheets == 1) return centred({-waist, -waist, (s.rim * s.rim * waist - 1) * inverseSquare(half)}, 1);
    const double k = -(half * half * waist - 1) * inverseSquare(s.rim);
    return centred({k, k, waist}, -1);
  }
  template <class NoQuadric>
  QuadraticForm operator()(const NoQuadric&) const {
    return {};
  }
};

/// Greatest absolute eigenvalue of a symmetric matrix, a little rounded up.
double spectralNorm(const Symmetric3& a) {
  const std::array<double, 3> values = eigenvalues(a);
  return std::max(std::abs(values[0]), std::abs(values[2])) * (1 + 1e-12);
}

/// A form's value and gradient at each point, added up anew in each loop so that all of them become SIMD.
struct FormAt {
  double q, x, y, z;
};
inline FormAt at(const QuadraticForm& f, double px, double py, double pz) {
  const double x = px - f.origin[0], y = py - f.origin[1], z = pz - f.origin[2];
  const double ax = f.a[0] * x + f.a[3] * y + f.a[5] * z, ay = f.a[3] * x + f.a[1] * y + f.a[4] * z,
               az = f.a[5] * x + f.a[4] * y + f.a[2] * z;
  return {(ax + f.b[0]) * x + (ay + f.b[1]) * y + (az + f.b[2]) * z + f.c, 2 * ax + f.b[0], 2 * ay + f.b[1],
          2 * az + f.b[2]};
}

/// Under the root: zero only where the surface is singular, and there the value is zero.
constexpr double kTiny = 1e-280;

/// Arrays apart from each other and from the points.
struct Sums {
  double* __restrict f;
  double* __restrict x;
  double* __restrict y;
  double* __restrict z;
};

VOLCAUSTIC_SIMD_CLONES void startSums(const QuadraticForm form, const ShapePoints p, const Sums s) {
  for (int i = 0; i < p.count; ++i) {
    const FormAt q = at(form, p.x[i], p.y[i], p.z[i]);
    s.f[i] = q.q;
    s.x[i] = q.x;
    s.y[i] = q.y;
    s.z[i] = q.z;
  }
}

VOLCAUSTIC_SIMD_CLONES void addDeviation(const QuadraticForm region, double weight, double greatest,
                                         const ShapePoints p, const Sums s) {
  for (int i = 0; i < p.count; ++i) {
    const FormAt q = at(region, p.x[i], p.y[i], p.z[i]);
    const double m = std::min(std::max(q.q, 0.0), greatest), slope = 3 * weight * m * m;
    s.f[i] += weight * m * m * m;
    s.x[i] += slope * q.x;
    s.y[i] += slope * q.y;
    s.z[i] += slope * q.z;
  }
}

VOLCAUSTIC_SIMD_CLONES void distances(double curvature, const Sums s, int count, double* __restrict values) {
  const double l2 = curvature * curvature;
  for (int i = 0; i < count; ++i) {
    const double g = s.x[i] * s.x[i] + s.y[i] * s.y[i] + s.z[i] * s.z[i];
    values[i] = s.f[i] / std::sqrt(std::sqrt(g * g + l2 * s.f[i] * s.f[i] + kTiny));
  }
}

/// h += w (6 m (grad q . grad F) grad q + 6 m^2 A grad F): the deviation's part of H grad F.
VOLCAUSTIC_SIMD_CLONES void addCurvature(const QuadraticForm region, double weight, double greatest,
                                         const ShapePoints p, const Sums s, double* __restrict hx,
                                         double* __restrict hy, double* __restrict hz) {
  for (int i = 0; i < p.count; ++i) {
    const FormAt q = at(region, p.x[i], p.y[i], p.z[i]);
    const double m = std::min(std::max(q.q, 0.0), greatest);
    const double along = 6 * weight * m * (q.x * s.x[i] + q.y * s.y[i] + q.z * s.z[i]), across = 6 * weight * m * m;
    const auto& a = region.a;
    hx[i] += along * q.x + across * (a[0] * s.x[i] + a[3] * s.y[i] + a[5] * s.z[i]);
    hy[i] += along * q.y + across * (a[3] * s.x[i] + a[1] * s.y[i] + a[4] * s.z[i]);
    hz[i] += along * q.z + across * (a[5] * s.x[i] + a[4] * s.y[i] + a[2] * s.z[i]);
  }
}

VOLCAUSTIC_SIMD_CLONES void startCurvature(const QuadraticForm form, const Sums s, int count, double* __restrict hx,
                                           double* __restrict hy, double* __restrict hz) {
  const auto& a = form.a;
  for (int i = 0; i < count; ++i) {
    hx[i] = 2 * (a[0] * s.x[i] + a[3] * s.y[i] + a[5] * s.z[i]);
    hy[i] = 2 * (a[3] * s.x[i] + a[1] * s.y[i] + a[4] * s.z[i]);
    hz[i] = 2 * (a[5] * s.x[i] + a[4] * s.y[i] + a[2] * s.z[i]);
  }
}

/// grad D = grad F S^(-1/4) - F grad S S^(-5/4) / 4, S = |grad F|^4 + l^2 F^2, grad S = 4 |grad F|^2 H grad F
/// + 2 l^2 F grad F; `h` is H grad F.
VOLCAUSTIC_SIMD_CLONES void gradients(double curvature, const Sums s, int count, const double* __restrict hx,
                                      const double* __restrict hy, const double* __restrict hz,
                                      const ShapeValues values) {
  const double l2 = curvature * curvature;
  double* __restrict gx = values.gradient[0];
  double* __restrict gy = values.gradient[1];
  double* __restrict gz = values.gradient[2];
  for (int i = 0; i < count; ++i) {
    const double g = s.x[i] * s.x[i] + s.y[i] * s.y[i] + s.z[i] * s.z[i];
    const double sum = g * g + l2 * s.f[i] * s.f[i] + kTiny, root = 1 / std::sqrt(std::sqrt(sum));
    const double k = .25 * s.f[i] * root / sum, own = root - 2 * k * l2 * s.f[i], other = 4 * k * g;
    gx[i] = own * s.x[i] - other * hx[i];
    gy[i] = own * s.y[i] - other * hy[i];
    gz[i] = own * s.z[i] - other * hz[i];
  }
}

/// What a form and its gradient take over a box, exactly but for roundings: about the box's middle, where
/// q(m + u) = q(m) + grad q(m).u + u.(A u), and what is mixed in the last term counts by its magnitude.
struct FormBounds {
  Interval q;
  std::array<Interval, 3> gradient;
};
FormBounds boundsOf(const QuadraticForm& f, const Box& box) {
  Vec3d middle, half, farthest;
  for (int i = 0; i < 3; ++i) {
    middle[i] = .5 * (box.min[i] + box.max[i]);
    half[i] = .5 * (box.max[i] - box.min[i]) * (1 + 1e-15);
    farthest[i] = std::max(std::abs(box.min[i] - f.origin[i]), std::abs(box.max[i] - f.origin[i]));
  }
  const FormAt m = at(f, middle[0], middle[1], middle[2]);
  const Vec3d slope{m.x, m.y, m.z};
  FormBounds bounds{{m.q, m.q}, {}};
  double terms = std::abs(f.c);
  for (int i = 0; i < 3; ++i) {
    // Along an axis the parabola slope u + a u^2 has its least and greatest at the ends or at its apex.
    const double h = half[i], a = f.a[i], ends = std::abs(slope[i]) * h;
    double low = a * h * h - ends, high = a * h * h + ends;
    if (a != 0 && std::abs(slope[i]) < 2 * std::abs(a) * h) {
      const double apex = -.25 * slope[i] * slope[i] / a;
      (a > 0 ? low : high) = apex;
    }
    bounds.q.low += low;
    bounds.q.high += high;
    const double mixed = 2 * std::abs(entry(f.a, i, (i + 1) % 3)) * h * half[(i + 1) % 3];
    bounds.q = widened(bounds.q, mixed);

    double reach = 0, size = std::abs(f.b[i]);
    for (int j = 0; j < 3; ++j) {
      reach += 2 * std::abs(entry(f.a, i, j)) * half[j];
      size += 2 * std::abs(entry(f.a, i, j)) * (farthest[j] + std::abs(f.origin[j]) * 1e-3);
    }
    terms += size * farthest[i];
    bounds.gradient[i] = widened({slope[i], slope[i]}, reach + kRoundingSlack * size);
  }
  bounds.q = widened(bounds.q, kRoundingSlack * terms);
  return bounds;
}

/// By its principal minors, which lose no digits where eigenvalues are zero as those of cylinders and slabs are.
bool fallsOff(const Symmetric3& a) {
  constexpr double kSlack = 1e-14;
  for (int i = 0; i < 3; ++i) {
    const double x = entry(a, i, i), y = entry(a, (i + 1) % 3, (i + 1) % 3), xy = entry(a, i, (i + 1) % 3);
    if (x > 0 || x * y - xy * xy < -kSlack * x * y) return false;
  }
  const double terms[] = {a[0] * a[1] * a[2], 2 * a[3] * a[4] * a[5], -a[0] * a[4] * a[4], -a[1] * a[5] * a[5],
                          -a[2] * a[3] * a[3]};
  double determinant = 0, size = 0;
  for (const double term : terms) {
    determinant += term;
    size += std::abs(term);
  }
  return determinant <= kSlack * size;
}

/// Of forms that fall off to all sides of where their gradient vanishes, their value there.
double greatestOf(const QuadraticForm& f) {
  const bool isSlanted = f.b[0] != 0 || f.b[1] != 0 || f.b[2] != 0;
  return isSlanted || !fallsOff(f.a) ? std::numeric_limits<double>::infinity() : std::max(f.c, 0.0);
}

double distanceLike(double f, double g, double l2) { return f / std::sqrt(std::sqrt(g * g + l2 * f * f + kTiny)); }

} // namespace

QuadraticForm quadraticForm(const shapes::Kind& kind) { return std::visit(FormOf{}, kind); }

QuadraticForm placedForm(const QuadraticForm& local, const Affine& toWorld) {
  // With p = M u + t, u - o = M^-1 (p - (M o + t)): q keeps its shape about the place where the origin went.
  const Affine back = inverse(toWorld);
  QuadraticForm world;
  world.c = local.c;
  for (int i = 0; i < 3; ++i) {
    world.origin[i] = toWorld[i][3];
    for (int j = 0; j < 3; ++j) {
      world.origin[i] += toWorld[i][j] * local.origin[j];
      world.b[i] += back[j][i] * local.b[j];
    }
  }
  constexpr int kRows[] = {0, 1, 2, 0, 1, 2}, kColumns[] = {0, 1, 2, 1, 2, 0};
  for (int k = 0; k < 6; ++k)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) world.a[k] += back[i][kRows[k]] * entry(local.a, i, j) * back[j][kColumns[k]];
  return world;
}

PlacedQuadric::PlacedQuadric(const QuadraticForm& form, const std::vector<QuadraticForm>& regions,
                             const std::vector<double>& weights)
    : mForm(form), mCurvature(spectralNorm(form.a)) {
  for (std::size_t i = 0; i < regions.size(); ++i) mRegions.push_back({regions[i], weights[i], greatestOf(regions[i])});
}

void PlacedQuadric::evaluate(const ShapePoints& pWorld, std::span<const std::uint32_t> active,
                             const ShapeValues& values) const {
  BatchNumbers f, x, y, z;
  const Sums sums{f.data(), x.data(), y.data(), z.data()};
  startSums(mForm, pWorld, sums);
  for (const std::uint32_t i : active)
    addDeviation(mRegions[i].form, mRegions[i].weight, mRegions[i].greatest, pWorld, sums);
  distances(mCurvature, sums, pWorld.count, values.value);
  if (!values.wantsGradient()) return;
  BatchNumbers hx, hy, hz;
  startCurvature(mForm, sums, pWorld.count, hx.data(), hy.data(), hz.data());
  for (const std::uint32_t i : active)
    addCurvature(mRegions[i].form, mRegions[i].weight, mRegions[i].greatest, pWorld, sums, hx.data(), hy.data(),
                 hz.data());
  gradients(mCurvature, sums, pWorld.count, hx.data(), hy.data(), hz.data(), values);
}

Interval PlacedQuadric::bound(const Box& world, std::span<const std::uint32_t> active) const {
  FormBounds sum = boundsOf(mForm, world);
  for (const std::uint32_t i : active) {
    const FormBounds region = boundsOf(mRegions[i].form, world);
    const Interval weight{mRegions[i].weight, mRegions[i].weight};
    const Interval q{std::clamp(region.q.low, 0.0, mRegions[i].greatest),
                     std::clamp(region.q.high, 0.0, mRegions[i].greatest)};
    const Interval cube = weight * Interval{q.low * q.low * q.low, q.high * q.high * q.high};
    sum.q = widened(sum.q + cube, kRoundingSlack * magnitude(cube));
    const Interval slope = weight * Interval{3 * q.low * q.low, 3 * q.high * q.high};
    for (int a = 0; a < 3; ++a) {
      const Interval part = slope * region.gradient[a];
      sum.gradient[a] = widened(sum.gradient[a] + part, kRoundingSlack * magnitude(part));
    }
  }
  // D grows with F, and its magnitude falls with |grad F|^2.
  const Interval g = square(sum.gradient[0]) + square(sum.gradient[1]) + square(sum.gradient[2]);
  const double gLow = g.low * (1 - 1e-14), gHigh = g.high * (1 + 1e-14), l2 = mCurvature * mCurvature;
  const Interval d{distanceLike(sum.q.low, sum.q.low >= 0 ? gHigh : gLow, l2),
                   distanceLike(sum.q.high, sum.q.high >= 0 ? gLow : gHigh, l2)};
  return widened(d, kRoundingSlack * magnitude(d));
}

bool PlacedQuadric::vanishes(std::uint32_t i, const Box& world) const {
  return boundsOf(mRegions[i].form, world).q.high <= 0;
}

void PlacedQuadric::addTo(Hash& hash, std::span<const std::uint32_t> active) const {
  const auto add = [&](const QuadraticForm& f) {
    hash.values(std::span<const double>(f.origin)).values(std::span<const double>(f.a));
    hash.values(std::span<const double>(f.b)).value(f.c);
  };
  add(mForm);
  hash.value(active.size());
  for (const std::uint32_t i : active) {
    add(mRegions[i].form);
    hash.value(mRegions[i].weight);
  }
}

} // namespace volcaustic
