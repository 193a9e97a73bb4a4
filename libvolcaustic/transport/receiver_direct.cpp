#include "transport/receiver_direct.h"

#include "core/parallel.h"
#include "transport/clear_view.h"
#include "transport/emission.h"
#include "transport/lit_raster.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace volcaustic {

namespace {

using kernels::dot;
using kernels::Double3;
using kernels::EmissionFrame;
using kernels::Float3;
using kernels::ReceiverTriangle;

/// A sharp light, and what its raster knows of the ways of its light.
class LightThroughRaster {
public:
  LightThroughRaster(const Domain& domain, const Ambient& ambient, const Light& light, const EmissionFrame& frame,
                     std::span<const float> entry, const kernels::ReceiverScene& scene, bool shadows)
      : mFrame(frame)
      , mEntry(entry)
      , mScene(scene)
      , mShadows(shadows)
      , mPoint(light.type != LightType::Directional)
      , mCone(coneOf(light))
      , mDims(domain.dims[0], domain.dims[1], domain.dims[2])
      , mVoxel(domain.voxelSize)
      , mCellsU(1 / frame.du)
      , mCellsV(1 / frame.dv) {
    const Rgb& power = mPoint ? light.intensity : light.irradiance;
    mStrength = {power[0], power[1], power[2]};
    mAttenuation = Double3(ambient.attenuation[0], ambient.attenuation[1], ambient.attenuation[2]) * mVoxel;
    mClear = kernels::maxComponent(mAttenuation) == 0;
    if (mPoint)
      mOrigin = toGrid(domain, light.position);
    else
      mDirection = kernels::normalize(Double3(light.direction[0], light.direction[1], light.direction[2]));
  }

  /// Whether it is for this raster to say what comes to a point: of six around a light one.
  [[nodiscard]] bool answersFor(const Double3& p) const {
    return !mFrame.cubeFace || isCubeFace(mFrame, cubeFaceTowards(p - mFrame.origin));
  }

  /// Irradiance at a point of a surface with this unit normal that nothing shadows; 0 at its back.
  [[nodiscard]] Double3 unshadowed(const Double3& p, const Double3& normal) const {
    Double3 towards = mDirection; // where light goes
    double distance = 0, share = 1;
    if (mPoint) {
      const Double3 r = p - mOrigin;
      distance = kernels::length(r);
      if (!(distance > 0)) return {0, 0, 0};
      towards = r * (1 / distance);
      const double world = distance * mVoxel;
      share = (mCone.isSphere() ? 1 : mCone.share(towards)) / (world * world);
    }
    const double cosine = -dot(towards, normal);
    if (!(cosine > 0 && share > 0)) return {0, 0, 0};
    const Double3 all = mStrength * (share * cosine);
    return mClear ? all : all * transmitted(p, towards, distance);
  }

  /// Whether light comes to a point without a bend and past all receivers. `lifted` is the point, off the surface that
  /// it is on.
  [[nodiscard]] bool reaches(const Double3& p, const Double3& lifted) const {
    if (bends(p)) return false;
    if (!mShadows) return true;
    const Float3 at(lifted);
    if (!mPoint) return !kernels::meetsReceiver<float>(mScene, at, -Float3(mDirection), 0.0f, 3.0e38f, true);
    const Float3 back = Float3(mOrigin) - at;
    const float squared = dot(back, back), inverse = kernels::inverseRoot(std::max(squared, 1e-12f));
    return !kernels::meetsReceiver<float>(mScene, at, back * inverse, 0.0f, squared * inverse, true);
  }

