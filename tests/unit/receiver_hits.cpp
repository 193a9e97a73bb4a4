// Where rays meet receivers: no ray slips between two triangles, no hierarchy and no neighbour in a register changes a
// hit.

#include "kernels/receivers.h"
#include "support/solids.h"
#include "transport/receiver_set.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {
/// Four lanes made of plain numbers.
template <class T>
struct Four {
  std::array<T, 4> of{};

  Four() = default;
  template <class Number>
  requires std::is_arithmetic_v<Number>
  explicit Four(Number s) { of.fill(static_cast<T>(s)); }
  Four(T a, T b, T c, T d) : of{a, b, c, d} {}
  template <class Op>
  static auto each(const Four& a, const Four& b, const Op& op) {
    return Four<decltype(op(a.of[0], b.of[0]))>(op(a.of[0], b.of[0]), op(a.of[1], b.of[1]), op(a.of[2], b.of[2]),
                                                op(a.of[3], b.of[3]));
  }
  friend Four operator+(const Four& a, const Four& b) {
    return each(a, b, [](T x, T y) { return T(x + y); });
  }
  friend Four operator-(const Four& a, const Four& b) {
    return each(a, b, [](T x, T y) { return T(x - y); });
  }
  friend Four operator*(const Four& a, const Four& b) {
    return each(a, b, [](T x, T y) { return T(x * y); });
  }
  friend Four<bool> operator<(const Four& a, const Four& b) {
    return each(a, b, [](T x, T y) { return x < y; });
  }
  friend Four<bool> operator>(const Four& a, const Four& b) { return b < a; }
  friend Four<bool> operator<=(const Four& a, const Four& b) {
    return each(a, b, [](T x, T y) { return x <= y; });
  }
  friend Four<bool> operator>=(const Four& a, const Four& b) { return b <= a; }
  friend Four<bool> operator==(const Four& a, const Four& b) {
    return each(a, b, [](T x, T y) { return x == y; });
  }
};
using Lanes = Four<float>;
using Ints = Four<std::int32_t>;
using Mask = Four<bool>;
template <class T>
Four<T> select(const Mask& m, const Four<T>& a, const Four<T>& b) {
  Four<T> c;
  for (int i = 0; i < 4; ++i) c.of[i] = m.of[i] ? a.of[i] : b.of[i];
  return c;
}
template <class T>
Four<T> smaller(const Four<T>& a, const Four<T>& b) {
  return select(b < a, b, a);
}
template <class T>
Four<T> larger(const Four<T>& a, const Four<T>& b) {
  return select(a < b, b, a);
}
bool any(const Mask& m) { return m.of[0] || m.of[1] || m.of[2] || m.of[3]; }
Mask both(const Mask& a, const Mask& b) {
  return Mask::each(a, b, [](bool x, bool y) { return x && y; });
}
Mask either(const Mask& a, const Mask& b) {
  return Mask::each(a, b, [](bool x, bool y) { return x || y; });
}
Mask negate(const Mask& a) {
  return Mask::each(a, a, [](bool x, bool) { return !x; });
}
Lanes mulAdd(const Lanes& a, const Lanes& b, const Lanes& c) { return a * b + c; }
Lanes absOf(const Lanes& a) { return larger(a, Lanes(0) - a); }
Lanes quotient(const Lanes& a, const Lanes& b) {
  return Lanes::each(a, b, [](float x, float y) { return x / y; });
}
Lanes reciprocal(const Lanes& a) { return quotient(Lanes(1), a); }
} // namespace volcaustic::test

namespace volcaustic::kernels {
template <>
struct LaneTraits<test::Lanes> {
  using Int = test::Ints;
  using Mask = test::Mask;
};
} // namespace volcaustic::kernels

