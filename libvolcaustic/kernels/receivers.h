// Opaque diffuse surfaces: where a straight piece of a way meets one, and the light that they have collected. Grid
// space, written over lanes.
//
// Watertight (after Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2013): a corner is projected
// along the ray to a point of a plane, the same point whichever triangle asks. On which side of an edge the ray passes
// is the sign of a difference of two rounded products; rounding keeps order, so the sign is right or zero, and zero
// counts as inside. Two triangles that share an edge never both refuse a ray that meets it.
#pragma once

#include "kernels/lanes.h"

namespace volcaustic::kernels {

/// A box of a hierarchy, in depth-first order. Inner nodes have count 0, their children follow, and `first` is the node
/// behind all of them; leaves hold triangles first to first + count - 1.
struct ReceiverNode {
  Float3 low;
  std::int32_t first;
  Float3 high;
  std::int32_t count;
};

struct ReceiverTriangle {
  Float3 corner[3];
  Float3 normal;     ///< unit; points to the side that collects light
  float texel[3][2]; ///< column and row of the corners in the receiver's map: texel (c, r) is [c, c+1] x [r, r+1]
  std::int32_t receiver;
};
inline constexpr std::int32_t kReceiverTriangleFloats = sizeof(ReceiverTriangle) / sizeof(float);

/// What is the same all over a receiver.
struct ReceiverSurface {
  std::int32_t firstTexel, columns, rows; ///< of its map, rows from the top
  std::int32_t visible; ///< 0: the camera does not see it; it collects light and blocks it all the same
  Float3 albedo;
};
inline constexpr std::int32_t kReceiverSurfaceFloats = sizeof(ReceiverSurface) / sizeof(float);

struct ReceiverScene {
  const ReceiverNode* nodes = nullptr;
  const ReceiverTriangle* triangles = nullptr; ///< in the order in which nodes hold them
  const ReceiverSurface* surfaces = nullptr;
  const float* irradiance = nullptr; ///< R, G, B of each texel, W/m2
  std::int32_t nodeCount = 0, triangleCount = 0, surfaceCount = 0;
  std::int64_t texelCount = 0;

  [[nodiscard]] VOLCAUSTIC_HD bool any() const { return triangleCount > 0; }
};

/// Where the photon of a raster cell has come to its end on the front of a receiver.
struct Landing {
  float column, row;          ///< in the receiver's map, as ReceiverTriangle::texel
  std::int32_t triangle = -1; ///< -1: it has not
  float power[3];             ///< W
};

static_assert(sizeof(ReceiverNode) == 32 && sizeof(Landing) == 24);

/// Consecutive pieces of a way that bends should overlap by as much (voxels): the end of a piece is rounded, and a
/// surface between the two roundings would be missed by both.
inline constexpr float kReceiverOverlap = 0.01f;

template <class F>
struct ReceiverHit {
  F distance;
  IntOf<F> triangle; ///< -1: none
  F b1, b2;          ///< the point is corner 0 + b1 (corner 1 - corner 0) + b2 (corner 2 - corner 0)
};

/// A point of a receiver's map.
template <class F>
struct TexelPoint {
  F column, row;
};

/// a b - c d, fused on no machine: with the pairs exchanged it is the exact negative.
VOLCAUSTIC_HD inline float unfusedDifference(float a, float b, float c, float d) {
#if defined(__CUDA_ARCH__)
  return __fsub_rn(__fmul_rn(a, b), __fmul_rn(c, d));
#else
  return a * b - c * d;
#endif
}
template <class F>
VOLCAUSTIC_HD inline F unfusedDifference(F a, F b, F c, F d) {
  return a * b - c * d;
}

/// The pieces of rays from `nearest` to `farthest`, against boxes and triangles.
template <class F>
class ReceiverSearch {
public:
  using I = IntOf<F>;
  using M = MaskOf<F>;

  VOLCAUSTIC_HD ReceiverSearch(const ReceiverScene& scene, const Vec3<F>& origin, const Vec3<F>& direction, F nearest,
                               F farthest)
      : mScene(scene), mOrigin(origin), mDirection(direction), mNearest(nearest), mHit{farthest, I(-1), F(0), F(0)} {}

