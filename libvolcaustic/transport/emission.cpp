#include "transport/emission.h"

#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace volcaustic {

namespace {

using kernels::cross;
using kernels::dot;
using kernels::Double3;
using kernels::EmissionFrame;
using kernels::length;
using kernels::normalize;

Double3 toDouble3(const Vec3d& v) { return {v[0], v[1], v[2]}; }

bool allFinite(const Vec3d& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

void checkPower(const Light& light, int number, const Rgb& power, const char* what) {
  for (const double c : power)
    if (!std::isfinite(c) || c < 0) refuseLight(light, number, std::string(what) + " must be finite and not negative");
}

/// Two unit vectors across w. An axis-aligned w gets the other two axes, so that cells line up with voxels.
void buildFrame(EmissionFrame& f, const Double3& w) {
  const Double3 size{std::abs(w.x), std::abs(w.y), std::abs(w.z)};
  const Double3 across = size.x <= size.y && size.x <= size.z ? Double3(1, 0, 0)
                         : size.y <= size.z                   ? Double3(0, 1, 0)
                                                              : Double3(0, 0, 1);
  f.axisW = w;
  f.axisU = normalize(cross(across, w));
  f.axisV = cross(w, f.axisU);
}

/// Calls visit with each corner of the box.
template <class Visit>
void forCorners(const Domain& domain, const Visit& visit) {
  for (int i = 0; i < 8; ++i)
    visit(Double3(i & 1 ? domain.dims[0] : 0, i & 2 ? domain.dims[1] : 0, i & 4 ? domain.dims[2] : 0));
}

struct Bounds2 {
  double u0 = 1e300, u1 = -1e300, v0 = 1e300, v1 = -1e300;
  void add(double u, double v) {
    u0 = std::min(u0, u);
    u1 = std::max(u1, u);
    v0 = std::min(v0, v);
    v1 = std::max(v1, v);
  }
};

/// The frame with a raster over the bounds, or none where they are empty.
std::vector<EmissionFrame> withRaster(EmissionFrame f, const Bounds2& b, int columns, int rows) {
  if (!(b.u1 > b.u0 && b.v1 > b.v0)) return {};
  f.columns = columns;
  f.rows = rows;
  f.u0 = b.u0;
  f.v0 = b.v0;
  f.du = (b.u1 - b.u0) / columns;
  f.dv = (b.v1 - b.v0) / rows;
  return {f};
}

std::vector<EmissionFrame> parallelFrames(const Light& light, int number, const Domain& domain,
                                          const PhotonOptions& options) {
  const Double3 d = toDouble3(light.direction);
  if (!allFinite(light.direction) || !(dot(d, d) > 0))
    refuseLight(light, number, "direction must be finite and not zero");
  checkPower(light, number, light.irradiance, "irradiance");

  EmissionFrame f;
  buildFrame(f, normalize(d));
  Bounds2 bounds;
  double nearest = 1e300;
  forCorners(domain, [&](const Double3& corner) {
    bounds.add(dot(corner, f.axisU), dot(corner, f.axisV));
    nearest = std::min(nearest, dot(corner, f.axisW));
  });
  f.origin = f.axisW * nearest; // the plane that touches the box
  std::vector<EmissionFrame> frames = withRaster(f, bounds, options.grid[0], options.grid[1]);
  for (EmissionFrame& frame : frames)
    frame.strength = Double3(light.irradiance[0], light.irradiance[1], light.irradiance[2]) *
                     (frame.du * frame.dv * domain.voxelSize * domain.voxelSize);
  return frames;
}

constexpr double kDegree = 3.14159265358979323846 / 180;

/// Whether it shines around an axis: a spot, or a piece of an area light (soft_lights.h).
bool hasAxis(const Light& light) { return light.type == LightType::Spot || light.type == LightType::Area; }

void checkCone(const Light& light, int number) {
  if (!hasAxis(light)) return;
  if (!allFinite(light.direction) || !(length(toDouble3(light.direction)) > 0))
    refuseLight(light, number, "direction must be finite and not zero");
  if (!(light.outerAngle > 0 && light.outerAngle <= 90))
    refuseLight(light, number, "outerAngle must be above 0 and at most 90 degrees");
  if (!(light.innerAngle >= 0 && light.innerAngle <= light.outerAngle))
    refuseLight(light, number, "innerAngle must be at least 0 and at most outerAngle");
}

/// The bounds where a cone's rectangle around it on the tangent plane lies inside them; empty where nothing does.
Bounds2 clippedToCone(Bounds2 bounds, const EmissionFrame& f, const Light& light) {
  if (!hasAxis(light)) return bounds;
  const Double3 axis = normalize(toDouble3(light.direction));
  const double sine = std::sin(light.outerAngle * kDegree), along = dot(axis, f.axisW);
  // Planes through the light that touch the cone: (across - k along)^2 = (1 + k^2) sine^2, where all of it is in front.
  const auto clip = [&](const Double3& side, double& low, double& high) {
    const double across = dot(axis, side), denominator = along * along - sine * sine;
    const double root = sine * std::sqrt(std::max(across * across + denominator, 0.0));
    if (!(along > 0 && denominator > 1e-9)) return;
    low = std::max(low, (across * along - root) / denominator);
    high = std::min(high, (across * along + root) / denominator);
  };
  clip(f.axisU, bounds.u0, bounds.u1);
  clip(f.axisV, bounds.v0, bounds.v1);
  return bounds;
}

/// Whether all of a cone is behind a light's tangent plane.
bool isBehind(const EmissionFrame& f, const Light& light) {
  return hasAxis(light) && dot(normalize(toDouble3(light.direction)), f.axisW) < -std::sin(light.outerAngle * kDegree);
}

EmissionFrame pointFrame(const Double3& position, const Double3& w, const Light& light) {
  EmissionFrame f;
  f.point = true;
  f.cone = coneOf(light);
  f.origin = position;
  f.strength = {light.intensity[0], light.intensity[1], light.intensity[2]};
  buildFrame(f, w);
  return f;
}

std::vector<EmissionFrame> pointFrames(const Light& light, int number, const Domain& domain,
                                       const PhotonOptions& options) {
  if (!allFinite(light.position)) refuseLight(light, number, "position must be finite");
  checkPower(light, number, light.intensity, "intensity");
  checkCone(light, number);
  const Double3 position = toGrid(domain, light.position);
  const Double3 dims(domain.dims[0], domain.dims[1], domain.dims[2]);
  const Double3 towards = dims * 0.5 - position;

  // One tangent plane serves when every corner lies within 60 degrees of the axis.
  constexpr double kWidest = 1.7320508;
  if (dot(towards, towards) > 0) {
    EmissionFrame f = pointFrame(position, normalize(towards), light);
    Bounds2 bounds;
    bool fits = true;
    forCorners(domain, [&](const Double3& corner) {
      const Double3 r = corner - position;
      const double w = dot(r, f.axisW);
      if (w > 0) bounds.add(dot(r, f.axisU) / w, dot(r, f.axisV) / w);
      fits = fits && w > 0;
    });
    if (fits && std::max({-bounds.u0, bounds.u1, -bounds.v0, bounds.v1}) < kWidest) {
      const kernels::Int3 box{domain.dims[0], domain.dims[1], domain.dims[2]};
      if (isBehind(f, light)) return {};
      f.depth0 = std::max(0.0, kernels::clipToBox(box, position, f.axisW).entry);
      return withRaster(f, clippedToCone(bounds, f, light), options.grid[0], options.grid[1]);
    }
  }
  // As many photons in all, shared between the six faces of a cube around the light.
  std::vector<EmissionFrame> frames;
  const double share = 1 / std::sqrt(6.0);
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      EmissionFrame f = pointFrame(position, {axis == 0 ? sign : 0, axis == 1 ? sign : 0, axis == 2 ? sign : 0}, light);
      f.cubeFace = true;
      if (isBehind(f, light)) continue;
      for (const EmissionFrame& face :
           withRaster(f, clippedToCone({-1, 1, -1, 1}, f, light), std::max(1, int(std::ceil(options.grid[0] * share))),
                      std::max(1, int(std::ceil(options.grid[1] * share)))))
        frames.push_back(face);
    }
  return frames;
}

} // namespace

