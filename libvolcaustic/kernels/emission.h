// Photon emission: each light sees the domain's box through rasters, one ray a cell, and finds where it first meets a
// bend.
#pragma once

#include "kernels/march.h"
#include "kernels/tally.h"
#include "kernels/traverse.h"

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

struct EmissionRay {
  Double3 origin;    ///< on the raster plane (parallel light) or the light itself
  Double3 direction; ///< unit
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
  Double3 strength;  ///< W for a cell (parallel light) or W/sr (point light)

  VOLCAUSTIC_HD std::int64_t cells() const { return static_cast<std::int64_t>(columns) * rows; }

  VOLCAUSTIC_HD EmissionRay ray(std::int64_t cell) const {
    double a = 0.5, b = 0.5;
    if (jitter) {
      a = uniform(seed, static_cast<std::uint64_t>(cell), 0);
      b = uniform(seed, static_cast<std::uint64_t>(cell), 1);
    }
    return rayAt(static_cast<double>(cell % columns) + a, static_cast<double>(cell / columns) + b);
  }
  /// The ray through a point of the raster, in cells.
  VOLCAUSTIC_HD EmissionRay rayAt(double column, double row) const {
    const double u = u0 + column * du, v = v0 + row * dv;
    if (!point) return {origin + axisU * u + axisV * v, axisW};
    return {origin, normalize(axisW + axisU * u + axisV * v)};
  }

  /// Power of a cell in W.
  VOLCAUSTIC_HD Double3 power(std::int64_t cell) const {
    const auto column = static_cast<std::int32_t>(cell % columns), row = static_cast<std::int32_t>(cell / columns);
    return powerOf(column, row, column + 1, row + 1);
  }
  /// Power of the cells in [column0, column1) x [row0, row1): irradiance times area, or intensity times solid angle
  /// (van Oosterom and Strackee's formula for a rectangle, as a difference of corner terms).
  VOLCAUSTIC_HD Double3 powerOf(std::int32_t column0, std::int32_t row0, std::int32_t column1,
                                std::int32_t row1) const {
    if (!point) return strength * (static_cast<double>(column1 - column0) * (row1 - row0));
    const double ua = u0 + column0 * du, va = v0 + row0 * dv, ub = u0 + column1 * du, vb = v0 + row1 * dv;
    const auto corner = [](double u, double v) { return std::atan2(u * v, std::sqrt(1 + u * u + v * v)); };
    return strength * (corner(ub, vb) - corner(ua, vb) - corner(ub, va) + corner(ua, va));
  }
};

/// Distance along o + t d, in [t0, t1], to the first voxel whose step byte says that light bends; 1e300 when there is
/// none.
VOLCAUSTIC_HD inline double firstBend(const FlatMedium& m, const Double3& o, const Double3& d, double t0, double t1) {
  double found = 1e300;
  traverse(o, d, t0, t1, m.brickDims, 3, [&](const Int3& brick, double in, double out) {
    if (!m.bends[(brick.x * m.brickDims.y + brick.y) * m.brickDims.z + brick.z]) return true;
    traverse(o, d, in, out, m.dims, 0, [&](const Int3& voxel, double voxelIn, double) {
      if (!(m.stepAt(voxel) & kStepBendsBit)) return true;
      found = voxelIn;
      return false;
    });
    return found == 1e300;
  });
  return found;
}

VOLCAUSTIC_HD inline Double3 transmittance(const Optics& optics, double distance) {
  return {std::exp(-optics.attenuation.x * distance), std::exp(-optics.attenuation.y * distance),
          std::exp(-optics.attenuation.z * distance)};
}

inline constexpr float kNeverBends = 3.0e38f;

/// Where the rays of a raster can meet a bend: for each tile of kReachTile x kReachTile cells, bounds of the distance
/// (relative to the frame's depth0) to every brick with bends that the tile's rays may touch. nearest > farthest: none.
inline constexpr int kReachTile = 8;
struct RasterReach {
  std::int32_t columns = 0, rows = 0; ///< tiles
  const float* nearest = nullptr;
  const float* farthest = nullptr;
};

/// Cell -> distance of its first bend (relative to frame.depth0; kNeverBends when its light goes straight through or
/// misses the box). Light on the way there, and light that never bends, is booked here; the rest is PhotonBody's.
template <class Sink>
struct EmissionBody {
  FlatMedium medium;
  EmissionFrame frame;
  RasterReach reach;
  float* entry;

  VOLCAUSTIC_HD void operator()(std::int64_t cell, Sink& sink) const {
    entry[cell] = kNeverBends;
    const EmissionRay ray = frame.ray(cell);
    const Span span = clipToBox(medium.dims, ray.origin, ray.direction);
    const double t0 = frame.point ? larger(span.entry, 0.0) : span.entry;
    if (!(span.exit > t0)) return;

    const std::int64_t tile = (cell / frame.columns / kReachTile) * reach.columns + cell % frame.columns / kReachTile;
    const double from = larger(t0, reach.nearest[tile] + frame.depth0),
                 to = smaller(span.exit, reach.farthest[tile] + frame.depth0);
    const double bend = to > from ? firstBend(medium, ray.origin, ray.direction, from, to) : 1e300;
    const bool straight = bend > span.exit;
    if (!straight) entry[cell] = static_cast<float>(bend - frame.depth0);

    const Double3 power = frame.power(cell);
    const Double3 kept = power * transmittance(medium.optics[0], (straight ? span.exit : bend) - t0);
    sink.tally(Outcome::Emitted, power);
    tallyLoss(sink, medium.optics[0], power - kept);
    if (straight) sink.tally(Outcome::Escaped, kept);
    sink.count(Counter::Emitted, 1);
    if (!straight) sink.count(Counter::Traced, 1);
  }
};

} // namespace volcaustic::kernels
