// Photon emission: each light sees the domain's box through rasters, one ray a cell, and finds where it first meets a
// bend.
#pragma once

#include "kernels/bend_search.h"
#include "kernels/march.h"
#include "kernels/tally.h"

namespace volcaustic::kernels {

/// A uniform number in [0, 1) from a seed and two counters: the 64-bit finaliser of SplitMix64 (Steele, Lea, Flood
/// 2014).
VOLCAUSTIC_HD inline double uniform(std::uint64_t seed, std::uint64_t a, std::uint64_t b) {
  std::uint64_t z = seed * 0x9e3779b97f4a7c15ull + a * 0xbf58476d1ce4e5b9ull + b * 0x94d049bb133111ebull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1.0p-53;
}

/// Solid angle of the rectangle [u, u + du] x [v, v + dv] of the plane at distance 1: van Oosterom and Strackee's
/// formula for its two triangles. Nothing cancels in it, so single precision does for cells of any size.
template <class T>
VOLCAUSTIC_HD inline T solidAngle(T u, T v, T du, T dv) {
  constexpr float kSmall = sizeof(T) == sizeof(double) ? 1e-6f : 1e-4f; // an angle is its tangent
  const auto squared = [](T x, T y) { return x * x + y * y + T(1); };
  const auto root = [](T a) { return a * inverseRoot(a); };
  const T u1 = u + du, v1 = v + dv;
  const T a = root(squared(u, v)), b = root(squared(u1, v)), c = root(squared(u1, v1)), d = root(squared(u, v1));
  const T ac = u * u1 + v * v1 + T(1), diagonal = a * c + ac, area = du * dv;
  const T below = b * diagonal + (u * u1 + v * v + T(1)) * c + (u1 * u1 + v * v1 + T(1)) * a;
  const T above = d * diagonal + (u * u1 + v1 * v1 + T(1)) * a + (u * u + v * v1 + T(1)) * c;
  const T x = area * reciprocal(below), y = area * reciprocal(above);
  if (!any(larger(x, y) > T(kSmall))) return T(2) * (x + y); // by far most rasters
  return T(2) * (arctangent(x) + arctangent(y));
}

struct EmissionRay {
  Double3 origin;    ///< on the raster plane (parallel light) or the light itself
  Double3 direction; ///< unit
};

/// A point of a raster, in cells.
struct RasterPoint {
  double column, row;
};

/// How the intensity of a spot falls off around its axis: smoothly from all of it inside the inner angle to nothing
/// beyond the outer one, the square of a ramp in the cosine (as in glTF's KHR_lights_punctual). Or that of a piece of a
/// flat lamp, whose ramp is the cosine itself.
struct Cone {
  Float3 axis{0, 0, 1}; ///< unit
  float scale = 0;      ///< 1 / (cos inner - cos outer)
  float offset = 1;     ///< -cos outer * scale
  bool flat = false;    ///< the ramp, not its square

  /// Whether there is no falloff: a light that shines alike in all directions.
  [[nodiscard]] VOLCAUSTIC_HD bool isSphere() const { return scale == 0; }
  /// Of the intensity on the axis, in a direction of length 1.
  template <class F>
  [[nodiscard]] VOLCAUSTIC_HD F share(const Vec3<F>& d) const {
    const F cosine = d.x * F(axis.x) + d.y * F(axis.y) + d.z * F(axis.z);
    const F ramp = clampTo(cosine * F(scale) + F(offset), F(0), F(1));
    return flat ? ramp : ramp * ramp;
  }
};

/// One raster of a light, grid space. Parallel light: cells are squares of the plane through `origin` spanned by axisU
/// and axisV, light travels along axisW. Point light: cells are rectangles of the tangent plane axisW + u axisU + v
/// axisV.
struct EmissionFrame {
  Double3 origin, axisU, axisV, axisW;
  double u0 = 0, v0 = 0, du = 0, dv = 0; ///< low corner and size of a cell
  std::int32_t columns = 0, rows = 0;
  bool point = false;
  bool cubeFace = false; ///< one of six around a point light; axisW is then a coordinate axis
  bool jitter = false;
  std::uint64_t seed = 0;
  double depth0 = 0; ///< distance from the origin to the box; stored distances are relative to it
  Double3 strength;  ///< W for a cell (parallel light) or W/sr (point light; on the axis of its cone)
  Cone cone;         ///< point light

