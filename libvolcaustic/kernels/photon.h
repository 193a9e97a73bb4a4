// One photon from its first bend to its end.
#pragma once

#include "kernels/emission.h"

namespace volcaustic::kernels {

struct PhotonRules {
  MarchRules march;
  std::int32_t maxSteps = 20000;
  float cutoff = 1e-4f;
  bool roulette = false;
  std::uint64_t seed = 0;
};

/// (1 - exp(-t))/t, the mean of exp(-s) over [0, t].
VOLCAUSTIC_HD inline float meanDecay(float t) { return t < 1e-4f ? 1 - 0.5f * t : -std::expm1(-t) / t; }
VOLCAUSTIC_HD inline Float3 meanDecay(const Float3& t) { return {meanDecay(t.x), meanDecay(t.y), meanDecay(t.z)}; }
VOLCAUSTIC_HD inline Float3 decay(const Float3& t) { return {std::exp(-t.x), std::exp(-t.y), std::exp(-t.z)}; }

/// Deposits power * length, decaying by `attenuation`, into every voxel that the chord from a to b crosses.
template <class Sink>
VOLCAUSTIC_HD inline void depositChord(Sink& sink, const Int3& dims, const Float3& a, const Float3& b,
                                       const Float3& power, const Float3& attenuation) {
  const Float3 chord = b - a;
  const float len = length(chord);
  if (!(len > 0)) return;
  const Float3 direction = chord * (1 / len);
  // Below this optical depth the decay inside the chord is under a thousandth, and its mean is exact for the total.
  constexpr float kThin = 2e-3f;
  const bool thin = maxComponent(attenuation) * len < kThin;
  const Float3 mean = power * meanDecay(attenuation * len);
  std::int64_t crossed = 0;
  traverse(a, direction, 0.0f, len, dims, 0, [&](const Int3& voxel, float in, float out) {
    const float ell = out - in;
    const Float3 w = thin ? mean * ell : power * decay(attenuation * in) * meanDecay(attenuation * ell) * ell;
    sink.deposit(voxel, w, direction * luminance(w));
    ++crossed;
    return true;
  });
  sink.count(Counter::VoxelsCrossed, crossed);
}

/// Carries the photon of raster cell cells[i] from its first bend until it leaves the box, fades or reaches the step
/// limit.
template <class Sink>
struct PhotonBody {
  FlatMedium medium;
  EmissionFrame frame;
  const float* entry;         ///< of EmissionBody
  const std::uint32_t* cells; ///< those with a bend
  PhotonRules rules;

  VOLCAUSTIC_HD void operator()(std::int64_t i, Sink& sink) const {
    const std::int64_t cell = cells[i];
    const EmissionRay start = frame.ray(cell);
    const double t = entry[cell] + frame.depth0;
    const Span span = clipToBox(medium.dims, start.origin, start.direction);
    const double t0 = frame.point ? larger(span.entry, 0.0) : span.entry;

    Ray ray{clampToBox(Float3(start.origin + start.direction * t)), Float3(start.direction)};
    ray.v *= sampleField(medium, ray.x).n;
    Float3 power(frame.power(cell) * transmittance(medium.optics[0], larger(t - t0, 0.0)));
    march(ray, power, static_cast<std::uint64_t>(cell), sink);
  }

private:
  VOLCAUSTIC_HD Float3 clampToBox(const Float3& p) const {
    return {clampTo(p.x, 0.0f, static_cast<float>(medium.dims.x)),
            clampTo(p.y, 0.0f, static_cast<float>(medium.dims.y)),
            clampTo(p.z, 0.0f, static_cast<float>(medium.dims.z))};
  }

  VOLCAUSTIC_HD void march(Ray ray, Float3 power, std::uint64_t id, Sink& sink) const {
    const float threshold = rules.cutoff * luminance(power);
    std::int32_t steps = 0;
    Outcome end = Outcome::CutOff;
    while (true) {
      if (steps == rules.maxSteps) {
        sink.count(Counter::StepLimit, 1);
        break;
      }
      const Int3 voxel = medium.voxelOf(ray.x);
      const Float3 direction = normalize(ray.v);
      const float ds = stepLength(medium, rules.march, ray.x, direction, voxel, medium.stepAt(voxel));
      const StepResult step = advanceInBox(medium, rules.march, ray, ds);
      ++steps;
      const Float3 next = step.ray.x;
      if (!std::isfinite(next.x + next.y + next.z) || !(dot(step.ray.v, step.ray.v) > 0)) {
        sink.count(Counter::NotFinite, 1);
        break;
      }
      power = attenuate(ray.x, next, power, sink);
      ray = step.ray;
      if (step.leaves) {
        end = Outcome::Escaped;
        break;
      }
      if (luminance(power) < threshold && fades(power, id, steps, sink)) break;
    }
    sink.tally(end, Double3(power));
    sink.count(Counter::Steps, steps);
  }

  /// Deposits along the chord and returns the power that is left at its end.
  VOLCAUSTIC_HD Float3 attenuate(const Float3& a, const Float3& b, const Float3& power, Sink& sink) const {
    const Optics& optics = medium.opticsAt(medium.voxelOf((a + b) * 0.5f));
    depositChord(sink, medium.dims, a, b, power, optics.attenuation);
    if (!(maxComponent(optics.attenuation) > 0)) return power;
    const Float3 left = power * decay(optics.attenuation * length(b - a));
    const Double3 loss = Double3(power) - Double3(left);
    tallyLoss(sink, optics, loss);
    sink.tally(Outcome::TracedLoss, loss);
    return left;
  }

  /// Below the threshold: true ends the photon. Roulette lets one in ten live with ten times its power.
  VOLCAUSTIC_HD bool fades(Float3& power, std::uint64_t id, std::int32_t steps, Sink& sink) const {
    if (!rules.roulette) return true;
    constexpr float kSurvival = 0.1f;
    if (uniform(rules.seed, id, static_cast<std::uint64_t>(steps) + 2) >= kSurvival) return true;
    const Float3 gained = power * (1 / kSurvival - 1);
    sink.tally(Outcome::CutOff, -Double3(gained));
    power += gained;
    return false;
  }
};

} // namespace volcaustic::kernels
