// The camera pass, written over lanes: curved rays through medium and light, a pixel a lane.
#pragma once

#include "kernels/lamp.h"
#include "kernels/photon.h"

#include <limits>

namespace volcaustic::kernels {

/// Henyey-Greenstein phase function, 1/sr.
template <class F>
VOLCAUSTIC_HD inline F henyeyGreenstein(F cosine, F g) {
  const F d = F(1) + g * g - F(2) * g * cosine, inverse = inverseRoot(larger(d, F(1e-12f)));
  return (F(1) - g * g) * F(1 / (4 * 3.14159265f)) * inverse * inverse * inverse;
}

/// Phase value for light of mean direction d (|d| <= 1) scattered into the unit direction `out`: asymmetry g|d| about
/// d/|d|, so light from everywhere scatters evenly and a beam scatters as a beam.
template <class F>
VOLCAUSTIC_HD inline F effectivePhase(const Vec3<F>& d, const Vec3<F>& out, F g) {
  const F squared = dot(d, d), inverse = inverseRoot(larger(squared, F(1e-20f)));
  return henyeyGreenstein(dot(d, out) * inverse, g * smaller(squared * inverse, F(0.999f)));
}

/// (1 - exp(-t))/t, the mean of exp(-s) over [0, t]: by its series where that is exact to a float's last place, as it
/// is for most steps.
template <class F>
VOLCAUSTIC_HD inline F meanTransmittance(F t) {
  const auto next = [&](F term, float n) { return F(1) - t * F(1 / n) * term; };
  const F series = next(next(next(next(next(F(1), 6), 5), 4), 3), 2);
  const auto thick = t > F(0.125f);
  if (!any(thick)) return series;
  return select(thick, (F(1) - exponential(-t)) * reciprocal(larger(t, F(0.125f))), series);
}
template <class F>
VOLCAUSTIC_HD inline Vec3<F> meanTransmittance(const Vec3<F>& t) {
  return {meanTransmittance(t.x), meanTransmittance(t.y), meanTransmittance(t.z)};
}

/// A ray of the camera where it meets the box, or its own start where that is inside.
template <class F>
struct CameraRay {
  Vec3<F> start, direction;
  F distance;     ///< to the start
  MaskOf<F> hits; ///< whether there is a way through the box
};

/// A pinhole in grid space: the direction through the raster point (u, v) in [0, 1]^2, v down, is corner + u right + v
/// down.
struct CameraFrame {
  Double3 origin, corner, right, down;
  std::int32_t width = 0, height = 0;

  /// Through the point (column, row) of the raster, in pixels.
  template <class F>
  [[nodiscard]] VOLCAUSTIC_HD CameraRay<F> ray(const Int3& dims, const DoubleOf<F>& column,
                                               const DoubleOf<F>& row) const {
    using D = DoubleOf<F>;
    const auto vec = [](const Double3& a) { return Vec3<D>(D(a.x), D(a.y), D(a.z)); };
    const Vec3<D> o = vec(origin),
                  towards = vec(corner) + vec(right) * (column * D(1.0 / width)) + vec(down) * (row * D(1.0 / height));
    const Vec3<D> d = towards * reciprocal(squareRoot(dot(towards, towards)));
    D entry(0), exit(1e300);
    const auto axis = [&](D oa, D da, std::int32_t dim) {
      const D inverse = reciprocal(awayFromZero(da)), t0 = (D(0) - oa) * inverse, t1 = (D(dim) - oa) * inverse;
      entry = larger(entry, smaller(t0, t1));
      exit = smaller(exit, larger(t0, t1));
    };
    axis(o.x, d.x, dims.x);
    axis(o.y, d.y, dims.y);
    axis(o.z, d.z, dims.z);
    const Vec3<D> start = o + d * entry;
    return {{narrow(start.x), narrow(start.y), narrow(start.z)},
            {narrow(d.x), narrow(d.y), narrow(d.z)},
            narrow(entry),
            narrow(exit - entry) > F(0)};
  }
};

struct ViewRules {
  MarchRules march;
  float step = 1;
  std::int32_t samples = 1;
  std::int32_t maxSteps = 20000;
  float cameraIndex = 1;  ///< n at the camera
  float ambientIndex = 1; ///< n beyond the box
  Float3 up, top, bottom; ///< background: a gradient along the unit vector `up`
};

/// All that a pixel depends on.
struct ViewScene {
  FlatMedium medium;
  DirectField directLight;
  FluenceField causticLight;
  CameraFrame camera;
  ViewRules rules;
};

/// What a pixel is made of; radiance in W/(m2 sr), depth in voxels.
template <class F>
struct PixelSumOf {
  Vec3<F> caustic{F(0), F(0), F(0)}, direct{F(0), F(0), F(0)}, background{F(0), F(0), F(0)},
      transmittance{F(0), F(0), F(0)};
  F depth{3.0e38f};
  F steps{0};
};
using PixelSum = PixelSumOf<float>;

/// The layers of a picture, each a plane of as many numbers as there are pixels: R G B of the whole, opacity, R G B of
/// caustic, direct, background and transmittance, depth, steps.
inline constexpr int kPixelPlanes = 18;
struct PixelPlanes {
  float* of[kPixelPlanes];
  float voxelSize = 1;