void refuseLight(const Light& light, int number, const std::string& what) {
  const std::string name = light.name.empty() ? "" : " (" + light.name + ")";
  throw Error(ErrorKind::Usage, "lights[" + std::to_string(number) + "]" + name + ": " + what);
}

kernels::Cone coneOf(const Light& light) {
  if (!hasAxis(light)) return {};
  const double inner = std::cos(light.innerAngle * kDegree), outer = std::cos(light.outerAngle * kDegree);
  const double scale = 1 / std::max(inner - outer, 1e-6); // an edge that single precision still resolves
  return {kernels::Float3(normalize(toDouble3(light.direction))), static_cast<float>(scale),
          static_cast<float>(-outer * scale), light.type == LightType::Area};
}

std::vector<EmissionFrame> emissionFrames(const Light& light, int number, const Domain& domain,
                                          const PhotonOptions& options, std::uint64_t seed) {
  std::vector<EmissionFrame> frames = light.type == LightType::Directional
                                          ? parallelFrames(light, number, domain, options)
                                          : pointFrames(light, number, domain, options);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].jitter = options.jitter;
    frames[i].seed = seed * 1000003u + static_cast<std::uint64_t>(number) * 8 + i;
  }
  return frames;
}

std::optional<RasterPlace> placeOnRaster(const EmissionFrame& frame, const Double3& p) {
  const Double3 r = p - frame.origin;
  const RasterPlace flat{dot(r, frame.axisU), dot(r, frame.axisV), dot(r, frame.axisW)};
  if (!frame.point) return flat;
  if (!(flat.depth > 0)) return std::nullopt;
  const double u = flat.u / flat.depth, v = flat.v / flat.depth;
  return RasterPlace{u, v, flat.depth * std::sqrt(1 + u * u + v * v)};
}

} // namespace volcaustic