  /// Whether it is known to come so to all of a patch of a flat receiver.
  [[nodiscard]] bool reachesAll(const ClearView& view, const ClearView::Patch& patch, std::int32_t receiver) const {
    return view.reaches(patch, receiver, mPoint, mPoint ? mOrigin : mDirection);
  }

private:
  /// Whether the raster's ray through the point bends before it. Beside the raster nothing is in the way.
  [[nodiscard]] bool bends(const Double3& p) const {
    if (mFrame.columns < 1 || mFrame.rows < 1) return false;
    const std::optional<RasterPlace> place = placeOnRaster(mFrame, p);
    if (!place) return false;
    double column = (place->u - mFrame.u0) * mCellsU, row = (place->v - mFrame.v0) * mCellsV;
    if (mFrame.cubeFace) { // a texel is its face's as a whole; its corners may be seen by the next one
      column = std::clamp(column, 0.0, mFrame.columns - 0.5);
      row = std::clamp(row, 0.0, mFrame.rows - 0.5);
    }
    if (!(column >= 0 && row >= 0 && column < mFrame.columns && row < mFrame.rows)) return false;
    return mEntry[static_cast<std::int64_t>(row) * mFrame.columns + static_cast<std::int64_t>(column)] <
           place->depth - mFrame.depth0;
  }

  /// Of the way through the domain's box.
  [[nodiscard]] Double3 transmitted(const Double3& p, const Double3& towards, double distance) const {
    const kernels::Span span = kernels::clipToBox(mDims, p, -towards);
    const double way = std::min(span.exit, mPoint ? distance : 1e300) - std::max(span.entry, 0.0);
    if (!(way > 0)) return {1, 1, 1};
    return {std::exp(-mAttenuation.x * way), std::exp(-mAttenuation.y * way), std::exp(-mAttenuation.z * way)};
  }

  const EmissionFrame& mFrame;
  std::span<const float> mEntry;
  const kernels::ReceiverScene& mScene;
  bool mShadows; ///< whether a receiver may stand in the way
  bool mPoint, mClear = true;
  Double3 mOrigin, mDirection, mStrength, mAttenuation; ///< grid space; W/sr or W/m2; 1/voxel
  kernels::Cone mCone;
  kernels::Int3 mDims;
  double mVoxel;
  double mCellsU, mCellsV; ///< of the raster, to a unit
};

/// A triangle as its map shows it.
class MappedTriangle {
public:
  MappedTriangle(const ReceiverTriangle& t, bool flat) : mFlat(flat), mNormal(t.normal) {
    const MapTriangle m = mapTriangle(t);
    mOrigin = m[0];
    mA = {m[1].column - m[0].column, m[1].row - m[0].row};
    mB = {m[2].column - m[0].column, m[2].row - m[0].row};
    const double det = mA.column * mB.row - mA.row * mB.column;
    mInverse = std::abs(det) > 1e-12 ? 1 / det : 0;
    mCorner = Double3(t.corner[0]);
    mEdge1 = Double3(t.corner[1]) - mCorner;
    mEdge2 = Double3(t.corner[2]) - mCorner;
  }

  /// The place of a point of the map. Where the surface turns it is kept on the triangle.
  [[nodiscard]] Double3 at(const MapPoint& p) const {
    const double c = p.column - mOrigin.column, r = p.row - mOrigin.row;
    double b1 = (c * mB.row - r * mB.column) * mInverse, b2 = (mA.column * r - mA.row * c) * mInverse;
    if (!mFlat) {
      b1 = std::max(b1, 0.0);
      b2 = std::max(b2, 0.0);
      if (const double sum = b1 + b2; sum > 1) {
        b1 /= sum;
        b2 /= sum;
      }
    }
    return mCorner + mEdge1 * b1 + mEdge2 * b2;
  }
  [[nodiscard]] const Double3& normal() const { return mNormal; }

private:
  bool mFlat;
  Double3 mNormal, mCorner, mEdge1, mEdge2;
  MapPoint mOrigin, mA, mB;
  double mInverse;
};

/// How many of side^2 points of a texel the light reaches.
int countLit(const LightThroughRaster& light, const MappedTriangle& surface, std::int32_t column, std::int32_t row,
             int side, const Double3& lift) {
  int lit = 0;
  for (int i = 0; i < side * side; ++i) {
    const Double3 p = surface.at({column + (i % side + 0.5) / side, row + (i / side + 0.5) / side});
    lit += light.reaches(p, p + lift);
  }
  return lit;
}

/// What rounding may move a point of single precision by, and more.
double clearanceAt(const Double3& p) { return 2e-3 + 4e-7 * std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); }

