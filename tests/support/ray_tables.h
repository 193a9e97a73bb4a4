// The rays of the reference tables: where they start, and how far from the tables' exits they end.
#pragma once

#include "support/csv.h"
#include "support/fields.h"
#include "volcaustic/photons.h"

#include <cmath>
#include <vector>

namespace volcaustic::test {

/// Angle between two directions, degrees. Accurate for small angles too.
inline double angleBetween(const Vec3d& a, const Vec3d& b) {
  const double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const double sine = std::hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
  return std::atan2(sine, cosine) * 180 / 3.14159265358979323846;
}

/// The starts of a table's rays. Those that end inside the unit cube stop at the table's length.
inline std::vector<TracedRay> startsOf(const Table& t) {
  std::vector<TracedRay> rays;
  for (std::size_t i = 0; i < t.at("ray").size(); ++i) {
    TracedRay r;
    r.position = {t.at("x0")[i], t.at("y0")[i], t.at("z0")[i]};
    r.direction = {t.at("dx0")[i], t.at("dy0")[i], t.at("dz0")[i]};
    const double inside = 1e-6;
    bool endsInside = true;
    for (const char* c : {"x1", "y1", "z1"}) endsInside = endsInside && t.at(c)[i] > inside && t.at(c)[i] < 1 - inside;
    if (endsInside) r.length = t.at("length")[i];
    rays.push_back(r);
  }
  return rays;
}

/// How far a traced ray ended from its table's exit.
struct ExitError {
  double position = 0;  ///< voxels
  double direction = 0; ///< degrees
  double momentum = 0;  ///< |v| - n
};

inline std::vector<ExitError> exitErrors(const Table& t, const std::vector<TracedRay>& rays, const IndexField& n,
                                         int resolution) {
  std::vector<ExitError> errors;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const TracedRay& r = rays[i];
    errors.push_back({distanceTo(r.position, t.at("x1")[i], t.at("y1")[i], t.at("z1")[i]) * resolution,
                      angleBetween({t.at("dx1")[i], t.at("dy1")[i], t.at("dz1")[i]}, r.direction),
                      r.opticalMomentum - n(r.position)});
  }
  return errors;
}

inline ExitError rootMeanSquare(const std::vector<ExitError>& errors) {
  ExitError sum;
  for (const ExitError& e : errors)
    sum = {sum.position + e.position * e.position, sum.direction + e.direction * e.direction,
           sum.momentum + e.momentum * e.momentum};
  const double count = static_cast<double>(errors.size());
  return {std::sqrt(sum.position / count), std::sqrt(sum.direction / count), std::sqrt(sum.momentum / count)};
}

} // namespace volcaustic::test
