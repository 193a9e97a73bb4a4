// One pixel: curved rays from the camera through medium and light.
#pragma once

#include "kernels/emission.h"
#include "kernels/photon.h"
#include "kernels/sparse_field.h"

namespace volcaustic::kernels {

/// Henyey-Greenstein phase function, 1/sr.
VOLCAUSTIC_HD inline float henyeyGreenstein(float cosine, float g) {
  const float d = 1 + g * g - 2 * g * cosine;
  return (1 - g * g) / (4 * 3.14159265f * d * std::sqrt(larger(d, 1e-12f)));
}

/// Phase value for light of mean direction d (|d| <= 1) scattered into the unit direction `out`: asymmetry g|d| about
/// d/|d|, so light from everywhere scatters evenly and a beam scatters as a beam.
VOLCAUSTIC_HD inline float effectivePhase(const Float3& d, const Float3& out, float g) {
  const float spread = length(d);
  return henyeyGreenstein(spread > 0 ? dot(d, out) / spread : 0, g * smaller(spread, 0.999f));
}

/// A pinhole in grid space: the direction through the raster point (u, v) in [0, 1]^2, v down, is corner + u right + v
/// down.
struct CameraFrame {
  Double3 origin, corner, right, down;
  std::int32_t width = 0, height = 0;
  VOLCAUSTIC_HD Double3 direction(double u, double v) const { return normalize(corner + right * u + down * v); }
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

/// What a pixel is made of; radiance in W/(m2 sr), depth in voxels.
struct PixelSum {
  Float3 caustic{0, 0, 0}, direct{0, 0, 0}, background{0, 0, 0}, transmittance{0, 0, 0};
  float depth = 3.0e38f;
  float steps = 0;
};

template <class Sink>
struct ViewBody {
  FlatMedium medium;
  SparseField directLight, causticLight, direction;
  CameraFrame camera;
  ViewRules rules;
  PixelSum* pixels;

  VOLCAUSTIC_HD void operator()(std::int64_t i, Sink& sink) const {
    PixelSum sum;
    const double column = static_cast<double>(i % camera.width), row = static_cast<double>(i / camera.width);
    const std::int32_t n = rules.samples;
    for (std::int32_t s = 0; s < n * n; ++s) {
      const double u = (column + (s % n + 0.5) / n) / camera.width, v = (row + (s / n + 0.5) / n) / camera.height;
      gather(camera.direction(u, v), sum, sink);
    }
    const float weight = 1.0f / static_cast<float>(n * n);
    sum.caustic *= weight;
    sum.direct *= weight;
    sum.background *= weight;
    sum.transmittance *= weight;
    sum.steps *= weight;
    pixels[i] = sum;
  }

private:
  VOLCAUSTIC_HD void gather(const Double3& d, PixelSum& sum, Sink& sink) const {
    const Span span = clipToBox(medium.dims, camera.origin, d);
    const double t0 = larger(span.entry, 0.0);
    Float3 transmitted(1, 1, 1), leaving(d);
    if (span.exit > t0) {
      Ray ray{Float3(camera.origin + d * t0), Float3(d)};
      ray.v *= sampleField(medium, ray.x).n;
      transmitted = march(ray, static_cast<float>(t0), sum, sink);
      leaving = normalize(ray.v);
    }
    const float ratio = rules.cameraIndex / rules.ambientIndex;
    const float height = 0.5f + 0.5f * dot(leaving, rules.up);
    sum.background += transmitted * (rules.bottom + (rules.top - rules.bottom) * height) * (ratio * ratio);
    sum.transmittance += transmitted;
  }

  /// Gathers scattered light up to the box's face; returns the transmittance, and the ray as it leaves.
  VOLCAUSTIC_HD Float3 march(Ray& ray, float travelled, PixelSum& sum, Sink& sink) const {
    Float3 transmitted(1, 1, 1);
    std::int32_t steps = 0;
    for (;; ++steps) {
      if (steps == rules.maxSteps) {
        sink.count(Counter::StepLimit, 1);
        break;
      }
      const Int3 voxel = medium.voxelOf(ray.x);
      const std::int32_t step = medium.stepAt(voxel);
      const Float3 towards = normalize(ray.v);
      const bool bends = step & kStepBendsBit;
      if (bends) sum.depth = smaller(sum.depth, travelled);
      const bool fine = bends || maxComponent(medium.opticsAt(voxel).scattering) > 0;
      const float ds = fine ? rules.step : stepLength(medium, rules.march, ray.x, towards, voxel, step);
      const StepResult<float> next = advanceInBox(medium, rules.march, ray, towards, ds);
      if (!std::isfinite(next.ray.x.x + next.ray.x.y + next.ray.x.z)) {
        sink.count(Counter::NotFinite, 1);
        break;
      }
      scatter(ray.x, next.ray, transmitted, sum);
      ray = next.ray;
      travelled += next.ds;
      if (next.leaves || maxComponent(transmitted) < 1e-5f) break;
    }
    sum.steps += static_cast<float>(steps + 1);
    sink.count(Counter::Steps, steps + 1);
    return transmitted;
  }

  /// Adds what the segment from a to the ray's new position scatters towards the camera, and attenuates.
  VOLCAUSTIC_HD void scatter(const Float3& a, const Ray& b, Float3& transmitted, PixelSum& sum) const {
    const Float3 middle = (a + b.x) * 0.5f;
    const Optics& optics = medium.opticsAt(medium.voxelOf(middle));
    if (!(maxComponent(optics.attenuation) > 0)) return;
    const float ell = length(b.x - a);
    const Float3 depth = optics.attenuation * ell, kept = decay(depth);
    if (maxComponent(optics.scattering) > 0) {
      // L/n^2 is what a ray conserves: light scattered at index n arrives multiplied by (n_camera/n)^2; |v| is n.
      const float phase = effectivePhase(direction.sample(middle), -normalize(b.v), optics.asymmetry);
      const float scale = phase * ell * rules.cameraIndex * rules.cameraIndex / dot(b.v, b.v);
      const Float3 weight = transmitted * meanDecay(depth, kept) * optics.scattering * scale;
      sum.direct += weight * directLight.sample(middle);
      sum.caustic += weight * causticLight.sample(middle);
    }
    transmitted *= kept;
  }
};

} // namespace volcaustic::kernels