namespace volcaustic::test {
namespace {

using kernels::Double3;
using kernels::Float3;
using kernels::nearestHit;
using kernels::ReceiverHit;
using kernels::ReceiverScene;
using Random = std::mt19937_64;

constexpr Domain kDomain{{0, 0, 0}, 1, {512, 512, 512}};

Receiver receiverOf(Mesh mesh) {
  Receiver r;
  r.mesh = std::make_shared<const Mesh>(std::move(mesh));
  return r;
}
ReceiverSet setOf(const std::vector<Receiver>& receivers) { return ReceiverSet(receivers, kDomain, {}); }

Double3 randomDirection(Random& random) {
  std::normal_distribution<double> n;
  return kernels::normalize(Double3(n(random), n(random), n(random)));
}
Mesh soup(Random& random, int triangles, double size) {
  std::uniform_real_distribution<double> at(0, 512), off(-size, size);
  Mesh mesh;
  for (int i = 0; i < triangles; ++i) {
    const Vec3d p{at(random), at(random), at(random)};
    for (int k = 0; k < 3; ++k) mesh.positions.push_back({p[0] + off(random), p[1] + off(random), p[2] + off(random)});
    const auto n = static_cast<std::uint32_t>(3 * i);
    mesh.triangles.push_back({n, n + 1, n + 2});
  }
  return mesh;
}
/// Every ray through one leaf: what the hierarchy must not change.
ReceiverScene withoutTree(const ReceiverScene& scene, kernels::ReceiverNode& leaf) {
  leaf = scene.nodes[0];
  leaf.first = 0;
  leaf.count = scene.triangleCount;
  ReceiverScene flat = scene;
  flat.nodes = &leaf;
  flat.nodeCount = 1;
  return flat;
}

TEST(ReceiverHits, NoRayEscapesThroughEdgesOrCorners) {
  Random random(1);
  for (const double radius : {3.0, 90.0, 250.0}) {
    const Vec3d centre{260.3, 251.7, 255.1};
    const ReceiverSet set = setOf({receiverOf(*ball(centre, radius))});
    const ReceiverScene scene = set.scene();
    std::uniform_int_distribution<std::int32_t> pick(0, scene.triangleCount - 1);
    std::uniform_real_distribution<double> u(0, 1), inside(-0.5, 0.5);
    int escaped = 0;
    double worst = 0;
    for (int i = 0; i < 250000; ++i) {
      const auto& t = scene.triangles[pick(random)];
      const Double3 a(t.corner[i % 3]), b(t.corner[(i + 1) % 3]);
      const Double3 target = i & 1 ? a : a + (b - a) * u(random);
      const Double3 from =
          Double3(centre[0], centre[1], centre[2]) + Double3(inside(random), inside(random), inside(random)) * radius;
      const Double3 way = target - from;
      const ReceiverHit<float> hit =
          nearestHit<float>(scene, Float3(from), Float3(kernels::normalize(way)), 0, 1e4f, true);
      escaped += hit.triangle < 0;
      worst = std::max(worst, std::abs(hit.distance - kernels::length(way)) / radius);
    }
    EXPECT_EQ(escaped, 0) << radius;
    EXPECT_LT(worst, 3e-4) << radius;
  }
}

// Rays along the axes and along the edges of a grid of squares, whose corners all have short coordinates.
TEST(ReceiverHits, AFloorOfSquaresHasNoCracks) {
  Mesh mesh;
  constexpr std::uint32_t kSide = 17;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i)
    mesh.positions.push_back({double(i % kSide) * 8, double(i / kSide) * 8, 5});
  for (std::uint32_t i = 0; i < kSide * (kSide - 1); ++i) {
    if (i % kSide == kSide - 1) continue;
    mesh.triangles.push_back({i, i + 1, i + kSide + 1});
    mesh.triangles.push_back({i, i + kSide + 1, i + kSide});
  }
  const ReceiverSet set = setOf({receiverOf(mesh)});
  for (const Float3& lean : {Float3(0, 0, -1), Float3(0.6f, 0, -0.8f), Float3(-0.6f, 0, -0.8f), Float3(0, 0.6f, -0.8f)})
    for (int i = 1; i < 128; ++i)
      for (int k = 1; k < 128; ++k) {
        const Float3 target(static_cast<float>(i), static_cast<float>(k), 5);
        const auto hit = nearestHit<float>(set.scene(), target - lean * 20.0f, lean, 0, 100, true);
        ASSERT_GE(hit.triangle, 0) << i << ' ' << k;
        ASSERT_NEAR(hit.distance, 20, 1e-4);
      }
}

TEST(ReceiverHits, TheHierarchyChangesNothing) {
  Random random(2);
  for (const double size : {3.0, 30.0, 400.0}) {
    const ReceiverSet set = setOf({receiverOf(soup(random, 300, size))});
    kernels::ReceiverNode leaf{};
    const ReceiverScene scene = set.scene(), flat = withoutTree(scene, leaf);
    std::uniform_real_distribution<float> at(-50, 560), log(-2, 7);
    int hits = 0;
    for (int i = 0; i < 20000; ++i) {
      const Float3 from(at(random), at(random), at(random));
      const auto& aim = scene.triangles[i % scene.triangleCount];
      const Float3 way = (aim.corner[0] + aim.corner[1] + aim.corner[2]) * (1 / 3.0f) - from;
      const Float3 towards = i & 4 ? Float3(randomDirection(random)) : kernels::normalize(way);
      const float far = i % 3 == 0 ? 3.0e38f : std::exp(log(random)), near = i % 2 ? 0 : far * 0.01f;
      const auto a = nearestHit<float>(scene, from, towards, near, far, true),
                 b = nearestHit<float>(flat, from, towards, near, far, true);
      ASSERT_EQ(a.triangle, b.triangle);
      ASSERT_EQ(a.distance, b.distance);
      ASSERT_EQ(kernels::meetsReceiver<float>(scene, from, towards, near, far, true), a.triangle >= 0);
      if (a.triangle < 0) {
        ASSERT_EQ(a.distance, far);
        continue;
      }
      ++hits;
      ASSERT_TRUE(a.distance >= near && a.distance <= far);
      const auto& t = scene.triangles[a.triangle];
      const Double3 c(t.corner[0]), point = c + (Double3(t.corner[1]) - c) * a.b1 + (Double3(t.corner[2]) - c) * a.b2;
      ASSERT_LT(kernels::length(point - Double3(from) - Double3(towards) * a.distance), 1e-2);
    }
    EXPECT_GT(hits, 200);
  }
}

TEST(ReceiverHits, LanesDoNotDisturbEachOther) {
  Random random(3);
  const ReceiverSet set = setOf({receiverOf(soup(random, 500, 60))});
  std::uniform_real_distribution<float> at(-50, 560);
  std::vector<float> irradiance(3 * static_cast<std::size_t>(set.texelCount()));
  for (float& e : irradiance) e = at(random);
  const ReceiverScene scene = set.scene(irradiance.data());
  for (int i = 0; i < 5000; ++i) {
    kernels::Vec3<Lanes> from, towards;
    Lanes far;
    const Mask on(i & 1, i & 2, i & 4, i & 8);
    Float3 froms[4], ways[4];
    for (int k = 0; k < 4; ++k) {
      froms[k] = {at(random), at(random), at(random)};
      ways[k] = Float3(randomDirection(random));
      from.x.of[k] = froms[k].x, from.y.of[k] = froms[k].y, from.z.of[k] = froms[k].z;
      towards.x.of[k] = ways[k].x, towards.y.of[k] = ways[k].y, towards.z.of[k] = ways[k].z;
      far.of[k] = std::abs(at(random));
    }
    const auto hit = nearestHit<Lanes>(scene, from, towards, Lanes(0), far, on);
    for (int k = 0; k < 4; ++k) {
      const auto alone = nearestHit<float>(scene, froms[k], ways[k], 0, far.of[k], on.of[k]);
      ASSERT_EQ(hit.triangle.of[k], alone.triangle);
      ASSERT_EQ(hit.distance.of[k], alone.distance);
    }
  }
}

TEST(ReceiverHits, OfEqualOnesTheFirst) {
  Mesh mesh = *ball({256, 256, 256}, 50, 16);
  const auto count = mesh.triangles.size();
  for (int copy = 0; copy < 3; ++copy)
    for (std::size_t i = 0; i < count; ++i) mesh.triangles.push_back(mesh.triangles[i]);
  const ReceiverSet set = setOf({receiverOf(mesh)});
  kernels::ReceiverNode leaf{};
  const ReceiverScene scene = set.scene(), flat = withoutTree(scene, leaf);
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Float3 way(randomDirection(random)), from(256, 256, 256);
    const auto hit = nearestHit<float>(scene, from, way, 0, 3.0e38f, true);
    ASSERT_EQ(hit.triangle, nearestHit<float>(flat, from, way, 0, 3.0e38f, true).triangle);
    for (std::int32_t k = 0; k < hit.triangle; ++k)
      ASSERT_FALSE(std::equal(&scene.triangles[k].corner[0].x, &scene.triangles[k].normal.x,
                              &scene.triangles[hit.triangle].corner[0].x));
  }
}

