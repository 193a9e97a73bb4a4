// Lamps: the light that they send through the ambient medium where nothing stands in its way.
#pragma once

#include "kernels/emission.h"
#include "kernels/fluence.h"

namespace volcaustic::kernels {

/// A light in grid space.
struct Lamp {
  Float3 origin{0, 0, 0};      ///< point light
  Float3 direction{0, 0, 1};   ///< parallel light: unit vector
  Float3 strength{0, 0, 0};    ///< fluence (parallel light), or fluence times distance^2 in voxels (point light)
  Float3 attenuation{0, 0, 0}; ///< of the ambient medium, 1/voxel
  Float3 box{0, 0, 0};         ///< high corner of the domain
  Cone cone;                   ///< point light
  bool point = false, clear = true;

  /// Whether its light is the same everywhere.
  [[nodiscard]] VOLCAUSTIC_HD bool uniform() const { return !point && clear; }
};

/// Fluence of a lamp, and where it goes.
template <class F>
struct LampLight {
  Vec3<F> fluence, direction;
};
template <class F>
VOLCAUSTIC_HD inline LampLight<F> lampLight(const Lamp& lamp, const Vec3<F>& p) {
  const auto vec = [](const Float3& a) { return Vec3<F>(F(a.x), F(a.y), F(a.z)); };
  LampLight<F> light{vec(lamp.strength), vec(lamp.direction)};
  F way(3.0e38f);
  if (lamp.point) {
    const Vec3<F> r = p - vec(lamp.origin);
    // Inside the light's own voxel: as at half a voxel.
    const F squared = dot(r, r), inverse = inverseRoot(larger(squared, F(1e-12f)));
    light.direction = r * inverse;
    light.fluence = light.fluence * reciprocal(larger(squared, F(0.25f)));
    if (!lamp.cone.isSphere()) light.fluence = light.fluence * lamp.cone.share(light.direction);
    way = squared * inverse;
  }
  if (lamp.clear) return light;
  // Back along the light to the face of the box, or to the light itself.
  const auto axis = [&](F pa, F da, float high) {
    const F back = select(da > F(0), pa, pa - F(high));
    way = smaller(way, select(absOf(da) > F(1e-6f), back * reciprocal(da), F(3.0e38f)));
  };
  axis(p.x, light.direction.x, lamp.box.x);
  axis(p.y, light.direction.y, lamp.box.y);
  axis(p.z, light.direction.z, lamp.box.z);
  const Vec3<F> depth = vec(lamp.attenuation) * way;
  const F kept = exponential(-depth.x);
  const bool grey = lamp.attenuation.y == lamp.attenuation.x && lamp.attenuation.z == lamp.attenuation.x;
  light.fluence = light.fluence * (grey ? Vec3<F>(kept) : Vec3<F>(kept, exponential(-depth.y), exponential(-depth.z)));
  return light;
}

/// Light that has not met a bend: in most bricks whole lamps, evaluated where they are asked for; voxels only where an
/// edge of a shadow runs through.
struct DirectField {
  FluenceField stored;                     ///< bricks with an entry here are read, not evaluated
  const std::int32_t* sets = nullptr;      ///< for each brick, the number of the set of lamps that light it
  const std::int32_t* setBegins = nullptr; ///< of each set in setLamps, and the end of the last
  const std::int32_t* setLamps = nullptr;  ///< numbers of lamps
  const Lamp* lamps = nullptr;

  /// Of the lamps of a set, for the lanes `on`.
  template <class F>
  [[nodiscard]] VOLCAUSTIC_HD LightOf<F> lit(const IntOf<F>& set, const Vec3<F>& p, const MaskOf<F>& on,
                                             bool directed) const {
    LightOf<F> sum;
    for (MaskOf<F> left = on; any(left);) {
      const std::int32_t s = oneOf(left, set);
      const MaskOf<F> same = both(left, set == IntOf<F>(s));
      left = both(left, negate(same));
      for (std::int32_t i = setBegins[s]; i < setBegins[s + 1]; ++i) {
        const LampLight<F> l = lampLight<F>(lamps[setLamps[i]], p);
        const Vec3<F> fluence = select<F>(same, l.fluence, Vec3<F>(F(0)));
        sum.fluence += fluence;
        if (directed) sum.towards += l.direction * luminance(fluence);
      }
    }
    return sum;
  }
  /// At a voxel's centre.
  [[nodiscard]] VOLCAUSTIC_HD Light at(const Int3& v) const {
    const std::int64_t brick = stored.brickOf(v);
    const std::int32_t entry = stored.entries[brick];
    return entry != 0 ? stored.at(entry, v) : lit<float>(sets[brick], Float3(v) + Float3(0.5f), true, true);
  }
  /// At a point and its cell, for the lanes `on`: trilinear between voxels, exact between lamps; towards only where
  /// `directed`.
  template <class F>
  [[nodiscard]] VOLCAUSTIC_HD LightOf<F> sample(const Vec3<F>& p, const LightCellOf<F>& cell, const MaskOf<F>& on,
                                                bool directed) const {
    using I = IntOf<F>;
    const CornerEntries<F> entry(stored.entries, stored.brickDims, cell), set(sets, stored.brickDims, cell);
    MaskOf<F> whole = both(on, entry.of[0] == I(0)); // no brick around has voxels or other lamps
    for (std::int32_t i = 1; i < 8; ++i)
      if (!(i & ~cell.crossed)) whole = both(whole, both(entry.of[i] == I(0), set.of[i] == set.of[0]));
    LightOf<F> sum = lit<F>(set.of[0], p, whole, directed);
    const MaskOf<F> mixed = both(on, negate(whole));
    if (!any(mixed)) return sum;
    for (std::int32_t i = 0; i < 8; ++i) {
      const Vec3<I> v = cell.corner(i);
      const F weight = cell.weight(i);
      stored.addVoxel(sum, entry.of[i], v, weight, mixed, directed);
      const MaskOf<F> lamplit = both(mixed, entry.of[i] == I(0));
      const auto centre = [](const I& c) { return toFloat(c) + F(0.5f); };
      if (any(lamplit)) sum += lit<F>(set.of[i], {centre(v.x), centre(v.y), centre(v.z)}, lamplit, directed) * weight;
    }
    return sum;
  }
  [[nodiscard]] VOLCAUSTIC_HD Light sample(const Float3& p) const {
    return sample<float>(p, LightCellOf<float>(stored.dims, p), true, true);
  }
};

} // namespace volcaustic::kernels
