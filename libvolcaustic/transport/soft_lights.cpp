#include "transport/soft_lights.h"

#include "kernels/vec.h"
#include "transport/emission.h"
#include "transport/environment.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

using kernels::cross;
using kernels::dot;
using kernels::Double3;
using kernels::normalize;

constexpr double kPi = 3.14159265358979323846;

Vec3d toVec3d(const Double3& v) { return {v.x, v.y, v.z}; }
Double3 toDouble3(const Vec3d& v) { return {v[0], v[1], v[2]}; }

/// Part `i` of `count` directions of a disc of the given angular diameter, evenly by solid angle: a sunflower (Vogel
/// 1979).
Vec3d directionOf(const Light& light, int i, int count) {
  const Double3 axis = normalize(toDouble3(light.direction));
  const Double3 side = std::abs(axis.x) < 0.6 ? Double3(1, 0, 0) : Double3(0, 1, 0);
  const Double3 u = normalize(cross(side, axis)), v = cross(axis, u);
  const double share = (i + 0.5) / count, golden = kPi * (3 - std::sqrt(5.0));
  const double cosine = 1 - share * (1 - std::cos(0.5 * light.angle * kPi / 180)),
               sine = std::sqrt(1 - cosine * cosine);
  return toVec3d(axis * cosine + u * (sine * std::cos(i * golden)) + v * (sine * std::sin(i * golden)));
}

/// The share of a ball's light within sin(psi) of its radius is (psi - sin psi cos psi) / (pi/2); its inverse.
double polarOf(double share) {
  double low = 0, high = 0.5 * kPi;
  for (int i = 0; i < 50; ++i) {
    const double psi = 0.5 * (low + high);
    (psi - std::sin(psi) * std::cos(psi) < 0.5 * kPi * share ? low : high) = psi;
  }
  return 0.5 * (low + high);
}

/// Part `i` of the points of a ball. Emitters that shine alike in all directions, with a density of
/// 1 / sqrt(R^2 - r^2), look like an evenly bright disc from every side: that density, summed along a chord, is pi
/// whatever the chord. Their places follow the additive recurrence of the plastic-number family in three dimensions
/// (Roberts 2018), which fills space evenly for any number of them.
Vec3d placeOf(const Light& light, int i) {
  constexpr double kRatio = 1.2207440846057596; // x^4 = x + 1
  const auto fraction = [i](double step) {
    const double t = 0.5 + (i + 1) * step;
    return t - std::floor(t);
  };
  const double r = light.radius * std::sin(polarOf(fraction(1 / kRatio)));
  const double z = 2 * fraction(1 / (kRatio * kRatio)) - 1, phi = 2 * kPi * fraction(1 / (kRatio * kRatio * kRatio));
  const double across = std::sqrt(1 - z * z);
  return {light.position[0] + r * across * std::cos(phi), light.position[1] + r * across * std::sin(phi),
          light.position[2] + r * z};
}

/// Part `i` of `count` points of an area light, evenly: of its ellipse a sunflower, of its rectangle the additive
/// recurrence of Roberts (2018) in two dimensions.
Vec3d placeOnArea(const Light& light, int i, int count) {
  constexpr double kRatio = 1.3247179572447460; // x^3 = x + 1
  double x, y;                                  // of half a side
  if (light.round) {
    const double r = std::sqrt((i + 0.5) / count), phi = i * kPi * (3 - std::sqrt(5.0));
    x = r * std::cos(phi), y = r * std::sin(phi);
  } else {
    const auto place = [i](double step) {
      const double t = 0.5 + i * step;
      return 2 * (t - std::floor(t)) - 1;
    };
    x = place(1 / kRatio), y = place(1 / (kRatio * kRatio));
  }
  const Double3 axis = normalize(toDouble3(light.direction)), along = toDouble3(light.across);
  const Double3 u = normalize(along - axis * dot(along, axis)), v = cross(axis, u);
  return toVec3d(toDouble3(light.position) + u * (0.5 * light.width * x) + v * (0.5 * light.height * y));
}

