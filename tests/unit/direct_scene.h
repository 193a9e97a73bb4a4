// Direct light by its definition: every ray of a light's rasters, voxel by voxel, in double precision.
#pragma once

#include "backends/photon_tracer.h"
#include "support/lights.h"
#include "support/traverse.h"
#include "transport/direct.h"
#include "transport/emission.h"
#include "transport/reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

namespace volcaustic::test {

using kernels::Double3;
using kernels::EmissionFrame;
using kernels::Float3;
using kernels::Int3;

struct Box {
  Vec3d low, high;
};

/// Lights over boxes of glass, with the rasters and what they met.
struct DirectScene {
  Domain domain;
  Ambient ambient;
  FlatMediumStorage flat;
  std::vector<Light> lights;
  struct Raster {
    int light;
    EmissionFrame frame;
    std::vector<float> entry;
  };
  std::vector<Raster> rasters;

  DirectScene(const Vec3i& dims, const std::vector<Box>& boxes, std::vector<Light> lights_, int grid = 300,
              const Rgb& fog = {0, 0, 0}, bool jitter = false)
      : domain{{0, 0, 0}, 1, dims}
      , ambient(ambientOf(fog))
      , flat(flattenMedium(mediumOf(boxes), {}, {}))
      , lights(std::move(lights_)) {
    PhotonOptions options;
    options.grid = {grid, grid};
    options.jitter = jitter;
    const auto tracer = makeCpuTracer({flat.view(), {}, {1, 1}}, {}, "scalar");
    for (int i = 0; i < static_cast<int>(lights.size()); ++i)
      for (const EmissionFrame& frame : emissionFrames(lights[i], i, domain, options, 3)) {
        Raster& raster = rasters.emplace_back(Raster{i, frame, std::vector<float>(frame.cells())});
        tracer->emit(frame, reachOf(flat, frame).view(), {0, frame.rows}, raster.entry.data());
      }
  }

  [[nodiscard]] std::unique_ptr<DirectLight> direct(bool smooth, const RunContext& ctx = {}) const {
    DirectLightBuilder builder(flat, domain, partsOf(lights), ctx);
    for (const Raster& r : rasters) builder.add(r.light, r.frame, r.entry);
    auto light = std::make_unique<DirectLight>(domain.dims);
    builder.finish(smooth, *light);
    return light;
  }

