// What tests of shapes share: points, boxes and evaluation at many of them.
#pragma once

#include "shapes/function.h"
#include "volcaustic/types.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace volcaustic::test {

/// The same numbers whatever the standard library.
class Random {
public:
  explicit Random(unsigned seed) : mEngine(seed) {}
  double between(double low, double high) { return low + (high - low) * (mEngine() * 0x1p-32); }
  int below(int count) { return static_cast<int>(mEngine() % static_cast<unsigned>(count)); }
  bool chance(double p) { return between(0, 1) < p; }
  Vec3d point(const Box& box) {
    Vec3d p;
    for (int a = 0; a < 3; ++a) p[a] = between(box.min[a], box.max[a]);
    return p;
  }
  /// From tiny to as large as `space`, with its middle in there.
  Box box(const Box& space) {
    const Vec3d middle = point(space);
    const double size = std::pow(10, between(-4, 0)) * (space.max[0] - space.min[0]);
    Box box;
    for (int a = 0; a < 3; ++a) {
      const double half = .5 * size * (chance(.1) ? 0 : between(.2, 1));
      box.min[a] = middle[a] - half;
      box.max[a] = middle[a] + half;
    }
    return box;
  }
  /// In the box, some of them its corners.
  std::vector<Vec3d> points(const Box& box, int count) {
    std::vector<Vec3d> points;
    for (int i = 0; i < count; ++i) points.push_back(point(box));
    for (int i = 0; i < std::min(count, 8); ++i)
      for (int a = 0; a < 3; ++a) points[i][a] = i >> a & 1 ? box.max[a] : box.min[a];
    return points;
  }

private:
  std::mt19937 mEngine;
};

inline Box cube(double half) { return {{-half, -half, -half}, {half, half, half}}; }

/// Points in rows, as functions and programs take them.
struct PointRows {
  explicit PointRows(const std::vector<Vec3d>& points) {
    for (const Vec3d& p : points) {
      x.push_back(p[0]);
      y.push_back(p[1]);
      z.push_back(p[2]);
    }
  }
  [[nodiscard]] ShapePoints batch(std::size_t begin) const {
    const int count = static_cast<int>(std::min<std::size_t>(x.size() - begin, kShapeBatch));
    return {x.data() + begin, y.data() + begin, z.data() + begin, count};
  }
  std::vector<double> x, y, z;
};

inline std::vector<double> valuesOf(const ShapeFunction& f, const std::vector<Vec3d>& points) {
  const PointRows rows(points);
  std::vector<double> values(points.size());
  for (std::size_t i = 0; i < points.size(); i += kShapeBatch)
    f.evaluate(rows.batch(i), {values.data() + i, {nullptr, nullptr, nullptr}});
  return values;
}
inline double valueOf(const ShapeFunction& f, const Vec3d& p) { return valuesOf(f, {p})[0]; }

inline std::vector<Vec3d> gradientsOf(const ShapeFunction& f, const std::vector<Vec3d>& points) {
  const PointRows rows(points);
  std::vector<Vec3d> gradients;
  BatchNumbers value, x, y, z;
  for (std::size_t i = 0; i < points.size(); i += kShapeBatch) {
    const ShapePoints batch = rows.batch(i);
    f.evaluate(batch, {value.data(), {x.data(), y.data(), z.data()}});
    for (int k = 0; k < batch.count; ++k) gradients.push_back({x[k], y[k], z[k]});
  }
  return gradients;
}

/// By central differences.
template <class Value>
Vec3d differences(const Value& value, const Vec3d& p, double step) {
  Vec3d slope;
  for (int a = 0; a < 3; ++a) {
    Vec3d above = p, below = p;
    above[a] += step;
    below[a] -= step;
    slope[a] = (value(above) - value(below)) / (above[a] - below[a]);
  }
  return slope;
}

inline double length(const Vec3d& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
inline double apart(const Vec3d& a, const Vec3d& b) { return length({a[0] - b[0], a[1] - b[1], a[2] - b[2]}); }

} // namespace volcaustic::test