  /// Calls put(plane, value) for each.
  template <class F, class Put>
  VOLCAUSTIC_HD void forEach(const PixelSumOf<F>& p, const Put& put) const {
    int plane = 0;
    const auto putRgb = [&](const Vec3<F>& v) {
      put(plane++, v.x);
      put(plane++, v.y);
      put(plane++, v.z);
    };
    putRgb(p.caustic + p.direct + p.background);
    put(plane++, F(1) - (p.transmittance.x + p.transmittance.y + p.transmittance.z) * F(1 / 3.0f));
    putRgb(p.caustic);
    putRgb(p.direct);
    putRgb(p.background);
    putRgb(p.transmittance);
    put(plane++, select(p.depth < F(1e38f), p.depth * F(voxelSize), F(std::numeric_limits<float>::infinity())));
    put(plane++, p.steps);
  }
};

/// What became of a pixel's ray.
template <class F>
struct RayEnd {
  IntOf<F> steps;
  MaskOf<F> notFinite, stepLimit;
};

/// A ray on its way from the camera.
template <class F>
struct ViewRay {
  RayOf<F> ray;
  Vec3<F> transmitted{F(1), F(1), F(1)}, caustic{F(0), F(0), F(0)}, direct{F(0), F(0), F(0)};
  F travelled, depth{3.0e38f};
  IntOf<F> steps{0};
  /// The way ahead through bricks in which nothing bends and all is the ambient medium, as far as it is known.
  F clear{0};
  /// The optics of the last step, and what stands in the table for them.
  IntOf<F> optics{-1};
  Vec3<F> attenuation{F(0), F(0), F(0)}, scattering{F(0), F(0), F(0)};
  F asymmetry{0};
};

/// The march of rays through the box.
template <class F>
class ViewMarch {
public:
  using I = IntOf<F>;
  using M = MaskOf<F>;

  VOLCAUSTIC_HD explicit ViewMarch(const ViewScene& scene)
      : mScene(scene), mMedium(scene.medium), mFog(maxComponent(scene.medium.optics[0].scattering) > 0) {}

  /// Carries the rays `alive` to where they leave the box, or end; the others must be finite.
  VOLCAUSTIC_HD RayEnd<F> run(ViewRay<F>& r, M alive) const {
    RayEnd<F> end{I(0), negate(alive), negate(alive)};
    end.notFinite = end.stepLimit = both(alive, negate(alive));
    while (any(alive)) {
      const Step s = step(r, alive);
      end.notFinite = either(end.notFinite, s.notFinite);
      const M over = either(either(s.leaves, s.notFinite), maxComponent(r.transmitted) < F(1e-5f));
      alive = both(alive, negate(over));
      const M limit = both(alive, r.steps > I(mScene.rules.maxSteps - 1));
      end.stepLimit = either(end.stepLimit, limit);
      alive = both(alive, negate(limit));
    }
    end.steps = r.steps;
    return end;
  }

private:
  struct Step {
    M leaves, notFinite;
  };

  /// In fog most of the way leads through bricks of the ambient medium: there a step needs no look at the medium.
  VOLCAUSTIC_HD void lookAhead(ViewRay<F>& r, const Vec3<F>& towards, const M& alive) const {
    const F ds(mScene.rules.step);
    const M near = both(alive, r.clear < ds);
    if (!any(near)) return;
    const Vec3<I> voxel = mMedium.voxelOf(mulAdd(towards, F(0.5f) * ds, r.ray.x));
    const I here = mMedium.brickIndex(mMedium.voxelOf(r.ray.x)), there = mMedium.brickIndex(voxel);
    const I busy = gather(mMedium.fieldSlots, here) | gather(mMedium.opticsSlots, here) |
                   gather(mMedium.fieldSlots, there) | gather(mMedium.opticsSlots, there);
    const F brick = distanceToCubeFace(r.ray.x, towards, voxel, I(3));
    const F ahead = smaller(brick, distanceToBoxFace(mMedium.dims, r.ray.x, towards));
    r.clear = select(near, select(busy == I(0), ahead, F(0)), r.clear);
  }

