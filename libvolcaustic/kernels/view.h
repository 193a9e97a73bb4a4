// The camera pass, written over lanes: curved rays through medium and light, a pixel a lane.
#pragma once

#include "kernels/photon.h"
#include "kernels/pixel_planes.h"
#include "kernels/view_ray.h"

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

/// The march of rays through the box. What a lane does depends on no other lane, so rays may be put together as is
/// convenient.
template <class F>
class ViewMarch {
public:
  using I = IntOf<F>;
  using M = MaskOf<F>;

  VOLCAUSTIC_HD explicit ViewMarch(const ViewScene& scene)
      : mScene(scene), mMedium(scene.medium), mFog(maxComponent(scene.medium.optics[0].scattering) > 0) {}

  /// Carries the rays `alive` on as long as goesOn(those left) says, at most to where they leave the box, or end; the
  /// others must be finite. \return those left
  template <class GoesOn>
  VOLCAUSTIC_HD M run(ViewRay<F>& r, M alive, RayEnd<F>& end, const GoesOn& goesOn) const {
    while (any(alive) && goesOn(alive)) {
      const Step s = step(r, alive);
      end.notFinite = either(end.notFinite, s.notFinite);
      M dark = maxComponent(r.transmitted) < F(1e-5f);
      if (mScene.rules.fresnel) dark = both(dark, negate(r.mirrors.crossing.before > F(0)));
      const M over = either(either(s.leaves, s.lands), either(s.notFinite, dark));
      const M ended = both(alive, over);
      alive = both(alive, negate(over));
      if (mScene.rules.fresnel && any(ended))
        alive = either(alive, reflectWaiting(r, both(ended, negate(s.notFinite))));
      const M limit = both(alive, r.steps > I(mScene.rules.maxSteps - 1));
      end.stepLimit = either(end.stepLimit, limit);
      alive = both(alive, negate(limit));
    }
    return alive;
  }

private:
  /// What a step did, and where.
  struct Step {
    RayOf<F> to;
    F length;  ///< of the chord
    I optics;  ///< at its middle
    M strides; ///< crosses a whole brick of even light
    M lit;
    M leaves, notFinite;
    M lands; ///< on a receiver
  };

  VOLCAUSTIC_HD Step step(ViewRay<F>& r, const M& alive) const {
    const Vec3<F> towards = r.ray.v * inverseRoot(dot(r.ray.v, r.ray.v));
    const Vec3<I> voxel = mMedium.voxelOf(mulAdd(towards, F(0.5f * mScene.rules.step), r.ray.x));
    const M free = lookAhead(r, towards, voxel, alive), none = both(alive, negate(alive));
    const M fine = (r.plan & I(kPlanFine)) != I(0);
    F ds = select(fine, smaller(F(mScene.rules.step), r.clear), r.clear);
    r.box = r.box - ds;
    r.clear = select(free, r.clear - ds, r.clear);
    Step s{{mulAdd(towards, ds, r.ray.x), r.ray.v},
           ds,
           r.plan >> kPlanShift,
           both(free, negate(fine)),
           (r.plan & I(kPlanLit)) != I(0),
           both(free, r.box <= F(kOnFace)),
           none,
           none};
    const M busy = both(alive, negate(free));
    M meets = both(free, s.optics != I(0)); // what is not the ambient medium
    if (any(busy)) bend(r, towards, voxel, busy, ds, meets, s);
    ReceiverHit<F> hit;
    if (mScene.receivers.any()) s.lands = meetReceivers(r, alive, hit, ds, s);
    r.depth = select(meets, smaller(r.depth, r.travelled), r.depth);
    const M moves = both(alive, negate(s.notFinite));
    const RayOf<F> before = r.ray;
    r.ray = {select<F>(moves, s.to.x, r.ray.x), select<F>(moves, s.to.v, r.ray.v)};
    const Vec3<F> transmitted = r.transmitted;
    M scatters = moves;
    // A ray that was sent back is outside already, whatever of the skin it still has to cross.
    if (mScene.rules.fresnel) scatters = both(moves, negate(r.mirrors.crossing.before < F(0)));
    if (mMedium.attenuates) scatter(r, before.x, s, scatters);
    if (mScene.rules.fresnel)
      reflect(r, watchStep(r.mirrors.crossing, before, r.ray, s.length, transmitted, both(moves, negate(s.lands))));
    r.travelled = r.travelled + ds;
    if (any(s.lands)) {
      receive(mScene, r, hit, s.lands);
      r.depth = select(s.lands, smaller(r.depth, r.travelled), r.depth);
    }
    r.steps = select(alive, r.steps + I(1), r.steps);
    return s;
  }