  /// Those of the lanes `on` whose piece's own box meets the box of all triangles. No reciprocal: this is asked at
  /// every step of every ray.
  [[nodiscard]] VOLCAUSTIC_HD M nearAny(const M& on) const {
    const ReceiverNode& root = mScene.nodes[0];
    const auto axis = [&](F o, F d, float low, float high) {
      const F a = mulAdd(d, mNearest, o), b = mulAdd(d, mHit.distance, o);
      return both(larger(a, b) >= F(low), smaller(a, b) <= F(high));
    };
    return both(both(on, axis(mOrigin.z, mDirection.z, root.low.z, root.high.z)),
                both(axis(mOrigin.x, mDirection.x, root.low.x, root.high.x),
                     axis(mOrigin.y, mDirection.y, root.low.y, root.high.y)));
  }

  /// Looks through the hierarchy for the lanes `on`, of which there are some: for the nearest hits, or for any.
  /// Triangles come by number, so that of equal distances the first stays.
  VOLCAUSTIC_HD void run(M on, bool anyHit, bool visibleOnly) {
    prepare();
    for (std::int32_t i = 0; i < mScene.nodeCount;) {
      const ReceiverNode& node = mScene.nodes[i];
      const bool leaf = node.count > 0;
      const M meets = both(on, meetsBox(node));
      if (!any(meets)) {
        i = leaf ? i + 1 : node.first;
        continue;
      }
      for (std::int32_t k = node.first; k < node.first + node.count; ++k)
        if (!visibleOnly || mScene.surfaces[mScene.triangles[k].receiver].visible) tryTriangle(k, meets);
      if (anyHit && leaf) {
        on = both(on, mHit.triangle < I(0));
        if (!any(on)) return;
      }
      ++i;
    }
  }
  [[nodiscard]] VOLCAUSTIC_HD const ReceiverHit<F>& hit() const { return mHit; }

private:
  /// Two vectors that span, with the direction, a right-handed orthonormal frame (Duff et al., "Building an Orthonormal
  /// Basis, Revisited", JCGT 2017), and the inverses of the direction's components.
  VOLCAUSTIC_HD void prepare() {
    const Vec3<F>& d = mDirection;
    const F sign = select(d.z < F(0), F(-1), F(1)), a = F(0) - reciprocal(sign + d.z), b = d.x * d.y * a;
    mAcross = {F(1) + sign * d.x * d.x * a, sign * b, F(0) - sign * d.x};
    mUp = {b, sign + d.y * d.y * a, F(0) - d.y};
    const auto inverse = [](F v) { return quotient(F(1), select(absOf(v) > F(1e-18f), v, F(1e-18f))); };
    mInverse = {inverse(d.x), inverse(d.y), inverse(d.z)};
  }

  /// Boxes are a little larger than what they hold (transport/receiver_tree.h), and the far side may lie before the
  /// near one by the rounding of both.
  [[nodiscard]] VOLCAUSTIC_HD M meetsBox(const ReceiverNode& node) const {
    F in = mNearest, out = mHit.distance;
    const auto axis = [&](F o, F inverse, float low, float high) {
      const F a = (F(low) - o) * inverse, b = (F(high) - o) * inverse;
      in = larger(in, smaller(a, b));
      out = smaller(out, larger(a, b));
    };
    axis(mOrigin.x, mInverse.x, node.low.x, node.high.x);
    axis(mOrigin.y, mInverse.y, node.low.y, node.high.y);
    axis(mOrigin.z, mInverse.z, node.low.z, node.high.z);
    return in <= out + absOf(out) * F(1e-6f);
  }

  /// A corner seen along the ray: across it, and along it.
  struct Seen {
    F x, y, depth;
  };
  [[nodiscard]] VOLCAUSTIC_HD Seen seen(const Float3& corner) const {
    const Vec3<F> r{F(corner.x) - mOrigin.x, F(corner.y) - mOrigin.y, F(corner.z) - mOrigin.z};
    return {dot(r, mAcross), dot(r, mUp), dot(r, mDirection)};
  }

