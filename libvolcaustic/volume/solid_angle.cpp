#include "volume/solid_angle.h"

#include "core/simd_clones.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace volcaustic {

namespace {

using Block = PointSums::Block;
constexpr int kLanes = PointSums::kLanes;

/// The angle of (x, y) to 2e-8 (Abramowitz and Stegun, "Handbook of mathematical functions", 4.4.49), in operations
/// that compilers turn into lanes; 0 at the origin.
inline double angleOf(double y, double x) {
  constexpr std::array kTerms{-.3333314528, .1999355085, -.1420889944, .1065626393,
                              -.0752896400, .0429096138, -.0161657367, .0028662257};
  const double ay = std::abs(y), ax = std::abs(x);
  const double t = (ay < ax ? ay : ax) / ((ay < ax ? ax : ay) + std::numeric_limits<double>::min());
  const double square = t * t;
  double series = kTerms[7];
  for (int i = 6; i >= 0; --i) series = series * square + kTerms[i];
  double angle = t + t * square * series;
  angle = ay > ax ? std::numbers::pi / 2 - angle : angle;
  angle = x < 0 ? std::numbers::pi - angle : angle;
  return y < 0 ? -angle : angle;
}

/// 1/sqrt(x) to 1e-13, for 1e-30 <= x < 1e38: a step of Newton's from single precision is half the time of double
/// precision's root.
inline double inverseRoot(double x) {
  const double y = static_cast<double>(1 / std::sqrt(static_cast<float>(x)));
  return y * (1.5 - 0.5 * x * y * y);
}

/// Of a vector; what is shorter than 1e-15 sub-voxel is as good as that.
inline double lengthOf(double x, double y, double z) {
  const double square = x * x + y * y + z * z + 1e-30;
  return square * inverseRoot(square);
}

VOLCAUSTIC_SIMD_CLONES void addTriangleTo(const double* __restrict t, double weight, Block* blocks, std::size_t count) {
  const double scale = weight / (2 * std::numbers::pi);
  for (std::size_t b = 0; b < count; ++b) {
    Block& block = blocks[b];
    for (int l = 0; l < kLanes; ++l) {
      const double ax = t[0] - block.x[l], ay = t[1] - block.y[l], az = t[2] - block.z[l];
      const double bx = t[3] - block.x[l], by = t[4] - block.y[l], bz = t[5] - block.z[l];
      const double cx = t[6] - block.x[l], cy = t[7] - block.y[l], cz = t[8] - block.z[l];
      const double la = lengthOf(ax, ay, az), lb = lengthOf(bx, by, bz), lc = lengthOf(cx, cy, cz);
      const double sine = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
      const double cosine = la * lb * lc + (ax * bx + ay * by + az * bz) * lc + (bx * cx + by * cy + bz * cz) * la +
                            (cx * ax + cy * ay + cz * az) * lb;
      block.sum[l] += scale * angleOf(sine, cosine);
    }
  }
}

VOLCAUSTIC_SIMD_CLONES void addGroupTo(const AreaMoments& g, Block* blocks, std::size_t count) {
  const double scale = 1 / (4 * std::numbers::pi);
  const auto [xx, yy, zz, xy, xz, yz] = g.first;
  const double trace = xx + yy + zz;
  for (std::size_t b = 0; b < count; ++b) {
    Block& block = blocks[b];
    for (int l = 0; l < kLanes; ++l) {
      const double dx = g.centroid[0] - block.x[l], dy = g.centroid[1] - block.y[l], dz = g.centroid[2] - block.z[l];
      const double inverse = inverseRoot(dx * dx + dy * dy + dz * dz), square = inverse * inverse;
      const double dipole = g.areaVector[0] * dx + g.areaVector[1] * dy + g.areaVector[2] * dz;
      const double form = xx * dx * dx + yy * dy * dy + zz * dz * dz + 2 * (xy * dx * dy + xz * dx * dz + yz * dy * dz);
      block.sum[l] += scale * (dipole + trace - 3 * form * square) * (square * inverse);
    }
  }
}

VOLCAUSTIC_SIMD_CLONES void placeAt(const Block* pattern, const Vec3d& by, Block* blocks, std::size_t count) {
  for (std::size_t b = 0; b < count; ++b)
    for (int l = 0; l < kLanes; ++l) {
      blocks[b].x[l] = pattern[b].x[l] + by[0];
      blocks[b].y[l] = pattern[b].y[l] + by[1];
      blocks[b].z[l] = pattern[b].z[l] + by[2];
      blocks[b].sum[l] = 0;
    }
}

} // namespace

void PointSums::place(const PointSums& pattern, const Vec3d& by) {
  mBlocks.resize(pattern.mBlocks.size());
  mSize = pattern.mSize;
  placeAt(pattern.mBlocks.data(), by, mBlocks.data(), mBlocks.size());
}

void PointSums::addSumsTo(double* numbers) const {
  for (int i = 0; i < mSize; i += kLanes) {
    const Block& block = mBlocks[i / kLanes];
    for (int l = 0; l < std::min(kLanes, mSize - i); ++l) numbers[i + l] += block.sum[l];
  }
}

void PointSums::add(const Vec3d& p) {
  const int lane = mSize++ % kLanes;
  if (lane == 0) {
    Block& block = mBlocks.emplace_back();
    block.x.fill(p[0]), block.y.fill(p[1]), block.z.fill(p[2]), block.sum.fill(0);
    return;
  }
  Block& block = mBlocks.back();
  block.x[lane] = p[0], block.y[lane] = p[1], block.z[lane] = p[2];
}

void addTriangle(const WeightedTriangle& triangle, PointSums& points) {
  addTriangleTo(triangle.corners[0].data(), triangle.weight, points.blocks().data(), points.blocks().size());
}

void addGroup(const AreaMoments& group, PointSums& points) {
  addGroupTo(group, points.blocks().data(), points.blocks().size());
}

} // namespace volcaustic
