#include "transport/many_lamps.h"

#include <algorithm>
#include <array>

namespace volcaustic {

namespace {

constexpr int kEdge = 10; ///< voxels: a brick, and one on each side

/// to += weight * from, for each of eight numbers.
void addWeighted(float* to, const float* from, float weight) {
  for (int n = 0; n < 8; ++n) to[n] += weight * from[n];
}

} // namespace

ManyLamps::Axis::Axis(int firstOfBrick, int dim)
    : from(std::max(firstOfBrick - 1, 0)), to(std::min(firstOfBrick + kEdge - 2, dim - 1)), low(firstOfBrick - 1) {}

float ManyLamps::Axis::point(int number) const {
  return static_cast<float>(from) + 0.5f + 0.5f * static_cast<float>(to - from) * static_cast<float>(number);
}

std::array<float, ManyLamps::kPoints> ManyLamps::Axis::weights(int k) const {
  const auto place = static_cast<float>(std::clamp(low + k, from, to) - from);
  const float t = 2 * place / static_cast<float>(std::max(to - from, 1)) - 1; // -1 to 1
  return {0.5f * t * (t - 1), 1 - t * t, 0.5f * t * (t + 1)};
}

ManyLamps::ManyLamps(const kernels::Int3& low, const kernels::Int3& dims)
    : mX(low.x, dims.x), mY(low.y, dims.y), mZ(low.z, dims.z) {}

bool ManyLamps::takes(const kernels::Lamp& lamp) {
  constexpr float kThickest = 0.25f; // optical depth over the voxels
  return !lamp.point && kernels::maxComponent(lamp.attenuation) * kEdge <= kThickest;
}

void ManyLamps::add(const kernels::Lamp& lamp) {
  for (int x = 0; x < kPoints; ++x)
    for (int y = 0; y < kPoints; ++y)
      for (int z = 0; z < kPoints; ++z) {
        const kernels::LampLight<float> l = kernels::lampLight<float>(lamp, {mX.point(x), mY.point(y), mZ.point(z)});
        const kernels::Float3 towards = l.direction * kernels::luminance(l.fluence);
        float* sums = mLight[x][y][z];
        for (int c = 0; c < 3; ++c) {
          sums[c] += l.fluence[c];
          sums[4 + c] += towards[c];
        }
      }
}

void ManyLamps::spread(float* sums) const {
  for (int x = 0; x < kEdge; ++x)
    for (int y = 0; y < kEdge; ++y) {
      const auto alongX = mX.weights(x), alongY = mY.weights(y);
      float line[kPoints][8] = {};
      for (int i = 0; i < kPoints; ++i)
        for (int j = 0; j < kPoints; ++j)
          for (int k = 0; k < kPoints; ++k) addWeighted(line[k], mLight[i][j][k], alongX[i] * alongY[j]);
      for (int z = 0; z < kEdge; ++z, sums += 8) {
        const auto alongZ = mZ.weights(z);
        for (int k = 0; k < kPoints; ++k) addWeighted(sums, line[k], alongZ[k]);
      }
    }
}

} // namespace volcaustic