void checkArea(const Light& light, int number) {
  if (!(light.width >= 0 && light.height >= 0 && std::isfinite(light.width) && std::isfinite(light.height)))
    refuseLight(light, number, "width and height must be finite and not negative");
  const Double3 axis = toDouble3(light.direction), along = toDouble3(light.across), normal = cross(axis, along);
  const double most = std::sqrt(dot(axis, axis) * dot(along, along));
  if (!(std::isfinite(most) && std::sqrt(dot(normal, normal)) > 1e-6 * most))
    refuseLight(light, number, "direction and across must be finite, not zero, and not on one line");
}

void check(const Light& light, int number) {
  if (!(light.angle >= 0 && light.angle <= 90)) refuseLight(light, number, "angle must be in 0 to 90 degrees");
  if (!(light.radius >= 0) || !std::isfinite(light.radius))
    refuseLight(light, number, "radius must be finite and not negative");
  if (light.samples < 0 || light.samples > kMostLightSamples)
    refuseLight(light, number, "samples must be in 0 to " + std::to_string(kMostLightSamples));
  if (!(light.scale[0] >= 0 && light.scale[1] >= 0 && light.scale[2] >= 0))
    refuseLight(light, number, "scale must not be negative");
  if (light.type == LightType::Area) checkArea(light, number);
}

constexpr int kUsualSamples = 16, kUsualEnvironmentSamples = 64;

void addEnvironment(const Light& light, int number, const RunContext& ctx, std::vector<LightPart>& parts) {
  const kernels::Environment environment =
      environmentOf(light.environment, "lights[" + std::to_string(number) + "]: environment");
  const std::vector<EnvironmentPart> suns =
      environmentParts(environment, light.samples > 0 ? light.samples : kUsualEnvironmentSamples, ctx);
  const auto luminanceOf = [](const EnvironmentPart& sun) { return kernels::luminance(toDouble3(sun.irradiance)); };
  double all = 0;
  for (const EnvironmentPart& sun : suns) all += luminanceOf(sun);
  for (int i = 0; i < static_cast<int>(suns.size()); ++i) {
    const double even = 1.0 / static_cast<double>(suns.size());
    LightPart part{{}, number, i, all > 0 ? 0.5 * even + 0.5 * luminanceOf(suns[i]) / all : even};
    part.light.name = light.name;
    for (int c = 0; c < 3; ++c) {
      part.light.direction[c] = -suns[i].from[c];
      part.light.irradiance[c] = suns[i].irradiance[c] * light.scale[c];
    }
    parts.push_back(std::move(part));
  }
}

} // namespace

std::vector<LightPart> partsOf(std::span<const Light> lights, const RunContext& ctx) {
  std::vector<LightPart> parts;
  for (int n = 0; n < static_cast<int>(lights.size()); ++n) {
    const Light& light = lights[n];
    check(light, n);
    if (light.type == LightType::Environment) {
      addEnvironment(light, n, ctx, parts);
      continue;
    }
    const bool sky = light.type == LightType::Directional, area = light.type == LightType::Area;
    const bool soft = sky ? light.angle > 0 : area ? light.width > 0 || light.height > 0 : light.radius > 0;
    const int count = !soft ? 1 : light.samples > 0 ? light.samples : kUsualSamples;
    for (int i = 0; i < count; ++i) {
      LightPart part{light, n, i, 1.0 / count};
      part.light.angle = part.light.radius = 0;
      for (double& c : part.light.irradiance) c /= count;
      for (double& c : part.light.intensity) c /= count;
      if (soft && sky) part.light.direction = directionOf(light, i, count);
      if (soft && !sky) part.light.position = area ? placeOnArea(light, i, count) : placeOf(light, i);
      if (area) part.light.innerAngle = 0, part.light.outerAngle = 90;
      parts.push_back(std::move(part));
    }
  }
  return parts;
}

} // namespace volcaustic
