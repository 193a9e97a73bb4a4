// One photon from its first bend to its end, written over lanes.
#pragma once

#include "kernels/emission.h"
#include "kernels/fresnel.h"
#include "kernels/receivers.h"
#include "kernels/slab.h"

namespace volcaustic::kernels {

struct PhotonRules {
  MarchRules march;
  std::int32_t maxSteps = 20000;
  float cutoff = 1e-4f;
  bool roulette = false;
  std::uint64_t seed = 0;
  bool fresnel = false;    ///< photons may be reflected where the index changes within a few voxels (fresnel.h)
  ReceiverScene receivers; ///< on which photons end
};

template <class F>
VOLCAUSTIC_HD inline Vec3<F> decay(const Vec3<F>& t) {
  return {exponential(-t.x), exponential(-t.y), exponential(-t.z)};
}
/// (1 - e)/t, the mean of exp(-s) over [0, t], given e = exp(-t). By its series where 1 - e would lose digits.
template <class F>
VOLCAUSTIC_HD inline F meanDecay(F t, F e) {
  const F series = F(1) - t * (F(0.5f) - t * F(1 / 6.0f));
  return select(t < F(1e-2f), series, (F(1) - e) * reciprocal(larger(t, F(1e-2f))));
}
template <class F>
VOLCAUSTIC_HD inline Vec3<F> meanDecay(const Vec3<F>& t, const Vec3<F>& e) {
  return {meanDecay(t.x, e.x), meanDecay(t.y, e.y), meanDecay(t.z, e.z)};
}

/// A photon on its way.
template <class F>
struct PhotonOf {
  RayOf<F> ray;
  Vec3<F> power;     ///< W
  Vec3<F> scattered; ///< lost to scattering so far, W
  F threshold;       ///< of luminance, below which the photon ends
  IntOf<F> steps;
  Vec3<F> from;    ///< where its last deposit ended: from there on it has gone straight, through one kind of matter
  IntOf<F> optics; ///< that matter's entry in FlatMedium::optics
};
using Photon = PhotonOf<float>;

/// What follows a photon through surfaces that reflect.
template <class F>
struct PhotonMirror {
  SurfaceCrossing<F> crossing;
  Vec3<F> scatteredBefore{F(0), F(0), F(0)}; ///< PhotonOf::scattered where the crossing began