  VOLCAUSTIC_HD void tryTriangle(std::int32_t number, const M& on) {
    const ReceiverTriangle& t = mScene.triangles[number];
    const Seen a = seen(t.corner[0]), b = seen(t.corner[1]), c = seen(t.corner[2]);
    const F u = unfusedDifference(b.x, c.y, b.y, c.x), v = unfusedDifference(c.x, a.y, c.y, a.x),
            w = unfusedDifference(a.x, b.y, a.y, b.x), sum = u + v + w;
    const F least = smaller(u, smaller(v, w)), most = larger(u, larger(v, w));
    M hits = both(on, both(either(least >= F(0), most <= F(0)), negate(sum == F(0))));
    if (!any(hits)) return;
    const F scale = quotient(F(1), select(sum == F(0), F(1), sum));
    const F distance = (u * a.depth + v * b.depth + w * c.depth) * scale;
    const M first = both(mHit.triangle < I(0), distance == mHit.distance);
    hits = both(hits, both(distance >= mNearest, either(distance < mHit.distance, first)));
    mHit = {select(hits, distance, mHit.distance), select(hits, I(number), mHit.triangle),
            select(hits, v * scale, mHit.b1), select(hits, w * scale, mHit.b2)};
  }

  const ReceiverScene& mScene;
  Vec3<F> mOrigin, mDirection, mInverse, mAcross, mUp;
  F mNearest;
  ReceiverHit<F> mHit;
};

/// The nearest point of any receiver, front or back, at a distance from `nearest` to `farthest` (at most 3e38) along
/// the unit vector `direction`; the first triangle of several at the same distance. For the lanes `on`; the others must
/// be finite, and find nothing. The same for a lane whatever the others do. A ray that starts on a receiver gives a
/// `nearest` beyond its own roundings. `visibleOnly`: as the camera sees them.
template <class F>
[[nodiscard]] VOLCAUSTIC_HD inline ReceiverHit<F> nearestHit(const ReceiverScene& scene, const Vec3<F>& origin,
                                                             const Vec3<F>& direction, F nearest, F farthest,
                                                             const MaskOf<F>& on, bool visibleOnly = false) {
  ReceiverSearch<F> search(scene, origin, direction, nearest, farthest);
  if (scene.any()) {
    const MaskOf<F> near = search.nearAny(on);
    if (any(near)) search.run(near, false, visibleOnly);
  }
  return search.hit();
}

/// Whether there is any such point: the question that shadows ask.
template <class F>
[[nodiscard]] VOLCAUSTIC_HD inline MaskOf<F> meetsReceiver(const ReceiverScene& scene, const Vec3<F>& origin,
                                                           const Vec3<F>& direction, F nearest, F farthest,
                                                           const MaskOf<F>& on) {
  ReceiverSearch<F> search(scene, origin, direction, nearest, farthest);
  if (scene.any()) {
    const MaskOf<F> near = search.nearAny(on);
    if (any(near)) search.run(near, true, false);
  }
  return both(on, negate(search.hit().triangle < IntOf<F>(0)));
}

/// Lanes that have met something.
template <class F>
[[nodiscard]] VOLCAUSTIC_HD inline MaskOf<F> found(const ReceiverHit<F>& hit) {
  return negate(hit.triangle < IntOf<F>(0));
}

/// Where in its array of floats the triangle of a hit begins; that of triangle 0 where there is none.
template <class F>
[[nodiscard]] VOLCAUSTIC_HD inline IntOf<F> triangleOffset(const ReceiverHit<F>& hit) {
  return larger(hit.triangle, IntOf<F>(0)) * IntOf<F>(kReceiverTriangleFloats);
}

/// Those of the lanes `on` that have met a front: the side that collects light and shows it.
template <class F>
[[nodiscard]] VOLCAUSTIC_HD inline MaskOf<F> meetsFront(const ReceiverScene& scene, const ReceiverHit<F>& hit,
                                                        const Vec3<F>& direction, const MaskOf<F>& on) {
  const MaskOf<F> met = both(on, found(hit));
  if (!any(met)) return met;
  const IntOf<F> at = triangleOffset(hit);
  const float* normal = &scene.triangles->normal.x;
  return both(met, dot(direction, Vec3<F>(gather(normal, at), gather(normal + 1, at), gather(normal + 2, at))) < F(0));
}

/// Where a hit is in its receiver's map. Something finite for lanes that have met nothing; there must be a triangle.
template <class F>
[[nodiscard]] VOLCAUSTIC_HD inline TexelPoint<F> texelOf(const ReceiverScene& scene, const ReceiverHit<F>& hit) {
  const IntOf<F> at = triangleOffset(hit);
  const float* texel = &scene.triangles->texel[0][0];
  const auto mix = [&](int axis) {
    const F a = gather(texel + axis, at), b = gather(texel + 2 + axis, at), c = gather(texel + 4 + axis, at);
    return a + hit.b1 * (b - a) + hit.b2 * (c - a);
  };
  return {mix(0), mix(1)};
}

/// The number of the receiver that a hit is on; 0 for lanes that have met nothing.
template <class F>
[[nodiscard]] VOLCAUSTIC_HD inline IntOf<F> receiverOf(const ReceiverScene& scene, const ReceiverHit<F>& hit) {
  return gather(&scene.triangles->receiver, triangleOffset(hit));
}

/// Irradiance at a point of a receiver's map, W/m2: bilinear between the middles of texels, constant beyond the
/// outermost.
template <class F>
[[nodiscard]] VOLCAUSTIC_HD inline Vec3<F> irradianceAt(const ReceiverScene& scene, const IntOf<F>& receiver,
                                                        const TexelPoint<F>& p) {
  using I = IntOf<F>;
  const I at = receiver * I(kReceiverSurfaceFloats);
  const std::int32_t* surface = &scene.surfaces->firstTexel;
  const I columns = gather(surface + 1, at), rows = gather(surface + 2, at);
  const F x = clampTo(p.column - F(0.5f), F(0), toFloat(columns - I(1))),
          y = clampTo(p.row - F(0.5f), F(0), toFloat(rows - I(1)));
  const I column = toInt(x), row = toInt(y);
  const F u = x - toFloat(column), v = y - toFloat(row);
  const I right = smaller(column + I(1), columns - I(1)) - column, below = smaller(row + I(1), rows - I(1)) - row;
  const I first = (gather(surface, at) + row * columns + column) * I(3), aside = right * I(3),
          under = below * columns * I(3);
  const auto channel = [&](int c) {
    const float* e = scene.irradiance + c;
    const F top = gather(e, first) + u * (gather(e, first + aside) - gather(e, first));
    const F bottom = gather(e, first + under) + u * (gather(e, first + under + aside) - gather(e, first + under));
    return top + v * (bottom - top);
  };
  return {channel(0), channel(1), channel(2)};
}

/// Radiance that the receiver of a hit sends back along the ray, W/(m2 sr): albedo E / pi from its front, nothing from
/// its back or where nothing was met.
template <class F>
[[nodiscard]] VOLCAUSTIC_HD inline Vec3<F> receiverRadiance(const ReceiverScene& scene, const ReceiverHit<F>& hit,
                                                            const Vec3<F>& direction, const MaskOf<F>& on) {
  using I = IntOf<F>;
  const MaskOf<F> front = meetsFront(scene, hit, direction, on);
  if (!any(front)) return Vec3<F>(F(0));
  const I receiver = receiverOf(scene, hit), at = receiver * I(kReceiverSurfaceFloats);
  const float* albedo = &scene.surfaces->albedo.x;
  const Vec3<F> reflected{gather(albedo, at), gather(albedo + 1, at), gather(albedo + 2, at)};
  const Vec3<F> radiance = reflected * irradianceAt<F>(scene, receiver, texelOf(scene, hit)) * F(1 / 3.14159265f);
  return select<F>(front, radiance, Vec3<F>(F(0)));
}

} // namespace volcaustic::kernels