  /// Ends steps at the receivers that they meet. \return the rays that do
  VOLCAUSTIC_HD M meetReceivers(const ViewRay<F>& r, const M& alive, ReceiverHit<F>& hit, F& ds, Step& s) const {
    const Vec3<F> chord = s.to.x - r.ray.x;
    const F squared = dot(chord, chord), inverse = inverseRoot(larger(squared, F(1e-20f))), way = squared * inverse;
    hit = nearestHit<F>(mScene.receivers, r.ray.x, chord * inverse, F(-kReceiverOverlap), way,
                        both(alive, negate(s.notFinite)), true);
    const M lands = found(hit);
    if (!any(lands)) return lands;
    const F part = select(lands, hit.distance * inverse, F(1));
    s.to.x = select<F>(lands, mulAdd(chord, part, r.ray.x), s.to.x);
    s.length = s.length * part;
    ds = ds * part;
    return lands;
  }

  /// Splits rays at surfaces: the ray goes on with what is not reflected. Two reflected rays wait; of more, the weakest
  /// see the background only.
  VOLCAUSTIC_HD void reflect(ViewRay<F>& r, const Reflection<F>& reflection) const {
    if (!any(reflection.on)) return;
    const F share = select(reflection.on, reflection.share, F(0));
    WaitingRay<F> next{reflection.to, reflection.light * share, reflection.rise};
    r.transmitted = r.transmitted * (F(1) - share);
    r.mirrors.crossing.light = r.mirrors.crossing.light * (F(1) - share); // of one that began in the same step
    for (WaitingRay<F>& w : r.mirrors.waiting) {
      const M stronger = maxComponent(next.share) > larger(maxComponent(w.share), F(1 / 512.0f));
      const WaitingRay<F> weaker = w;
      w.ray = {select<F>(stronger, next.ray.x, w.ray.x), select<F>(stronger, next.ray.v, w.ray.v)};
      w.share = select<F>(stronger, next.share, w.share);
      w.rise = select(stronger, next.rise, w.rise);
      next.ray = {select<F>(stronger, weaker.ray.x, next.ray.x), select<F>(stronger, weaker.ray.v, next.ray.v)};
      next.share = select<F>(stronger, weaker.share, next.share);
      next.rise = select(stronger, weaker.rise, next.rise);
    }
    seeBackground(mScene, r, next.ray.v, next.share, maxComponent(next.share) > F(0));
  }

