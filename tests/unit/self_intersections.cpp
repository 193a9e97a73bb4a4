// Where surfaces run through themselves.
#include "unit/deform_support.h"

#include "deform/exact_sign.h"
#include "deform/triangle_pair.h"

#include <algorithm>
#include <random>
#include <vector>

namespace volcaustic::test {
namespace {

using Pair = std::array<std::uint32_t, 2>;

Mesh together(Mesh a, const Mesh& b) {
  const auto shift = static_cast<std::uint32_t>(a.positions.size());
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  return a;
}

/// Vertices on a lattice of whole numbers, which makes touching, coplanar and shared simplices common.
Mesh latticeSoup(int triangles, int size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> number(0, size);
  Mesh mesh;
  for (int i = 0; i < 3 * triangles; ++i)
    mesh.positions.push_back({double(number(random)), double(number(random)), double(number(random))});
  for (std::uint32_t t = 0; t < static_cast<std::uint32_t>(triangles); ++t)
    mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  return mesh;
}

// A second, slow way in whole numbers: the intersection of two triangles is the convex hull of the points where an edge
// of one meets the other. It is more than what they share if one of these is in neither the shared corners' hull.

struct Fraction { // a point of a lattice by a common denominator
  std::array<__int128, 3> top;
  __int128 bottom;
};
using Lattice = std::array<__int128, 3>;

Lattice lattice(const Vec3d& p) { return {__int128(p[0]), __int128(p[1]), __int128(p[2])}; }
Lattice minus(const Lattice& a, const Lattice& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Lattice times(const Lattice& a, const Lattice& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
__int128 inner(const Lattice& a, const Lattice& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Whether p lies in the closed triangle.
bool inside(const std::array<Lattice, 3>& t, const Fraction& p) {
  const Lattice n = times(minus(t[1], t[0]), minus(t[2], t[0]));
  const auto from = [&](const Lattice& o) {
    return Lattice{p.top[0] - o[0] * p.bottom, p.top[1] - o[1] * p.bottom, p.top[2] - o[2] * p.bottom};
  };
  if (inner(n, from(t[0])) != 0) return false;
  for (std::size_t k = 0; k < 3; ++k)
    if (inner(times(minus(t[(k + 1) % 3], t[k]), from(t[k])), n) < 0) return false;
  return true;
}

/// Points that span the intersection of segment ab and triangle t.
void spanning(const Lattice& a, const Lattice& b, const std::array<Lattice, 3>& t, std::vector<Fraction>& points) {
  const auto add = [&](const Fraction& p) {
    if (inside(t, p)) points.push_back(p);
  };
  add({a, 1});
  add({b, 1});
  const Lattice n = times(minus(t[1], t[0]), minus(t[2], t[0]));
  const auto cut = [&](const Lattice& normal, const Lattice& on) {
    __int128 da = inner(normal, minus(a, on)), db = inner(normal, minus(b, on));
    if (!((da < 0 && db > 0) || (da > 0 && db < 0))) return;
    if (da < 0) da = -da, db = -db;
    add({{a[0] * -db + b[0] * da, a[1] * -db + b[1] * da, a[2] * -db + b[2] * da}, da - db});
  };
  cut(n, t[0]);
  for (std::size_t k = 0; k < 3; ++k) cut(times(n, minus(t[(k + 1) % 3], t[k])), t[k]); // in one plane
}

bool crossSlowly(const std::array<Vec3d, 3>& s, const std::array<Vec3d, 3>& t) {
  const std::array a{lattice(s[0]), lattice(s[1]), lattice(s[2])}, b{lattice(t[0]), lattice(t[1]), lattice(t[2])};
  std::vector<Fraction> points;
  for (std::size_t k = 0; k < 3; ++k) {
    spanning(a[k], a[(k + 1) % 3], b, points);
    spanning(b[k], b[(k + 1) % 3], a, points);
  }
  std::vector<Lattice> shared;
  for (const Lattice& p : a)
    if (std::find(b.begin(), b.end(), p) != b.end()) shared.push_back(p);
  if (shared.size() == 3) return true;
  return std::ranges::any_of(points, [&](const Fraction& p) {
    if (shared.empty()) return true;
    const Lattice d{p.top[0] - shared[0][0] * p.bottom, p.top[1] - shared[0][1] * p.bottom,
                    p.top[2] - shared[0][2] * p.bottom};
    if (shared.size() == 1) return inner(d, d) != 0;
    const Lattice e = minus(shared[1], shared[0]), across = times(d, e);
    return inner(across, across) != 0 || inner(d, e) < 0 || inner(d, e) > inner(e, e) * p.bottom;
  });
}

std::vector<Pair> slowPairs(const Mesh& mesh) {
  const auto at = [&](std::size_t t) {
    const auto& c = mesh.triangles[t];
    return std::array{mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]};
  };
  const auto flat = [&](std::size_t t) {
    const auto [a, b, c] = at(t);
    const Lattice n = times(minus(lattice(b), lattice(a)), minus(lattice(c), lattice(a)));
    return inner(n, n) == 0;
  };
  std::vector<Pair> pairs;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    for (std::uint32_t j = i + 1; j < mesh.triangles.size(); ++j)
      if (!flat(i) && !flat(j) && crossSlowly(at(i), at(j))) pairs.push_back({i, j});
  return pairs;
}

TEST(ExactSign, AgreesWithWholeNumbers) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 20000; ++trial) {
    // Nearly in one plane: the fourth is a sum of the others plus a little.
    std::uniform_int_distribution<std::int64_t> number(-(1ll << 30), 1ll << 30), little(-1, 1);
    std::array<Vec3d, 4> p;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) p[i][k] = double(number(random));
    for (std::size_t k = 0; k < 3; ++k) p[3][k] = p[0][k] + p[1][k] - p[2][k] + double(little(random));
    const Lattice d = lattice(p[3]);
    const __int128 det = inner(minus(lattice(p[0]), d), times(minus(lattice(p[1]), d), minus(lattice(p[2]), d)));
    const int sign = det > 0 ? 1 : det < 0 ? -1 : 0;
    ASSERT_EQ(orientation(p[0], p[1], p[2], p[3]), sign);
    const double scale = std::ldexp(1, trial % 400 - 200); // the same sign at every size
    for (Vec3d& q : p)
      for (double& x : q) x *= scale;
    ASSERT_EQ(orientation(p[0], p[1], p[2], p[3]), sign);
  }
}

TEST(ExactSign, SeesTheLastBit) {
  const Vec3d a{12, 12, 0}, b{24, 24, 0};
  for (int i = 0; i < 64; ++i) {
    const Vec3d c{.5 + i * 0x1p-53, .5, 0};
    EXPECT_EQ(turn(a, b, c, 0, 1), i == 0 ? 0 : -1) << i;
    EXPECT_EQ(turn(b, a, c, 0, 1), i == 0 ? 0 : 1) << i;
  }
  // Numbers whose differences have no double of their own.
  EXPECT_EQ(orientation({1, 0, 0}, {0, 1, 0}, {1e-40, 1e-40, 1}, {1e-40, 1e-40, 1}), 0);
  EXPECT_EQ(orientation({1, 0, 1e-40}, {0, 1, 1e-40}, {0, 0, 1e-40}, {.25, .25, 1e-40}), 0);
  EXPECT_EQ(orientation({1, 0, 1e-40}, {0, 1, 1e-40}, {0, 0, 1e-40}, {.25, .25, 2e-40}),
            orientation({1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {.25, .25, 1}));
}

TEST(SelfIntersections, AgreeWithASlowWayInWholeNumbers) {
  std::uint64_t found = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Mesh mesh = latticeSoup(40, 2 + static_cast<int>(seed % 12), seed);
    const std::vector<Pair> expected = slowPairs(mesh);
    const SelfIntersections result = findSelfIntersections(mesh);
    ASSERT_EQ(result.pairs, expected.size()) << seed;
    const std::size_t listed = std::min<std::size_t>(expected.size(), SelfIntersections::kListed);
    ASSERT_EQ(result.examples, std::vector(expected.begin(), expected.begin() + static_cast<std::ptrdiff_t>(listed)));
    found += result.pairs;
  }
  EXPECT_GT(found, 1000u);
}

TEST(SelfIntersections, AreNoneInSoundSurfaces) {
  for (const Mesh& mesh :
       {*ball({.1, .2, .3}, .7, 20), bar(3, 4), together(*ball({0, 0, 0}, 1, 10), *ball({0, 0, 0}, 2, 10))}) {
    const SelfIntersections result = findSelfIntersections(mesh);
    EXPECT_EQ(result.pairs, 0u);
    EXPECT_FALSE(result.any());
    EXPECT_TRUE(result.examples.empty());
    EXPECT_EQ(result.bounds.max, (Vec3d{0, 0, 0}));
  }
  EXPECT_FALSE(findSelfIntersections({}).any());
}

TEST(SelfIntersections, LieWhereTwoBallsOverlap) {
  const SelfIntersections result = findSelfIntersections(together(*ball({0, 0, 0}, 1, 24), *ball({1, 0, 0}, 1, 24)));
  EXPECT_GT(result.pairs, 50u);
  // A circle of radius .87 at x = .5, and the triangles there.
  EXPECT_NEAR(result.bounds.min[0], .5, .2);
  EXPECT_NEAR(result.bounds.max[0], .5, .2);
  EXPECT_NEAR(result.bounds.max[2], std::sqrt(.75), .15);
  EXPECT_NEAR(result.bounds.min[1], -std::sqrt(.75), .15);
}

TEST(SelfIntersections, AppearWhenASurfaceIsPulledThroughItself) {
  const Mesh rest = *ball({0, 0, 0}, 1, 16);
  const auto pulled = [&](double by) {
    return findSelfIntersections(deformed(rest, std::vector{brush(DeformerType::Push, {0, 0, 1}, .6, by, {0, 0, -1})}));
  };
  EXPECT_FALSE(pulled(1).any());
  EXPECT_TRUE(pulled(2.5).any());
}

TEST(SelfIntersections, CountTwoFacesOnEachOther) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {.25, .25, 0}, {0, 0, 1}, {2, 2, 2}};
  const auto pairs = [&](std::vector<std::array<std::uint32_t, 3>> triangles) {
    mesh.triangles = std::move(triangles);
    return findSelfIntersections(mesh).pairs;
  };
  EXPECT_EQ(pairs({{0, 1, 2}, {1, 3, 2}}), 0u);            // side by side
  EXPECT_EQ(pairs({{0, 1, 2}, {2, 1, 0}}), 1u);            // the same face
  EXPECT_EQ(pairs({{0, 1, 2}, {0, 1, 3}}), 1u);            // folded over their edge
  EXPECT_EQ(pairs({{0, 1, 2}, {0, 1, 5}, {0, 1, 3}}), 1u); // a third one upright on it
  EXPECT_EQ(pairs({{0, 1, 2}, {4, 5, 6}}), 1u);            // a corner that touches a face
  EXPECT_EQ(pairs({{0, 1, 2}, {0, 4, 5}}), 1u);            // beyond the corner that they share
  EXPECT_EQ(pairs({{0, 1, 2}, {0, 5, 6}}), 0u);
  EXPECT_EQ(pairs({{0, 1, 2}, {0, 1, 1}, {4, 4, 4}}), 0u); // without area
}

TEST(SelfIntersections, DoNotDependOnThreads) {
  const Mesh mesh = latticeSoup(800, 20, 9);
  RunContext one, three;
  one.threads = 1;
  three.threads = 3;
  const SelfIntersections a = findSelfIntersections(mesh, one), b = findSelfIntersections(mesh, three);
  EXPECT_EQ(a.pairs, b.pairs);
  EXPECT_EQ(a.examples, b.examples);
  EXPECT_EQ(a.examples.size(), SelfIntersections::kListed);
  EXPECT_EQ(a.bounds.min, b.bounds.min);
}

} // namespace
} // namespace volcaustic::test