  template <class Visit>
  VOLCAUSTIC_HD void forEach(const Visit& visit) {
    crossing.forEach(visit);
    visit(scatteredBefore.x), visit(scatteredBefore.y), visit(scatteredBefore.z);
  }
};
inline constexpr int kPhotonMirrorNumbers = kSurfaceCrossingNumbers + 3;

/// A straight piece of a photon's way. At the distance s from its start the photon has the power
/// power + slope (s - length/2): what exp(-attenuation s) is to second order, and in total exactly.
template <class F>
struct ChordOf {
  Vec3<F> start, direction; ///< direction is a unit vector
  F length;
  Vec3<F> power; ///< mean over the length, W
  Vec3<F> slope; ///< W/voxel
};

/// What a step did to a photon.
template <class F>
struct StepOutcome {
  MaskOf<F> leaves;    ///< is on a face of the box, about to leave
  MaskOf<F> notFinite; ///< has left the finite numbers and stays where it was
  MaskOf<F> fades;     ///< is below its threshold
  MaskOf<F> limit;     ///< has taken the last step that it may
  MaskOf<F> lands;     ///< is on a receiver
  ReceiverHit<F> hit;  ///< of those that land
  Reflection<F> reflection;
};

/// Attenuation and scattering, gathered.
template <class F>
VOLCAUSTIC_HD inline Vec3<F> gatherRgb(const float* base, const IntOf<F>& index) {
  return {gather(base, index), gather(base + 1, index), gather(base + 2, index)};
}

/// A way of greater optical depth is deposited in equal parts: a part's power is right in total, and inside it to one
/// part in a thousand (depth^2/12).
inline constexpr float kPartDepth = 0.1f;
inline constexpr std::int32_t kMostParts = 256;

/// Emits the chord a, a + length * direction of a photon with the power `first` at a through deposit(ChordOf<F>,
/// MaskOf<F>), in parts; returns the power at its end.
template <class F, class Deposit>
VOLCAUSTIC_HD inline Vec3<F> depositDecaying(const Vec3<F>& a, const Vec3<F>& direction, F length, const Vec3<F>& first,
                                             const Vec3<F>& attenuation, const MaskOf<F>& active,
                                             const Deposit& deposit) {
  using I = IntOf<F>;
  const F depth = maxComponent(attenuation) * length;
  const I parts = toInt(smaller(depth * F(1 / kPartDepth), F(float(kMostParts - 1)))) + I(1);
  const F part = length * reciprocal(toFloat(parts));
  const Vec3<F> t = attenuation * part, e = decay(t), mean = meanDecay(t, e);
  Vec3<F> left = first;
  for (I i(0);; i = i + I(1)) {
    const MaskOf<F> on = both(active, i < parts);
    if (!any(on)) break;
    const Vec3<F> power = left * mean;
    deposit(ChordOf<F>{mulAdd(direction, part * toFloat(i), a), direction, part, power, -(power * attenuation)}, on);
    left = select<F>(i < parts, left * e, left);
  }
  return left;
}

/// Deposits the straight way from photon.from to `to` for the lanes `on`, attenuates, and sets photon.from to `to`.
template <class F, class Deposit>
VOLCAUSTIC_HD inline void depositWay(const FlatMedium& m, PhotonOf<F>& photon, const Vec3<F>& to, const MaskOf<F>& on,
                                     const Deposit& deposit) {
  const Vec3<F> way = to - photon.from;
  const F squared = dot(way, way);
  const MaskOf<F> moved = both(on, squared > F(0));
  const F inverse = inverseRoot(select(squared > F(0), squared, F(1)));
  const Vec3<F> direction = way * inverse, from = photon.from;
  const F length = squared * inverse;
  photon.from = select<F>(on, to, photon.from);
  if (!m.attenuates) {
    deposit(ChordOf<F>{from, direction, length, photon.power, Vec3<F>(F(0))}, moved);
    return;
  }
  const IntOf<F> at = photon.optics * IntOf<F>(kOpticsFloats);
  const Vec3<F> attenuation = gatherRgb<F>(&m.optics->attenuation.x, at);
  const Vec3<F> scattering = gatherRgb<F>(&m.optics->scattering.x, at);
  const Vec3<F> left = depositDecaying(from, direction, length, photon.power, attenuation, moved, deposit);
  const auto albedo = [](F s, F t) { return select(t > F(0), s * reciprocal(select(t > F(0), t, F(1))), F(0)); };
  const Vec3<F> lost = photon.power - left;
  const Vec3<F> scattered{lost.x * albedo(scattering.x, attenuation.x), lost.y * albedo(scattering.y, attenuation.y),
                          lost.z * albedo(scattering.z, attenuation.z)};
  photon.scattered = select<F>(moved, photon.scattered + scattered, photon.scattered);
  photon.power = select<F>(moved, left, photon.power);
}

/// Notes where on a receiver's map a photon's power lands; the back of a receiver takes it and has no map.
VOLCAUSTIC_HD inline void land(const ReceiverScene& receivers, const ReceiverHit<float>& hit, const Photon& photon,
                               Landing* landing) {
  if (!landing || !meetsFront<float>(receivers, hit, photon.ray.v, true)) return;
  const TexelPoint<float> at = texelOf<float>(receivers, hit);
  *landing = {at.column, at.row, hit.triangle, {photon.power.x, photon.power.y, photon.power.z}};
}

/// Ends steps at the receivers that they meet.
template <class F>
VOLCAUSTIC_HD inline void landOnStep(const ReceiverScene& receivers, const Vec3<F>& from, const Vec3<F>& chord,
                                     const MaskOf<F>& on, StepResult<F>& step, StepOutcome<F>& outcome) {
  const F squared = dot(chord, chord), inverse = inverseRoot(larger(squared, F(1e-20f)));
  outcome.hit = nearestHit<F>(receivers, from, chord * inverse, F(-kReceiverOverlap), squared * inverse, on);
  outcome.lands = found(outcome.hit);
  if (any(outcome.lands))
    step.ray.x = select<F>(outcome.lands, mulAdd(chord, inverse * outcome.hit.distance, from), step.ray.x);
}

/// One step of a photon: advance, and deposit where its way is no longer straight or ends. `active` lanes count; the
/// others must hold a finite photon. `mirror` is null where nothing reflects.
template <class F, class Deposit>
VOLCAUSTIC_HD inline StepOutcome<F> stepPhoton(const FlatMedium& m, const PhotonRules& rules, PhotonOf<F>& photon,
                                               PhotonMirror<F>* mirror, const MaskOf<F>& active,
                                               const Deposit& deposit) {
  using M = MaskOf<F>;
  const RayOf<F> old = photon.ray;
  const Vec3<IntOf<F>> voxel = m.voxelOf(old.x);
  const Vec3<F> towards = old.v * inverseRoot(dot(old.v, old.v));
  const F ds = stepLength(m, rules.march, old.x, towards, voxel, m.stepAt(voxel));
  StepResult<F> step = advanceInBox(m, rules.march, old, towards, ds);
  photon.steps = photon.steps + IntOf<F>(1);
  StepOutcome<F> outcome;

  // Not a number compares false with everything; so does infinity with the upper bound.
  const Vec3<F> chord = step.ray.x - old.x;
  const F momentum = dot(step.ray.v, step.ray.v);
  const M finite = both(both(dot(chord, chord) < F(1e30f), momentum < F(1e30f)), momentum > F(0));
  outcome.notFinite = negate(finite);
  outcome.limit = photon.steps > IntOf<F>(rules.maxSteps - 1);
  outcome.lands = both(finite, outcome.notFinite); // none
  if (rules.receivers.any()) landOnStep(rules.receivers, old.x, chord, both(active, finite), step, outcome);
  outcome.leaves = both(both(finite, step.leaves), negate(outcome.lands));
  const M bends = negate(both(both(step.ray.v.x == old.v.x, step.ray.v.y == old.v.y), step.ray.v.z == old.v.z));

  // A way that bends here, or comes into other matter, has been straight up to the last point.
  IntOf<F> optics = photon.optics;
  if (m.attenuates) optics = m.opticsIndex(m.voxelOf(select<F>(finite, (old.x + step.ray.x) * F(0.5f), old.x)));
  const M other = optics != photon.optics;
  const M breaks = both(active, either(either(bends, other), outcome.notFinite));
  if (any(breaks)) {
    const Vec3<F> way = old.x - photon.from;
    const M pending = both(breaks, dot(way, way) > F(0));
    if (any(pending)) depositWay(m, photon, old.x, pending, deposit);
    photon.optics = optics;
  }
  const Vec3<F> before = photon.power, scatteredBefore = photon.scattered;
  photon.ray = {select<F>(finite, step.ray.x, old.x), select<F>(finite, step.ray.v, old.v)};
  const M ends = both(both(active, finite), either(either(bends, outcome.lands), either(step.leaves, outcome.limit)));
  if (any(ends)) depositWay(m, photon, photon.ray.x, ends, deposit);
  outcome.fades = luminance(photon.power) < photon.threshold;
  outcome.reflection.on = outcome.lands;
  if (mirror) {
    SurfaceCrossing<F>& crossing = mirror->crossing;
    const M watched = both(both(active, finite), negate(either(outcome.lands, outcome.leaves)));
    const F began = crossing.rise;
    outcome.reflection = watchStep(crossing, old, photon.ray, step.ds, before, watched);
    mirror->scatteredBefore = select<F>(crossing.rise == began, mirror->scatteredBefore, scatteredBefore);
    // The light that a surface takes may still be reflected.
    outcome.fades = both(outcome.fades, negate(crossing.before > F(0)));
  }
  return outcome;
}

/// Sends a photon back whose crossing has come to its end, by the chance that reflection has; the power of a photon
/// stays whole, so what is reflected and what goes on sum up to it on the average. \return whether it was sent back
VOLCAUSTIC_HD inline bool reflectByChance(const FlatMedium& m, const PhotonRules& rules, std::uint64_t id,
                                          const Reflection<float>& r, Photon& photon, PhotonMirror<float>& mirror) {
  constexpr std::uint64_t kStream = 1u << 31; // apart from the numbers of roulette
  if (uniform(rules.seed, id, static_cast<std::uint64_t>(photon.steps) + kStream) >= static_cast<double>(r.share))
    return false;
  photon.ray = r.to;
  photon.from = r.to.x;
  photon.power = r.light;
  photon.scattered = mirror.scatteredBefore;
  photon.optics = m.attenuates ? m.opticsIndex(m.voxelOf(r.to.x)) : 0;
  mirror.crossing = sentBack(r);
  return true;
}

/// Where a photon that leaves the box lands beyond it; Escaped if nowhere.
VOLCAUSTIC_HD inline Outcome landBeyond(const PhotonRules& rules, const Photon& photon, Landing* landing) {
  if (!rules.receivers.any()) return Outcome::Escaped;
  const Float3 towards = photon.ray.v * inverseRoot(dot(photon.ray.v, photon.ray.v));
  const ReceiverHit<float> hit =
      nearestHit<float>(rules.receivers, photon.ray.x, towards, -kReceiverOverlap, 3.0e38f, true);
  if (!found(hit)) return Outcome::Escaped;
  land(rules.receivers, hit, photon, landing);
  return Outcome::Received;
}

/// Below the threshold: true ends the photon. Roulette lets one in ten live with ten times its power; `gained` collects
/// what it is given.
VOLCAUSTIC_HD inline bool endsByRoulette(const PhotonRules& rules, std::uint64_t id, Photon& photon, Double3& gained) {
  if (!rules.roulette) return true;
  constexpr float kSurvival = 0.1f;
  if (uniform(rules.seed, id, static_cast<std::uint64_t>(photon.steps) + 2) >= kSurvival) return true;
  const Float3 gain = photon.power * (1 / kSurvival - 1);
  gained += Double3(gain);
  photon.power += gain;
  return false;
}

/// The photon of a raster cell at its first bend.
VOLCAUSTIC_HD inline Photon startPhoton(const FlatMedium& m, const EmissionFrame& frame, const PhotonRules& rules,
                                        std::int64_t cell, float entry) {
  const EmissionRay start = frame.ray(cell);
  const double t = entry + frame.depth0;
  Photon photon;
  photon.ray = {clampToBox(m.dims, Float3(start.origin + start.direction * t)), Float3(start.direction)};
  photon.ray.v *= sampleField(m, photon.ray.x).n;
  Double3 power = frame.power(cell);
  if (m.attenuates) {
    const Span span = clipToBox(m.dims, start.origin, start.direction);
    const double t0 = frame.point ? larger(span.entry, 0.0) : span.entry;
    power = power * transmittance(m.optics[0], larger(t - t0, 0.0));
  }
  photon.power = Float3(power);
  photon.scattered = Float3(0, 0, 0);
  photon.threshold = rules.cutoff * luminance(photon.power);
  photon.steps = 0;
  photon.from = photon.ray.x;
  photon.optics = m.attenuates ? m.opticsIndex(m.voxelOf(photon.ray.x)) : 0;
  return photon;
}

/// Books a photon that has come to its end. `first` is the power that it started with, `gained` what roulette gave it.
template <class Sink>
VOLCAUSTIC_HD inline void bookEnd(Sink& sink, Outcome end, const Photon& photon, const Float3& first,
                                  const Double3& gained) {
  const Double3 left(photon.power), scattered(photon.scattered), lost = Double3(first) + gained - left;
  sink.tally(end, left);
  sink.tally(Outcome::CutOff, -gained);
  sink.tally(Outcome::Scattered, scattered);
  sink.tally(Outcome::Absorbed, lost - scattered);
  sink.tally(Outcome::TracedLoss, lost);
  sink.count(Counter::Steps, photon.steps);
}

/// Adds a chord's light to every voxel that it crosses.
template <class Sink>
VOLCAUSTIC_HD inline void depositChord(Sink& sink, const FlatMedium& m, const ChordOf<float>& chord) {
  std::int64_t crossed = 0;
  const auto add = [&](const auto& voxel) {
    if (!(voxel.length > 0)) return;
    const Float3 w = (chord.power + chord.slope * (voxel.middle - 0.5f * chord.length)) * voxel.length;
    sink.deposit(voxel.at.brick, voxel.at.offset, w, chord.direction * luminance(w));
    ++crossed;
  };
  const SlabChord<float, BrickCells> slabs({m.dims, m.brickDims}, chord.start, chord.direction, chord.length);
  for (std::int32_t k = 0; k < slabs.slabs(); ++k) {
    const auto c = slabs.crossing(k);
    add(c.first);
    add(c.second);
    add(c.third);
  }
  sink.count(Counter::VoxelsCrossed, crossed);
}

/// Carries the photon of raster cell cells[i] from its first bend until it leaves the box, fades or reaches the step
/// limit. One photon for one call: a GPU's thread, and the reference on the CPU.
template <class Sink>
struct PhotonBody {
  FlatMedium medium;
  EmissionFrame frame;
  const float* entry;         ///< of EmissionBody
  const std::uint32_t* cells; ///< those with a bend
  PhotonRules rules;
  Landing* landings; ///< of the raster's cells from landingsFrom on; null where there are no receivers
  std::int64_t landingsFrom;

