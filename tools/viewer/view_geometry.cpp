#include "view_geometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace volcaustic::viewer {

namespace {

Vec3d operator+(const Vec3d& a, const Vec3d& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec3d operator-(const Vec3d& a, const Vec3d& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec3d operator*(const Vec3d& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Vec3d& a) { return std::sqrt(dot(a, a)); }
Vec3d unit(const Vec3d& a) { return a * (1 / length(a)); }

/// Rodrigues' rotation about a unit axis.
Vec3d turned(const Vec3d& v, const Vec3d& axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1 - c));
}

} // namespace

PictureArea fitted(const PictureArea& room, const std::array<int, 2>& resolution) {
  const double scale = std::min(room.width / resolution[0], room.height / resolution[1]);
  PictureArea area{0, 0, scale * resolution[0], scale * resolution[1]};
  area.x = room.x + (room.width - area.width) / 2;
  area.y = room.y + (room.height - area.height) / 2;
  return area;
}

Projection::Projection(const Camera& camera, const PictureArea& area) : mEye(camera.position), mArea(area) {
  mForward = unit(camera.target - camera.position);
  mRight = unit(cross(mForward, camera.up));
  mUp = cross(mRight, mForward);
  mPerPixel = 2 * std::tan(camera.fieldOfView * std::numbers::pi / 360) / area.height;
}

std::optional<Point> Projection::toWindow(const Vec3d& p) const {
  const Vec3d r = p - mEye;
  const double depth = dot(r, mForward);
  if (!(depth > 1e-9)) return std::nullopt;
  const double scale = 1 / (depth * mPerPixel);
  return Point{mArea.x + mArea.width / 2 + dot(r, mRight) * scale, mArea.y + mArea.height / 2 - dot(r, mUp) * scale};
}

Vec3d Projection::rayThrough(const Point& p) const {
  const double x = (p[0] - mArea.x - mArea.width / 2) * mPerPixel, y = (p[1] - mArea.y - mArea.height / 2) * mPerPixel;
  return unit(mForward + mRight * x - mUp * y);
}

double Projection::depthOf(const Vec3d& p) const { return dot(p - mEye, mForward); }

Vec3d Projection::inWorld(const Point& movement, double depth) const {
  return mRight * (movement[0] * mPerPixel * depth) - mUp * (movement[1] * mPerPixel * depth);
}

Camera orbited(Camera camera, const Point& movement, double windowHeight) {
  const double perPixel = std::numbers::pi / windowHeight;
  const Vec3d up = unit(camera.up);
  Vec3d offset = turned(camera.position - camera.target, up, -movement[0] * perPixel);
  const double height = std::acos(std::clamp(dot(unit(offset), up), -1.0, 1.0)); // from the pole
  constexpr double kNearest = 0.01;
  const double wanted = std::clamp(height - movement[1] * perPixel, kNearest, std::numbers::pi - kNearest);
  offset = turned(offset, unit(cross(up, offset)), wanted - height);
  camera.position = camera.target + offset;
  return camera;
}

Camera panned(Camera camera, const Point& movement, const PictureArea& area) {
  const Vec3d shift = Projection(camera, area).inWorld(movement, length(camera.target - camera.position));
  camera.position = camera.position - shift;
  camera.target = camera.target - shift;
  return camera;
}

Camera zoomed(Camera camera, double notches) {
  camera.position = camera.target + (camera.position - camera.target) * std::pow(0.9, notches);
  return camera;
}

std::optional<double> hit(const Mesh& mesh, const Vec3d& origin, const Vec3d& direction) {
  std::optional<double> nearest;
  for (const auto& t : mesh.triangles) { // Moeller, Trumbore 1997
    const Vec3d a = mesh.positions[t[0]], ab = mesh.positions[t[1]] - a, ac = mesh.positions[t[2]] - a;
    const Vec3d p = cross(direction, ac);
    const double determinant = dot(ab, p);
    if (determinant == 0) continue;
    const Vec3d from = origin - a, q = cross(from, ab);
    const double u = dot(from, p) / determinant, v = dot(direction, q) / determinant, at = dot(ac, q) / determinant;
    if (u >= 0 && v >= 0 && u + v <= 1 && at > 0 && (!nearest || at < *nearest)) nearest = at;
  }
  return nearest;
}

} // namespace volcaustic::viewer
