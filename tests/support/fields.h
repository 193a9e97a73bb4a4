// Index fields in closed form, as in the tables of reference/ (unit cube), and media that sample them.
#pragma once

#include "volcaustic/medium.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>

namespace volcaustic::test {

using IndexField = std::function<double(const Vec3d&)>;

inline double distanceTo(const Vec3d& p, double x, double y, double z) {
  return std::hypot(p[0] - x, p[1] - y, p[2] - z);
}

/// 6u^5 - 15u^4 + 10u^3: from 0 to 1 with two continuous derivatives.
inline double smootherStep(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * u * (u * (6 * u - 15) + 10);
}

/// By the name of the table analytic_NAME.csv.
inline IndexField indexField(const std::string& name) {
  const double pi = 3.14159265358979323846;
  static const std::map<std::string, IndexField> fields{
      {"luneburg",
       [](const Vec3d& p) {
         const double r = distanceTo(p, .5, .5, .5) / .4;
         return r < 1 ? std::sqrt(2 - r * r) : 1.0;
       }},
      {"maxwell_fisheye", [](const Vec3d& p) { return 2 / (1 + std::pow(distanceTo(p, .5, .5, .5) / .25, 2)); }},
      {"linear", [](const Vec3d& p) { return 1 + .5 * p[2]; }},
      {"linear_n2", [](const Vec3d& p) { return std::sqrt(1.2 + .8 * p[2]); }},
      {"slab", [](const Vec3d& p) { return 1 + .5 * smootherStep((.6 - p[2]) / .2); }},
      // Real only near the axis; the rays stay there, and beyond it any smooth continuation will do.
      {"fibre",
       [pi](const Vec3d& p) {
         const double rho = std::hypot(p[1] - .5, p[2] - .5);
         return std::sqrt(std::max(2.25 * (1 - std::pow(4 * pi * rho, 2)), .25));
       }},
      {"mirage_exp", [](const Vec3d& p) { return 1.02 - .02 * std::exp(-p[2] / .05); }},
      {"mirage_linear", [](const Vec3d& p) { return 1 + .02 * p[2]; }},
      {"smooth_sphere", [](const Vec3d& p) { return 1 + .5 * smootherStep((.31 - distanceTo(p, .5, .5, .65)) / .02); }},
  };
  return fields.at(name);
}

/// The unit cube at a resolution.
inline Domain unitCube(int resolution) { return {{0, 0, 0}, 1.0 / resolution, {resolution, resolution, resolution}}; }

} // namespace volcaustic::test
