#include "volcaustic/view.h"

#include <cmath>
#include <locale>
#include <numbers>
#include <sstream>

namespace volcaustic {

namespace {

double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3d unit(const Vec3d& a) {
  const double length = std::sqrt(dot(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}

/// Points are rows and stand on the left, as in OpenEXR.
using Matrix = std::array<std::array<double, 4>, 4>;

Matrix operator*(const Matrix& a, const Matrix& b) {
  Matrix result{};
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c)
      for (int k = 0; k < 4; ++k) result[r][c] += a[r][k] * b[k][c];
  return result;
}

template <class Numbers>
void put(std::ostream& text, const Numbers& numbers) {
  for (const double number : numbers) text << (text.tellp() > 0 ? " " : "") << number;
}

std::string textOf(const Matrix& matrix) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(9);
  for (const auto& row : matrix) put(text, row);
  return text.str();
}

/// Right, up and forward of the camera are x, y and z.
Matrix worldToCamera(const Camera& camera) {
  const Vec3d& eye = camera.position;
  const Vec3d forward = unit({camera.target[0] - eye[0], camera.target[1] - eye[1], camera.target[2] - eye[2]}),
              right = unit(cross(forward, camera.up)), up = cross(right, forward);
  Matrix matrix{};
  for (int i = 0; i < 3; ++i) matrix[i] = {right[i], up[i], forward[i], 0};
  matrix[3] = {-dot(eye, right), -dot(eye, up), -dot(eye, forward), 1};
  return matrix;
}

} // namespace

std::map<std::string, std::string> cameraMetadata(const Camera& camera) {
  const double halfHeight = std::tan(camera.fieldOfView * std::numbers::pi / 360),
               halfWidth = halfHeight * camera.resolution[0] / camera.resolution[1];
  const Matrix view = worldToCamera(camera);
  // The picture's corners are (0, 0) and (1, 1), from the top; z is one over the distance.
  const Matrix picture{{{0.5 / halfWidth, 0, 0, 0}, {0, -0.5 / halfHeight, 0, 0}, {0.5, 0.5, 0, 1}, {0, 0, 1, 0}}};
  std::ostringstream width;
  width.imbue(std::locale::classic());
  width.precision(9);
  width << 2 * halfWidth;
  return {{"worldToCamera", textOf(view)}, {"worldToNDC", textOf(view * picture)}, {"screenWindowWidth", width.str()}};
}

} // namespace volcaustic