  VOLCAUSTIC_HD Step step(ViewRay<F>& r, const M& alive) const {
    const ViewRules& rules = mScene.rules;
    const RayOf<F> old = r.ray;
    const F inverse = inverseRoot(dot(old.v, old.v));
    const Vec3<F> towards = old.v * inverse;
    F ds(rules.step), length = ds;
    Step end{both(alive, negate(alive)), both(alive, negate(alive))};
    // In halves, as driftKickDrift goes, so that a way's rounding does not depend on what is known of it.
    const F half = F(0.5f) * (ds * inverse);
    RayOf<F> next{mulAdd(old.v, half, mulAdd(old.v, half, old.x)), old.v};
    I optics(0);
    M strolls = alive; // not through what is known to be clear
    if (mFog) {
      lookAhead(r, towards, alive);
      strolls = both(alive, r.clear < ds);
    }
    if (any(strolls)) {
      const Vec3<I> voxel = mMedium.voxelOf(old.x);
      const I byte = mMedium.stepAt(voxel);
      const M bends = both(strolls, (byte & I(kStepBendsBit)) != I(0));
      r.depth = select(bends, smaller(r.depth, r.travelled), r.depth);
      F longest = ds;
      if (!mFog) longest = select(bends, ds, stepLength(mMedium, rules.march, old.x, towards, voxel, byte));
      const StepResult<F> s = advanceInBox(mMedium, rules.march, old, towards, longest);
      next = {select<F>(strolls, s.ray.x, next.x), select<F>(strolls, s.ray.v, next.v)};
      ds = select(strolls, s.ds, ds);
      // Not a number compares false with everything; so does infinity with the bound.
      const Vec3<F> chord = next.x - old.x;
      const F squared = dot(chord, chord);
      const M finite = both(squared < F(1e30f), dot(next.v, next.v) < F(1e30f));
      end.notFinite = both(alive, negate(finite));
      end.leaves = both(strolls, s.leaves);
      const M straight = both(both(next.v.x == old.v.x, next.v.y == old.v.y), next.v.z == old.v.z);
      length = select(straight, ds, squared * inverseRoot(larger(squared, F(1e-30f))));
      if (mMedium.attenuates) {
        const Vec3<F> middle = select<F>(finite, (old.x + next.x) * F(0.5f), old.x);
        optics = select(strolls, mMedium.opticsIndex(mMedium.voxelOf(middle)), optics);
      }
    }
    const M moves = both(alive, negate(end.notFinite));
    r.ray = {select<F>(moves, next.x, old.x), select<F>(moves, next.v, old.v)};
    if (mMedium.attenuates) scatter(r, old.x, optics, length, moves);
    r.travelled = r.travelled + ds;
    r.clear = r.clear - ds;
    r.steps = select(alive, r.steps + I(1), r.steps);
    return end;
  }

  /// Looks the optics of a way up, where they are not as before.
  VOLCAUSTIC_HD void meet(ViewRay<F>& r, const I& optics, const M& on) const {
    const M other = both(on, optics != r.optics);
    if (!any(other)) return;
    const I at = optics * I(kOpticsFloats);
    r.attenuation = select<F>(other, gatherRgb<F>(&mMedium.optics->attenuation.x, at), r.attenuation);
    r.scattering = select<F>(other, gatherRgb<F>(&mMedium.optics->scattering.x, at), r.scattering);
    r.asymmetry = select(other, gather(&mMedium.optics->asymmetry, at), r.asymmetry);
    r.optics = select(other, optics, r.optics);
  }

  /// Adds what the way from `from` to the ray's position scatters towards the camera, and attenuates.
  VOLCAUSTIC_HD void scatter(ViewRay<F>& r, const Vec3<F>& from, const I& optics, F length, const M& on) const {
    meet(r, optics, on);
    const Vec3<F> depth = r.attenuation * length, mean = meanTransmittance(depth);
    const M scatters = both(on, maxComponent(r.scattering) > F(0));
    if (any(scatters))
      gatherLight(r, (from + r.ray.x) * F(0.5f), r.transmitted * mean * r.scattering * length, scatters);
    r.transmitted = select<F>(on, r.transmitted * (Vec3<F>(F(1)) - depth * mean), r.transmitted);
  }