/// A floor of 100 x 50 voxels at z = 7, turned by a quarter about z.
Receiver turnedFloor() {
  Receiver floor;
  floor.placement = {{{0, -50, 0, 200}, {100, 0, 0, 300}, {0, 0, 1, 7}}};
  floor.resolution = 10;
  return floor;
}

TEST(ReceiverHits, ASquareHasItsMapEdgeToEdgeAndOneSide) {
  const ReceiverSet set = setOf({turnedFloor()});
  std::vector<float> irradiance(3 * static_cast<std::size_t>(set.texelCount()));
  for (std::size_t i = 0; i < irradiance.size(); ++i) irradiance[i] = static_cast<float>(i / 3);
  const ReceiverScene scene = set.scene(irradiance.data());
  ASSERT_EQ(set.surfaces()[0].columns, 10);
  ASSERT_EQ(set.surfaces()[0].rows, 5);
  // Its x runs along +y of the world, its y along -x; columns go with x, rows against y.
  const auto looking = [&](float x, float y, float z) {
    const Float3 from(x, y, z), down(0, 0, z > 7 ? -1.0f : 1.0f);
    const auto hit = nearestHit<float>(scene, from, down, 0, 1000, true);
    EXPECT_EQ(kernels::meetsFront<float>(scene, hit, down, true), z > 7);
    EXPECT_NEAR(hit.distance, std::abs(z - 7), 1e-4);
    return hit;
  };
  const auto corner = kernels::texelOf<float>(scene, looking(175.001f, 250.001f, 20));
  EXPECT_NEAR(corner.column, 0, 1e-3);
  EXPECT_NEAR(corner.row, 0, 1e-3);
  const auto point = kernels::texelOf<float>(scene, looking(215, 265, -3));
  EXPECT_NEAR(point.column, 1.5, 1e-4);
  EXPECT_NEAR(point.row, 4, 1e-4);
  // The mean of the texels above and below, 30 + 1 and 40 + 1; beyond the outermost middles that of the edge.
  EXPECT_NEAR(kernels::irradianceAt<float>(scene, 0, point).y, 36, 1e-3);
  EXPECT_NEAR(kernels::irradianceAt<float>(scene, 0, corner).y, 0, 1e-3);
  const auto last = kernels::texelOf<float>(scene, looking(224.999f, 349.999f, 9));
  EXPECT_NEAR(kernels::irradianceAt<float>(scene, 0, last).y, 49, 1e-3);
  const Float3 down(0, 0, -1), from(215, 265, 9);
  const auto hit = nearestHit<float>(scene, from, down, 0, 10, true);
  EXPECT_NEAR(kernels::receiverRadiance<float>(scene, hit, down, true).x, 0.8 * 36 / 3.14159265, 1e-3);
  EXPECT_EQ(kernels::receiverRadiance<float>(scene, hit, -down, true).x, 0);
  EXPECT_LT(nearestHit<float>(scene, from, down, 2.5f, 100, true).triangle, 0) << "begins behind it";
  EXPECT_LT(nearestHit<float>(scene, from, down, 0, 1.5f, true).triangle, 0) << "ends before it";
  EXPECT_LT(nearestHit<float>(scene, from, Float3(1, 0, 0), 0, 3e38f, true).triangle, 0) << "runs along it";
}

