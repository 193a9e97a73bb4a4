// Lights of tests: colours that tell the channels apart.
#pragma once

#include "volcaustic/photons.h"

namespace volcaustic::test {

inline Light sun(const Vec3d& direction, const Rgb& irradiance = {1, 2, .5}) {
  Light light;
  light.direction = direction;
  light.irradiance = irradiance;
  return light;
}
inline Light lamp(const Vec3d& position, const Rgb& intensity = {100, 50, 200}) {
  Light light;
  light.type = LightType::Point;
  light.position = position;
  light.intensity = intensity;
  return light;
}
inline Light spot(const Vec3d& position, const Vec3d& axis, double inner, double outer,
                  const Rgb& intensity = {100, 50, 200}) {
  Light light = lamp(position, intensity);
  light.type = LightType::Spot;
  light.direction = axis;
  light.innerAngle = inner;
  light.outerAngle = outer;
  return light;
}
inline Light areaLight(const Vec3d& position, const Vec3d& direction, double width, double height,
                       const Rgb& intensity = {100, 50, 200}) {
  Light light = lamp(position, intensity);
  light.type = LightType::Area;
  light.direction = direction;
  light.width = width;
  light.height = height;
  return light;
}

} // namespace volcaustic::test
