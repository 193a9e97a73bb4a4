#include "bench_shapes.h"

#include <cmath>
#include <numbers>

namespace volcaustic::cli {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

Vec3d combined(const Vec3d& p, double a, const Vec3d& u, double b, const Vec3d& v) {
  return {p[0] + a * u[0] + b * v[0], p[1] + a * u[1] + b * v[1], p[2] + a * u[2] + b * v[2]};
}

Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vec3d unit(const Vec3d& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

/// A direction times the body's radius there. The lobes are a polynomial of the direction, Re((x + iy)^lobes) turned
/// with z, so the surface is smooth at the poles too.
Vec3d pointOf(const LobedBody& s, double theta, double phi) {
  const double sine = std::sin(theta), z = std::cos(theta);
  const double lobe = std::pow(sine, s.lobes) * std::cos(s.lobes * phi + s.twist * z / 2);
  const double r = s.lobes > 0 ? 1 + s.depth * lobe : 1;
  return {s.semiAxes[0] * r * sine * std::cos(phi), s.semiAxes[1] * r * sine * std::sin(phi), s.semiAxes[2] * r * z};
}

} // namespace

Mesh lobedBody(const LobedBody& shape, int columns, int rings) {
  Mesh mesh;
  mesh.positions.push_back(pointOf(shape, 0, 0));
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < columns; ++j)
      mesh.positions.push_back(pointOf(shape, std::numbers::pi * i / rings, kTurn * j / columns));
  mesh.positions.push_back(pointOf(shape, std::numbers::pi, 0));

  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(1 + (i - 1) * columns + j % columns); };
  const auto south = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  for (int j = 0; j < columns; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    for (int i = 1; i < rings - 1; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    mesh.triangles.push_back({at(rings - 1, j), south, at(rings - 1, j + 1)});
  }
  return mesh;
}

Mesh torusKnot(const TorusKnot& shape, int segments, int sides) {
  const auto curve = [&](double t) -> Vec3d {
    const double around = shape.majorRadius + shape.minorRadius * std::cos(shape.q * t);
    return {around * std::cos(shape.p * t), around * std::sin(shape.p * t), shape.minorRadius * std::sin(shape.q * t)};
  };
  Mesh mesh;
  for (int i = 0; i < segments; ++i) {
    // The torus' own normal closes with the curve, which a frame carried along it would not.
    const double t = kTurn * i / segments, h = 1e-5;
    const Vec3d tangent = combined({0, 0, 0}, 1, curve(t + h), -1, curve(t - h));
    const Vec3d normal{std::cos(shape.q * t) * std::cos(shape.p * t), std::cos(shape.q * t) * std::sin(shape.p * t),
                       std::sin(shape.q * t)};
    const Vec3d binormal = unit(cross(tangent, normal));
    for (int j = 0; j < sides; ++j) {
      const double a = kTurn * j / sides, r = shape.tubeRadius;
      mesh.positions.push_back(combined(curve(t), r * std::cos(a), normal, r * std::sin(a), binormal));
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i % segments * sides + j % sides); };
  for (int i = 0; i < segments; ++i)
    for (int j = 0; j < sides; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
      mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  return mesh;
}

} // namespace volcaustic::cli
