// Points by the hundred, evaluated by the program of the block that they are in.
#pragma once

#include "mesh/vector.h"
#include "shapes/program.h"

#include <cmath>
#include <cstdint>
#include <vector>

namespace volcaustic {

inline Vec3d along(const Vec3d& p, const Vec3d& direction, double by) {
  return {p[0] + by * direction[0], p[1] + by * direction[1], p[2] + by * direction[2]};
}
inline Vec3d between(const Vec3d& a, const Vec3d& b) { return along(a, difference(b, a), .5); }
inline double length(const Vec3d& v) { return std::sqrt(dot(v, v)); }

/// Three arrays, as programs take them.
struct PointArrays {
  std::vector<double> x, y, z;

  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] Vec3d at(std::size_t i) const { return {x[i], y[i], z[i]}; }
  void add(const Vec3d& p) {
    x.push_back(p[0]);
    y.push_back(p[1]);
    z.push_back(p[2]);
  }
  void resize(std::size_t size) {
    x.resize(size);
    y.resize(size);
    z.resize(size);
  }
  void set(std::size_t i, const Vec3d& p) {
    x[i] = p[0];
    y[i] = p[1];
    z[i] = p[2];
  }
  void clear() {
    x.clear();
    y.clear();
    z.clear();
  }
};

/// What the function is like at a point, to first order.
struct Tangent {
  Vec3d normal;    ///< along the gradient, of length one; zero where the function has no direction
  double distance; ///< of the point from the surface, positive inside
  double slope;    ///< length of the gradient
};

struct ValueArrays {
  std::vector<double> value;
  PointArrays gradient;

  [[nodiscard]] Tangent tangent(std::size_t i) const {
    const Vec3d g = gradient.at(i);
    const double slope = length(g);
    if (!(slope > 0) || !std::isfinite(slope) || !std::isfinite(value[i])) return {{0, 0, 0}, 0, 0};
    return {{g[0] / slope, g[1] / slope, g[2] / slope}, value[i] / slope, slope};
  }
};

/// Evaluates lists of points of any length and counts them. For one thread.
class PointEvaluator {
public:
  PointEvaluator(const ShapeProgram& program, ShapeScratch& scratch) : mProgram(program), mScratch(scratch) {}

  void values(const PointArrays& points, std::vector<double>& values);
  void gradients(const PointArrays& points, ValueArrays& values);
  void parts(const PointArrays& points, std::vector<std::uint32_t>& parts);
  [[nodiscard]] std::uint64_t count() const { return mCount; }

private:
  const ShapeProgram& mProgram;
  ShapeScratch& mScratch;
  std::uint64_t mCount = 0;
};

} // namespace volcaustic