  /// Lets reflected rays that wait take the place of those that have come to their end. \return where there are any
  VOLCAUSTIC_HD M reflectWaiting(ViewRay<F>& r, const M& ended) const {
    WaitingRay<F>& next = r.mirrors.waiting[0];
    const M again = both(ended, maxComponent(next.share) > F(0));
    if (!any(again)) return again;
    arrive(mScene, r, again);
    const Vec3<F> dark(F(0));
    r.ray = {select<F>(again, next.ray.x, r.ray.x), select<F>(again, next.ray.v, r.ray.v)};
    r.transmitted = select<F>(again, next.share, r.transmitted);
    r.clear = select(again, F(0), r.clear);
    r.plan = select(again, I(0), r.plan);
    r.travelled = select(again, F(3.0e38f), r.travelled); // what a reflection shows is not the picture's depth
    SurfaceCrossing<F>& c = r.mirrors.crossing;
    c.before = select(again, F(-1), c.before);
    c.rise = select(again, F(0) - next.rise, c.rise);
    WaitingRay<F>& last = r.mirrors.waiting[1];
    next.ray = {select<F>(again, last.ray.x, next.ray.x), select<F>(again, last.ray.v, next.ray.v)};
    next.share = select<F>(again, last.share, next.share);
    next.rise = select(again, last.rise, next.rise);
    last.share = select<F>(again, dark, last.share);
    return again;
  }

  /// Finds the way ahead through bricks that are not busy, for rays that have come to the end of what they know.
  /// `voxel` holds the middle of a step: a brick is looked at once that is in it, so that no step ends short for a last
  /// bit of the brick before. \return the rays that go straight on
  VOLCAUSTIC_HD M lookAhead(ViewRay<F>& r, const Vec3<F>& towards, const Vec3<I>& voxel, const M& alive) const {
    const M near = both(alive, r.clear <= F(0.5f * mScene.rules.step));
    if (any(near)) {
      const I there = gather(mScene.plan.bricks, mMedium.brickIndex(voxel));
      M straight = both(near, (there & I(kPlanBusy)) == I(0));
      r.clear = select(near, F(0), r.clear);
      r.plan = select(near, there, r.plan);
      if (any(straight)) {
        const I here = gather(mMedium.fieldSlots, mMedium.brickIndex(mMedium.voxelOf(r.ray.x)));
        straight = both(straight, here == I(0));
        const F box = mScene.plan.box.exit(r.ray.x, towards);
        const F ahead = smaller(distanceToCubeFace(r.ray.x, towards, voxel, I(3)), box);
        r.box = select(straight, box, r.box);
        r.clear = select(straight, larger(ahead, F(kOnFace)), r.clear);
      }
    }
    return both(alive, r.clear > F(0));
  }

  /// The step of rays that may bend, or meet other optics.
  VOLCAUSTIC_HD void bend(ViewRay<F>& r, const Vec3<F>& towards, const Vec3<I>& voxel, const M& busy, F& ds, M& meets,
                          Step& s) const {
    const ViewRules& rules = mScene.rules;
    // The last step before a busy brick may begin in one that is not, and leave it for one that is not.
    const M inside = both(busy, (r.plan & I(kPlanBusy)) != I(0));
    const I slot = select(inside, r.plan >> kPlanShift, I(0));
    const I word = gather(mScene.plan.voxels, (slot << 9) + FlatMedium::voxelOffset(voxel));
    const M bends = both(inside, (word & I(kStepBendsBit)) != I(0));
    meets = either(meets, bends);
    s.optics = select(inside, word >> 8, s.optics);
    F length(rules.step);
    const M cubes = both(inside, negate(bends));
    if (!mFog && any(cubes))
      length = select(cubes, stepLength(mMedium, rules.march, r.ray.x, towards, voxel, word), length);
    RayOf<F> to = advance(mMedium, rules.march, r.ray, length);
    const M out = both(busy, beyondBox(mMedium.dims, to.x) > F(0));
    if (any(out)) {
      const StepResult<F> within = advanceInBox(mMedium, rules.march, r.ray, towards, length);
      to = {select<F>(out, within.ray.x, to.x), select<F>(out, within.ray.v, to.v)};
      length = select(out, within.ds, length);
      s.leaves = either(s.leaves, both(out, within.leaves));
    }
    ds = select(busy, length, ds);
    // Not a number compares false with everything; so does infinity with the bound.
    const Vec3<F> chord = to.x - r.ray.x;
    const F squared = dot(chord, chord);
    const M finite = both(squared < F(1e30f), dot(to.v, to.v) < F(1e30f));
    s.notFinite = both(busy, negate(finite));
    const M straight = both(both(to.v.x == r.ray.v.x, to.v.y == r.ray.v.y), to.v.z == r.ray.v.z);
    const F way = select(straight, length, squared * inverseRoot(larger(squared, F(1e-30f))));
    s.length = select(busy, select(finite, way, F(0)), s.length);
    s.to = {select<F>(busy, to.x, s.to.x), select<F>(busy, to.v, s.to.v)};
    s.lit = either(s.lit, inside);
  }

