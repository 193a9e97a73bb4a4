#include "simulation/flow.h"

#include <cmath>
#include <limits>

namespace volcaustic {

namespace {

Vec3f moved(const Vec3f& p, const Vec3f& v, float cells) {
  return {p[0] + cells * v[0], p[1] + cells * v[1], p[2] + cells * v[2]};
}

/// Where what is at `p` was before (cells < 0) or will be: the midpoint rule.
Vec3f traced(const StaggeredVelocity& velocity, const Vec3f& p, float cells) {
  return moved(p, velocity.sample(moved(p, velocity.sample(p), .5f * cells)), cells);
}

struct Extremes {
  float low, high;
};

Extremes extremes(const Lattice& field, const LatticeCorner& c) {
  const float* v = field.values().data() + c.first;
  Extremes e{v[0], v[0]};
  for (const std::size_t z : {std::size_t{0}, field.stride(2)})
    for (const std::size_t y : {std::size_t{0}, field.stride(1)})
      for (const std::size_t x : {std::size_t{0}, std::size_t{1}}) {
        e.low = std::min(e.low, v[x + y + z]);
        e.high = std::max(e.high, v[x + y + z]);
      }
  return e;
}

} // namespace

float largestMagnitude(const std::vector<float>& values, const RunContext& ctx) {
  constexpr std::int64_t kPiece = 16384;
  const auto count = static_cast<std::int64_t>(values.size());
  std::vector<float> most((count + kPiece - 1) / kPiece);
  parallelFor(count, kPiece, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    float here = 0;
    for (std::int64_t i = begin; i < end; ++i)
      here = std::max(here, std::isfinite(values[i]) ? std::abs(values[i]) : std::numeric_limits<float>::infinity());
    most[begin / kPiece] = here;
  });
  return *std::max_element(most.begin(), most.end());
}

float StaggeredVelocity::maxSpeed(const RunContext& ctx) const {
  float fastest = 0;
  for (const Lattice& lattice : component) fastest = std::max(fastest, largestMagnitude(lattice.values(), ctx));
  return fastest;
}

Lattice advected(const Lattice& field, const StaggeredVelocity& velocity, float cells, const RunContext& ctx) {
  Lattice forward = field, result = field;
  std::vector<Extremes> range(field.size());
  const int nx = field.dims()[0];
  forEachRow(field.dims(), ctx, [&](int j, int k) {
    for (int i = 0; i < nx; ++i) {
      const LatticeCorner from = field.corner(traced(velocity, field.position(i, j, k), -cells));
      const std::size_t node = field.index(i, j, k);
      forward.values()[node] = field.interpolate(from);
      range[node] = extremes(field, from);
    }
  });
  forEachRow(field.dims(), ctx, [&](int j, int k) {
    for (int i = 0; i < nx; ++i) {
      const std::size_t node = field.index(i, j, k);
      // Back where it came from, the step should find what was there; half of what it missed is its own error.
      const float back = forward.sample(traced(velocity, field.position(i, j, k), cells));
      result.values()[node] =
          std::clamp(forward.values()[node] + .5f * (field.values()[node] - back), range[node].low, range[node].high);
    }
  });
  return result;
}

} // namespace volcaustic