TEST(ReceiverHits, TheCameraLooksThroughWhatIsNotVisible) {
  Receiver upper = turnedFloor(), lower = turnedFloor();
  upper.placement[2][3] = 9;
  upper.visible = false;
  const ReceiverSet set = setOf({upper, lower});
  const Float3 from(215, 265, 20), down(0, 0, -1);
  EXPECT_NEAR(nearestHit<float>(set.scene(), from, down, 0, 100, true).distance, 11, 1e-4);
  EXPECT_NEAR(nearestHit<float>(set.scene(), from, down, 0, 100, true, true).distance, 13, 1e-4);
  EXPECT_EQ(nearestHit<float>(setOf({}).scene(), from, down, 0, 100, true).triangle, -1);
}

TEST(ReceiverHits, WhatMakesNoSenseIsRefusedByName) {
  const auto message = [](Receiver r) {
    r.name = "floor";
    try {
      setOf({turnedFloor(), r});
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const std::string place = "receivers[1] (floor): ";
  Receiver r;
  r.resolution = 0;
  EXPECT_EQ(message(r).find(place + "resolution"), 0u);
  r = {};
  r.placement[0][3] = std::nan("");
  EXPECT_EQ(message(r).find(place + "its placement"), 0u);
  r = {};
  r.placement[0] = {0, 0, 0, 0};
  EXPECT_EQ(message(r).find(place + "it has no area"), 0u);
  EXPECT_EQ(message(receiverOf({})).find(place + "its mesh has no triangle"), 0u);
  EXPECT_EQ(message(receiverOf({{{0, 0, 0}}, {{0, 0, 1}}, {}, {}})).find(place + "a triangle"), 0u);
  EXPECT_EQ(
      message(receiverOf({{{0, 0, 0}, {1, 0, 0}, {0, INFINITY, 0}}, {{0, 1, 2}}, {}, {}})).find(place + "it reach"),
      0u);
  r = {};
  r.resolution = kMostReceiverTexels;
  RunContext small;
  small.memoryLimit = 1 << 20;
  EXPECT_THROW(ReceiverSet(std::vector<Receiver>{r}, kDomain, small), Error);
}

} // namespace
} // namespace volcaustic::test