  /// Looks the optics of a way up, where they are not as before.
  VOLCAUSTIC_HD void meet(ViewRay<F>& r, const I& optics, const M& on) const {
    const M other = both(on, optics != r.optics);
    if (!any(other)) return;
    const I at = select(other, optics, I(0)) * I(kOpticsFloats);
    r.attenuation = select<F>(other, gatherRgb<F>(&mMedium.optics->attenuation.x, at), r.attenuation);
    r.scattering = select<F>(other, gatherRgb<F>(&mMedium.optics->scattering.x, at), r.scattering);
    if (directed()) r.asymmetry = select(other, gather(&mMedium.optics->asymmetry, at), r.asymmetry);
    r.optics = select(other, optics, r.optics);
  }
  [[nodiscard]] VOLCAUSTIC_HD bool directed() const { return mScene.light.towards.entries != nullptr; }

  /// Adds what the way from `from` to the ray's position scatters towards the camera, and attenuates.
  VOLCAUSTIC_HD void scatter(ViewRay<F>& r, const Vec3<F>& from, const Step& s, const M& on) const {
    meet(r, s.optics, on);
    const Vec3<F> depth = r.attenuation * s.length, mean = meanTransmittance(depth);
    const M scatters = both(both(on, s.lit), maxComponent(r.scattering) > F(0));
    if (any(scatters)) {
      const Vec3<F> way = r.ray.x - from, power = r.transmitted * r.scattering * s.length;
      const M twice = both(scatters, s.strides);
      if (!any(twice)) {
        gatherLight(r, mulAdd(way, F(0.5f), from), power * mean, scatters);
      } else {
        // Gauss's two points: of fourth order where a step of one voxel, taken at its middle, is of second.
        constexpr float kFirst = 0.21132487f, kSecond = 1 - kFirst;
        const auto weight = [&](float at) {
          const Vec3<F> before = depth * F(at);
          return power * (Vec3<F>(F(1)) - before * meanTransmittance(before)) * F(0.5f);
        };
        gatherLight(r, mulAdd(way, select(twice, F(kFirst), F(0.5f)), from),
                    select<F>(twice, weight(kFirst), power * mean), scatters);
        gatherLight(r, mulAdd(way, F(kSecond), from), weight(kSecond), twice);
      }
    }
    r.transmitted = select<F>(on, r.transmitted * (Vec3<F>(F(1)) - depth * mean), r.transmitted);
  }

  /// `weight` is what a unit of radiance scattered all along the way contributes.
  VOLCAUSTIC_HD void gatherLight(ViewRay<F>& r, const Vec3<F>& p, const Vec3<F>& weight, const M& on) const {
    const bool leans = directed() && any(both(on, negate(r.asymmetry == F(0))));
    const ViewLightSample<F> light = mScene.light.sample<F>(p, on, leans);
    // L/n^2 is what a ray conserves: light scattered at index n arrives multiplied by (n_camera/n)^2; |v| is n.
    const Vec3<F>& v = r.ray.v;
    const F inverse = inverseRoot(dot(v, v));
    F phase(1 / (4 * 3.14159265f));
    if (leans) {
      const LightOf<F> all{light.direct + light.caustic, light.towards};
      const F leaning = effectivePhase(all.meanDirection(), v * (F(0) - inverse), r.asymmetry);
      phase = select(r.asymmetry == F(0), phase, leaning);
    }
    const F index = F(mScene.rules.cameraIndex) * inverse;
    const Vec3<F> scattered = weight * select(on, phase * index * index, F(0));
    r.direct += scattered * light.direct;
    r.caustic += scattered * light.caustic;
  }