/// Of a texel: the light in its middle, times the part of it that is lit; all of it where that is known.
Double3 irradianceOf(const LightThroughRaster& light, const MappedTriangle& surface, std::int32_t column,
                     std::int32_t row, bool clear) {
  constexpr int kCoarse = 2, kFine = 4; // points along a side of a texel; the latter where shadow has an edge
  const Double3 middle = surface.at({column + 0.5, row + 0.5});
  if (!light.answersFor(middle)) return {0, 0, 0};
  const Double3 all = light.unshadowed(middle, surface.normal());
  if (clear || !(kernels::maxComponent(all) > 0)) return all;
  const Double3 lift = surface.normal() * clearanceAt(middle);
  int side = kCoarse, lit = countLit(light, surface, column, row, side, lift);
  if (lit != 0 && lit != side * side) {
    side = kFine;
    lit = countLit(light, surface, column, row, side, lift);
  }
  return all * (static_cast<double>(lit) / (side * side));
}

} // namespace

void addDirectLight(const ReceiverSet& set, const Domain& domain, const Ambient& ambient, const LightPart& part,
                    const EmissionFrame& frame, std::span<const float> entry, std::span<float> irradiance,
                    const RunContext& ctx) {
  constexpr std::int32_t kPatch = 16; // texels along a side of what is looked at as a whole first
  const kernels::ReceiverScene scene = set.scene();
  const bool alone = scene.surfaceCount == 1 && set.isFlat(0); // a rectangle does not shadow itself
  const LightThroughRaster light(domain, ambient, part.light, frame, entry, scene, !alone);
  const ClearView view(set, frame, entry);
  for (std::int32_t number = 0; number < scene.surfaceCount; ++number) {
    const kernels::ReceiverSurface& receiver = set.surfaces()[number];
    const auto patches = [](std::int32_t texels) { return (texels + kPatch - 1) / kPatch; };
    parallelFor(patches(receiver.rows), 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      std::int32_t last = -1;
      std::optional<MappedTriangle> surface;
      const auto surfaceOf = [&](std::int32_t triangle) -> const MappedTriangle& {
        if (triangle != last) surface.emplace(set.triangles()[last = triangle], set.isFlat(number));
        return *surface;
      };
      const auto isClear = [&](const TexelRange& t) {
        const std::int32_t triangle = set.texels()[set.texelAt(number, t.column, t.row)].triangle;
        if (triangle < 0 || !set.isFlat(number)) return false;
        const double c0 = t.column, c1 = t.column + t.columns, r0 = t.row, r1 = t.row + t.rows;
        const MappedTriangle& flat = surfaceOf(triangle);
        return light.reachesAll(view, {flat.at({c0, r0}), flat.at({c1, r0}), flat.at({c0, r1}), flat.at({c1, r1})},
                                number);
      };
      for (std::int64_t patch = begin * patches(receiver.columns); patch < end * patches(receiver.columns); ++patch) {
        TexelRange t{static_cast<std::int32_t>(patch % patches(receiver.columns)) * kPatch,
                     static_cast<std::int32_t>(patch / patches(receiver.columns)) * kPatch, 0, 0};
        t.columns = std::min(kPatch, receiver.columns - t.column);
        t.rows = std::min(kPatch, receiver.rows - t.row);
        const bool clear = isClear(t);
        for (std::int32_t row = t.row; row < t.row + t.rows; ++row)
          for (std::int32_t column = t.column; column < t.column + t.columns; ++column) {
            const std::int64_t at = set.texelAt(number, column, row);
            const std::int32_t triangle = set.texels()[at].triangle;
            if (triangle < 0) continue;
            const Double3 e = irradianceOf(light, surfaceOf(triangle), column, row, clear);
            for (int c = 0; c < 3; ++c) irradiance[3 * at + c] += static_cast<float>(e[c]);
          }
      }
    });
  }
}

} // namespace volcaustic