  VOLCAUSTIC_HD std::int64_t cells() const { return static_cast<std::int64_t>(columns) * rows; }

  /// Where the cell's ray goes through the raster.
  VOLCAUSTIC_HD RasterPoint pointOf(std::int64_t cell) const {
    double a = 0.5, b = 0.5;
    if (jitter) {
      a = uniform(seed, static_cast<std::uint64_t>(cell), 0);
      b = uniform(seed, static_cast<std::uint64_t>(cell), 1);
    }
    return {static_cast<double>(cell % columns) + a, static_cast<double>(cell / columns) + b};
  }
  VOLCAUSTIC_HD EmissionRay ray(std::int64_t cell) const {
    const RasterPoint p = pointOf(cell);
    return rayAt(p.column, p.row);
  }
  /// The ray through a point of the raster, in cells.
  VOLCAUSTIC_HD EmissionRay rayAt(double column, double row) const {
    const double u = u0 + column * du, v = v0 + row * dv;
    if (!point) return {origin + axisU * u + axisV * v, axisW};
    return {origin, normalize(axisW + axisU * u + axisV * v)};
  }

  /// Power of a cell in W. A cone is looked up at the cell's ray.
  VOLCAUSTIC_HD Double3 power(std::int64_t cell) const {
    if (!point) return strength;
    const double angle = solidAngle(u0 + static_cast<double>(cell % columns) * du,
                                    v0 + static_cast<double>(cell / columns) * dv, du, dv);
    return strength * (cone.isSphere() ? angle : angle * cone.share(ray(cell).direction));
  }
  /// Solid angle between the tangent plane's point (0, 0) and a corner of the raster's cells, signed.
  VOLCAUSTIC_HD double cornerAngle(std::int32_t column, std::int32_t row) const {
    const double u = u0 + column * du, v = v0 + row * dv;
    return std::atan2(u * v, std::sqrt(1 + u * u + v * v));
  }
};

VOLCAUSTIC_HD inline Double3 transmittance(const Optics& optics, double distance) {
  return {std::exp(-optics.attenuation.x * distance), std::exp(-optics.attenuation.y * distance),
          std::exp(-optics.attenuation.z * distance)};
}

/// A raster in single precision. Everything is relative to the ray through its middle, at distance depth0 from the
/// light, so rounding stays below a few ten-thousandths of a voxel however far away the light is.
struct RasterView {
  Float3 middle;       ///< that point, grid space
  Float3 along;        ///< that ray's unit vector
  Float3 cellU, cellV; ///< what a cell further adds to the point (parallel light), or to `along` before it is unit
  float middleColumn, middleRow;
  float depth0;         ///< point light
  float u0, v0, du, dv; ///< of the frame
  bool point;
};
VOLCAUSTIC_HD inline RasterView rasterView(const EmissionFrame& f) {
  const double column = 0.5 * f.columns, row = 0.5 * f.rows;
  const EmissionRay middle = f.rayAt(column, row);
  const double scale =
      f.point ? 1 / length(f.axisW + f.axisU * (f.u0 + column * f.du) + f.axisV * (f.v0 + row * f.dv)) : 1;
  return {Float3(middle.origin + middle.direction * f.depth0),
          Float3(middle.direction),
          Float3(f.axisU * (f.du * scale)),
          Float3(f.axisV * (f.dv * scale)),
          static_cast<float>(column),
          static_cast<float>(row),
          static_cast<float>(f.depth0),
          static_cast<float>(f.u0),
          static_cast<float>(f.v0),
          static_cast<float>(f.du),
          static_cast<float>(f.dv),
          f.point};
}

/// The ray through a point of the raster, in cells.
template <class F>
VOLCAUSTIC_HD inline GridRay<F> gridRay(const RasterView& view, F column, F row) {
  const auto vec = [](const Float3& a) { return Vec3<F>(F(a.x), F(a.y), F(a.z)); };
  const Vec3<F> across =
      vec(view.cellU) * (column - F(view.middleColumn)) + vec(view.cellV) * (row - F(view.middleRow));
  if (!view.point) return GridRay<F>(vec(view.middle) + across, vec(view.along));
  // The unit vector minus `along`, without their cancellation: 1/sqrt(1 + e) - 1 = -e s^2/(1 + s).
  const F e = dot(vec(view.along + view.along) + across, across), s = quotient(F(1), squareRoot(F(1) + e));
  const Vec3<F> turn = across * s - vec(view.along) * quotient(e * s * s, F(1) + s);
  return GridRay<F>(vec(view.middle) + turn * F(view.depth0), vec(view.along) + turn);
}

/// The part of a ray inside the domain's box and in front of the light, distances as in the map; empty where exit <=
/// entry.
template <class F>
VOLCAUSTIC_HD inline RaySpan<F> lightSpan(const FlatMedium& m, const RasterView& view, const GridRay<F>& ray) {
  const RaySpan<F> span = spanInBox(m.dims, ray);
  return {view.point ? larger(span.entry, F(-view.depth0)) : span.entry, span.exit};
}

/// Power of the cell whose low corner is given, as a multiple of the frame's strength.
template <class F>
VOLCAUSTIC_HD inline F cellShare(const RasterView& view, F column, F row) {
  if (!view.point) return F(1);
  return solidAngle(mulAdd(column, F(view.du), F(view.u0)), mulAdd(row, F(view.dv), F(view.v0)), F(view.du),
                    F(view.dv));
}

/// Where the rays of a raster can meet a bend: for each tile of kReachTile x kReachTile cells, bounds of the distance
/// (relative to the frame's depth0) to every brick with bends that the tile's rays may touch. nearest > farthest: none.
inline constexpr int kReachTile = 8;
struct RasterReach {
  std::int32_t columns = 0, rows = 0; ///< tiles
  const float* nearest = nullptr;
  const float* farthest = nullptr;
};

/// One cell for one call, a GPU's thread: distance of its first bend (relative to frame.depth0; kNeverBends when its
/// light goes straight through or misses the box, or meets a receiver first). Light on the way there, and light that
/// never bends, is booked here; the rest is PhotonBody's.
template <class Sink>
struct EmissionBody {
  FlatMedium medium;
  EmissionFrame frame;
  RasterView view; ///< of the frame
  RasterReach reach;
  float* entry;
  /// Of the rays of cells from stopsFrom on: distance to the first receiver, kNeverBends for none. Null without any.
  const float* stops;
  std::int64_t stopsFrom;