  static constexpr float kOnFace = 1e-3f; ///< voxels: this close to a face ahead is on it

  const ViewScene& mScene;
  const FlatMedium& mMedium;
  bool mFog; ///< whether the ambient medium scatters
};

/// The rays through the points (column, row) of the raster, for the lanes `on`; those that meet the box in `hits`. What
/// is between the camera and the box has been looked at.
template <class F>
VOLCAUSTIC_HD inline ViewRay<F> lookThrough(const ViewScene& scene, const DoubleOf<F>& column, const DoubleOf<F>& row,
                                            const MaskOf<F>& on, MaskOf<F>& hits) {
  const CameraRay<F> start = scene.camera.ray<F>(scene.plan.box, column, row);
  hits = both(on, start.hits);
  const Float3 eye(scene.camera.origin);
  ViewRay<F> r;
  r.ray = {{F(eye.x), F(eye.y), F(eye.z)}, start.direction};
  if (scene.receivers.any()) {
    const ReceiverHit<F> hit = nearestHit<F>(scene.receivers, r.ray.x, r.ray.v, F(0), start.distance, hits, true);
    const MaskOf<F> lands = found(hit);
    if (any(lands)) receive(scene, r, hit, lands);
    r.depth = select(lands, hit.distance, r.depth);
    hits = both(hits, negate(lands));
  }
  r.ray.x = select<F>(hits, start.start, r.ray.x);
  r.travelled = select(hits, start.distance, F(0));
  if (any(hits)) r.ray.v = select<F>(hits, r.ray.v * sampleField(scene.medium, r.ray.x).n, r.ray.v);
  return r;
}

/// What rays have seen, with all that is behind those that have come to their ends; of the others it means nothing.
template <class F>
VOLCAUSTIC_HD inline PixelSumOf<F> seen(const ViewScene& scene, ViewRay<F>& r, const MaskOf<F>& ended) {
  arrive(scene, r, ended);
  PixelSumOf<F> sum;
  sum.caustic = r.caustic;
  sum.direct = r.direct;
  sum.background = r.background;
  sum.receiver = r.receiver;
  sum.transmittance = r.through;
  sum.depth = r.depth;
  sum.steps = toFloat(r.steps);
  return sum;
}

/// Some samples of one pixel for one call: a GPU's thread, and the reference on the CPU.
template <class Sink>
struct ViewBody {
  ViewScene scene;
  PixelPlanes planes;
  std::int32_t firstSample, endSample;

  VOLCAUSTIC_HD void operator()(std::int64_t pixel, Sink& sink) const {
    const auto column = static_cast<std::int32_t>(pixel % scene.camera.width),
               row = static_cast<std::int32_t>(pixel / scene.camera.width);
    for (std::int32_t s = firstSample; s < endSample; ++s) {
      const PixelSampler::Point at = scene.sampler.point(column, row, s);
      bool hits = false;
      ViewRay<float> r = lookThrough<float>(scene, at.column, at.row, true, hits);
      RayEnd<float> end{false, false};
      ViewMarch<float>(scene).run(r, hits, end, [](bool) { return true; });
      sink.count(Counter::Steps, r.steps);
      if (end.notFinite) sink.count(Counter::NotFinite, 1);
      if (end.stepLimit) sink.count(Counter::StepLimit, 1);
      float values[kPixelPlanes];
      planes.forEach<float>(seen(scene, r, true), [&](int plane, float v) { values[plane] = v; });
      planes.add(pixel, 1, s, [&](int plane) { return values + plane; });
    }
  }
};

} // namespace volcaustic::kernels