  VOLCAUSTIC_HD void operator()(std::int64_t i, Sink& sink) const {
    const std::int64_t cell = cells[i];
    Photon photon = startPhoton(medium, frame, rules, cell, entry[cell]);
    const Float3 first = photon.power;
    Double3 gained(0, 0, 0);
    Landing* const landing = landings ? landings + (cell - landingsFrom) : nullptr;
    PhotonMirror<float> mirror;
    Outcome end = Outcome::CutOff;
    while (true) {
      const StepOutcome<float> step = stepPhoton(medium, rules, photon, rules.fresnel ? &mirror : nullptr, true,
                                                 [&](const ChordOf<float>& chord, bool on) {
                                                   if (on) depositChord(sink, medium, chord);
                                                 });
      if (step.notFinite) {
        sink.count(Counter::NotFinite, 1);
        break;
      }
      if (step.lands) {
        land(rules.receivers, step.hit, photon, landing);
        end = Outcome::Received;
        break;
      }
      if (step.leaves) {
        end = landBeyond(rules, photon, landing);
        break;
      }
      if (step.reflection.on)
        reflectByChance(medium, rules, static_cast<std::uint64_t>(cell), step.reflection, photon, mirror);
      if (step.fades && endsByRoulette(rules, static_cast<std::uint64_t>(cell), photon, gained)) break;
      if (step.limit) {
        sink.count(Counter::StepLimit, 1);
        break;
      }
    }
    bookEnd(sink, end, photon, first, gained);
  }
};

} // namespace volcaustic::kernels