  /// `weight` is what a unit of radiance scattered all along the way contributes.
  VOLCAUSTIC_HD void gatherLight(ViewRay<F>& r, const Vec3<F>& p, const Vec3<F>& weight, const M& on) const {
    const bool directed = any(both(on, negate(r.asymmetry == F(0))));
    const LightCellOf<F> cell(mMedium.dims, p);
    const LightOf<F> direct = mScene.directLight.sample<F>(p, cell, on, directed);
    const LightOf<F> caustic = mScene.causticLight.sample<F>(cell, on, directed);
    // L/n^2 is what a ray conserves: light scattered at index n arrives multiplied by (n_camera/n)^2; |v| is n.
    const Vec3<F>& v = r.ray.v;
    const F inverse = inverseRoot(dot(v, v));
    F phase(1 / (4 * 3.14159265f));
    if (directed) {
      LightOf<F> all = direct;
      all += caustic;
      const F leaning = effectivePhase(all.meanDirection(), v * (F(0) - inverse), r.asymmetry);
      phase = select(r.asymmetry == F(0), phase, leaning);
    }
    const F index = F(mScene.rules.cameraIndex) * inverse;
    const Vec3<F> scattered = weight * select(on, phase * index * index, F(0));
    r.direct += scattered * direct.fluence;
    r.caustic += scattered * caustic.fluence;
  }

  const ViewScene& mScene;
  const FlatMedium& mMedium;
  bool mFog; ///< whether the ambient medium scatters
};

/// The pixels whose high left corners are (column, row), for the lanes `on`. `count` is told the end of every ray.
template <class F, class Count>
VOLCAUSTIC_HD inline PixelSumOf<F> gatherPixel(const ViewScene& scene, const DoubleOf<F>& column,
                                               const DoubleOf<F>& row, const MaskOf<F>& on, const Count& count) {
  using D = DoubleOf<F>;
  const ViewRules& rules = scene.rules;
  const std::int32_t n = rules.samples;
  const float ratio = rules.cameraIndex / rules.ambientIndex;
  const auto vec = [](const Float3& a) { return Vec3<F>(F(a.x), F(a.y), F(a.z)); };
  PixelSumOf<F> sum;
  for (std::int32_t s = 0; s < n * n; ++s) {
    const CameraRay<F> start =
        scene.camera.ray<F>(scene.medium.dims, column + D((s % n + 0.5) / n), row + D((s / n + 0.5) / n));
    Vec3<F> transmitted(F(1)), leaving = start.direction;
    const MaskOf<F> hits = both(on, start.hits);
    if (any(hits)) {
      ViewRay<F> r;
      r.ray = {select<F>(hits, start.start, Vec3<F>(F(0.5f))), start.direction};
      r.ray.v *= sampleField(scene.medium, r.ray.x).n;
      r.travelled = start.distance;
      count(ViewMarch<F>(scene).run(r, hits));
      sum.caustic += r.caustic;
      sum.direct += r.direct;
      sum.depth = smaller(sum.depth, r.depth);
      sum.steps = sum.steps + toFloat(r.steps);
      transmitted = r.transmitted;
      leaving = select<F>(hits, r.ray.v * inverseRoot(dot(r.ray.v, r.ray.v)), leaving);
    }
    const F height = F(0.5f) + F(0.5f) * dot(leaving, vec(rules.up));
    sum.background += transmitted * (vec(rules.bottom) + vec(rules.top - rules.bottom) * height) * F(ratio * ratio);
    sum.transmittance += transmitted;
  }
  const F weight(1.0f / static_cast<float>(n * n));
  sum.caustic *= weight;
  sum.direct *= weight;
  sum.background *= weight;
  sum.transmittance *= weight;
  sum.steps = sum.steps * weight;
  return sum;
}

/// One pixel for one call: a GPU's thread, and the reference on the CPU.
template <class Sink>
struct ViewBody {
  ViewScene scene;
  PixelPlanes planes;

  VOLCAUSTIC_HD void operator()(std::int64_t i, Sink& sink) const {
    const double column = static_cast<double>(i % scene.camera.width),
                 row = static_cast<double>(i / scene.camera.width);
    const PixelSum sum = gatherPixel<float>(scene, column, row, true, [&](const RayEnd<float>& end) {
      sink.count(Counter::Steps, end.steps);
      if (end.notFinite) sink.count(Counter::NotFinite, 1);
      if (end.stepLimit) sink.count(Counter::StepLimit, 1);
    });
    planes.forEach<float>(sum, [&](int plane, float v) { planes.of[plane][i] = v; });
  }
};

} // namespace volcaustic::kernels