  [[nodiscard]] std::size_t number(const Int3& v) const {
    return (std::size_t(v.x) * flat.dims.y + v.y) * flat.dims.z + v.z;
  }
  template <class Visit>
  void forVoxels(const Visit& visit) const {
    for (int x = 0; x < flat.dims.x; ++x)
      for (int y = 0; y < flat.dims.y; ++y)
        for (int z = 0; z < flat.dims.z; ++z) visit(Int3(x, y, z));
  }

private:
  static Ambient ambientOf(const Rgb& fog) {
    Ambient a;
    a.attenuation = fog;
    return a;
  }
  [[nodiscard]] Medium mediumOf(const std::vector<Box>& boxes) const {
    return sampleMedium(domain, ambient, [&](const Vec3d& p) {
      for (const Box& b : boxes) {
        bool inside = true;
        for (int a = 0; a < 3; ++a) inside = inside && p[a] > b.low[a] && p[a] < b.high[a];
        if (inside) return 1.4;
      }
      return 1.0;
    });
  }
};

using Value = std::array<double, 6>; // fluence, then its luminance times its direction
using Values = std::vector<Value>;

/// A light that nothing stands in the way of.
inline Value openLight(const DirectScene& scene, const Light& light, const Int3& v) {
  const Double3 p = Double3(v) + Double3(.5);
  const bool point = light.type == LightType::Point;
  const Double3 r = p - Double3(light.position[0], light.position[1], light.position[2]);
  if (point && kernels::dot(r, r) == 0) {
    const Rgb& i = light.intensity; // from its own middle a lamp shines nowhere
    return {4 * i[0], 4 * i[1], 4 * i[2], 0, 0, 0};
  }
  const Double3 d = kernels::normalize(point ? r : Double3(light.direction[0], light.direction[1], light.direction[2]));
  const kernels::Span span = kernels::clipToBox(scene.flat.dims, p, -d);
  const double way = point ? std::min(span.exit, kernels::length(r)) : span.exit;
  double f[3];
  for (int c = 0; c < 3; ++c)
    f[c] = (point ? light.intensity[c] / std::max(kernels::dot(r, r), .25) : light.irradiance[c]) *
           std::exp(-scene.ambient.attenuation[c] * way);
  const double l = kernels::luminance(Double3(f[0], f[1], f[2]));
  return {f[0], f[1], f[2], d.x * l, d.y * l, d.z * l};
}

/// The part of each voxel that this face of a cube around a lamp sees: of 4x4x4 places, those whose way from the lamp
/// is longest along its axis.
inline double seenByFace(const EmissionFrame& frame, const Int3& v) {
  int seen = 0;
  for (int i = 0; i < 64; ++i) {
    const Double3 r = Double3(v) + Double3((i & 3) + .5, (i >> 2 & 3) + .5, (i >> 4) + .5) * .25 - frame.origin;
    int axis = 0;
    for (int a = 1; a < 3; ++a)
      if (std::abs(r[a]) > std::abs(r[axis])) axis = a;
    seen += frame.axisW[axis] * r[axis] > 0;
  }
  return seen / 64.0;
}

/// What a raster lights: over the rays that cross a voxel, the length before their first bends over all of it. A voxel
/// without a ray takes the ray of its middle.
inline std::vector<double> litParts(const DirectScene& scene, const DirectScene::Raster& raster) {
  const EmissionFrame& frame = raster.frame;
  std::vector<double> all(scene.number({scene.flat.dims.x, 0, 0})), lit = all;
  for (std::int64_t cell = 0; cell < frame.cells(); ++cell) {
    const kernels::EmissionRay ray = frame.ray(cell);
    const kernels::Span span = kernels::clipToBox(scene.flat.dims, ray.origin, ray.direction);
    const double from = frame.point ? std::max(span.entry, 0.0) : span.entry;
    if (!(span.exit > from)) continue;
    const double bend = raster.entry[cell] == kernels::kNeverBends ? 1e300 : raster.entry[cell] + frame.depth0;
    traverse(ray.origin, ray.direction, from, span.exit, scene.flat.dims, 0, [&](const Int3& v, double in, double out) {
      all[scene.number(v)] += out - in;
      lit[scene.number(v)] += std::clamp(bend - in, 0.0, out - in);
      return true;
    });
  }
  scene.forVoxels([&](const Int3& v) {
    const std::size_t n = scene.number(v);
    if (all[n] > 0) {
      lit[n] /= all[n];
    } else {
      const Double3 r = Double3(v) + Double3(.5) - frame.origin;
      const double w = frame.point ? kernels::dot(r, frame.axisW) : 1;
      const double column = (kernels::dot(r, frame.axisU) / w - frame.u0) / frame.du,
                   row = (kernels::dot(r, frame.axisV) / w - frame.v0) / frame.dv;
      if (w <= 0 || column < 0 || row < 0 || column >= frame.columns || row >= frame.rows) return;
      const double depth = frame.point ? kernels::length(r) : kernels::dot(r, frame.axisW);
      lit[n] = raster.entry[static_cast<std::int64_t>(row) * frame.columns + static_cast<std::int64_t>(column)] >=
               depth - frame.depth0;
    }
    if (frame.cubeFace) lit[n] *= seenByFace(frame, v);
  });
  return lit;
}

inline Values bruteForce(const DirectScene& scene) {
  Values values(scene.number({scene.flat.dims.x, 0, 0}), Value{});
  for (const DirectScene::Raster& raster : scene.rasters) {
    const std::vector<double> parts = litParts(scene, raster);
    scene.forVoxels([&](const Int3& v) {
      const Value open = openLight(scene, scene.lights[raster.light], v);
      for (int i = 0; i < 6; ++i) values[scene.number(v)][i] += parts[scene.number(v)] * open[i];
    });
  }
  return values;
}

/// The 3x3x3 Gaussian; values before the domain's faces stand beyond them.
inline Values gaussian(const DirectScene& scene, Values values) {
  for (int axis = 0; axis < 3; ++axis) {
    const Values before = values;
    scene.forVoxels([&](const Int3& v) {
      int low[3] = {v.x, v.y, v.z}, high[3] = {v.x, v.y, v.z};
      low[axis] = std::max(low[axis] - 1, 0);
      high[axis] = std::min(high[axis] + 1, scene.flat.dims[axis] - 1);
      const Value &a = before[scene.number({low[0], low[1], low[2]})], &b = before[scene.number(v)],
                  &c = before[scene.number({high[0], high[1], high[2]})];
      for (int i = 0; i < 6; ++i) values[scene.number(v)][i] = (a[i] + 2 * b[i] + c[i]) / 4;
    });
  }
  return values;
}

/// How much the Gaussian may change the lights of a voxel that no shadow's edge is near, W/m2: a lamp's by its
/// curvature over a voxel, and at the domain's faces, beyond which it does not rise, by a fourth of its slope; fog's
/// likewise.
inline double changeByGaussian(const DirectScene& scene, const Int3& v) {
  double change = 0;
  for (const Light& light : scene.lights) {
    const Value open = openLight(scene, light, v);
    const double most = std::max({open[0], open[1], open[2]});
    const double r =
        std::hypot(v.x + .5 - light.position[0], v.y + .5 - light.position[1], v.z + .5 - light.position[2]);
    change += 1e-5 * most;
    if (light.type == LightType::Point) change += (.9 / r + .6 / (r * r)) * most;
    if (scene.flat.attenuates) change += .05 * most;
  }
  return change;
}

} // namespace volcaustic::test