  VOLCAUSTIC_HD void operator()(std::int64_t cell, Sink& sink) const {
    entry[cell] = kNeverBends;
    const RasterPoint p = frame.pointOf(cell);
    const GridRay<float> ray = gridRay(view, static_cast<float>(p.column), static_cast<float>(p.row));
    RaySpan<float> span = lightSpan(medium, view, ray);
    const float stop = stops ? stops[cell - stopsFrom] : kNeverBends;
    span.exit = smaller(span.exit, stop);
    if (!(span.exit > span.entry)) return;

    const auto column = static_cast<std::int32_t>(cell % frame.columns),
               row = static_cast<std::int32_t>(cell / frame.columns);
    const std::int64_t tile = static_cast<std::int64_t>(row / kReachTile) * reach.columns + column / kReachTile;
    BendSearch<float> search(medium, ray, larger(span.entry, reach.nearest[tile]),
                             smaller(span.exit, reach.farthest[tile]), true);
    while (search.goesOn()) search.step(medium, ray);
    const bool straight = search.found() == kNeverBends;
    entry[cell] = search.found();

    float share = cellShare(view, static_cast<float>(column), static_cast<float>(row));
    if (!frame.cone.isSphere()) share *= frame.cone.share(ray.direction);
    const Double3 power = frame.strength * static_cast<double>(share);
    const float way = smaller(search.found(), span.exit) - span.entry;
    const Double3 kept = power * transmittance(medium.optics[0], way);
    sink.tally(Outcome::Emitted, power);
    tallyLoss(sink, medium.optics[0], power - kept);
    if (straight) sink.tally(stop == kNeverBends ? Outcome::Escaped : Outcome::Received, kept);
    sink.count(Counter::Emitted, 1);
    if (!straight) sink.count(Counter::Traced, 1);
  }
};

} // namespace volcaustic::kernels
