// Values at the nodes of a regular lattice that fills a box: the fields of a flow. Lengths are in cells: the box is
// [0, n] along each axis. Every node holds a value, so a plain array takes the place of a tree; grids of OpenVDB are
// made of it where a frame is written.
#pragma once

#include "core/parallel.h"
#include "volcaustic/types.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

namespace volcaustic {

/// Eight nodes around a position and the weights of the upper ones.
struct LatticeCorner {
  std::size_t first; ///< index of the lowest node
  Vec3f weight;
};

/// Node (i, j, k) is at origin + (i, j, k). At least two nodes along each axis.
class Lattice {
public:
  Lattice(const Vec3i& dims, const Vec3f& origin)
      : mDims(dims), mOrigin(origin), mValues(static_cast<std::size_t>(dims[0]) * dims[1] * dims[2]) {}

  [[nodiscard]] const Vec3i& dims() const { return mDims; }
  [[nodiscard]] std::size_t size() const { return mValues.size(); }
  [[nodiscard]] std::vector<float>& values() { return mValues; }
  [[nodiscard]] const std::vector<float>& values() const { return mValues; }
  [[nodiscard]] std::size_t stride(int axis) const {
    return axis == 0 ? 1 : static_cast<std::size_t>(mDims[0]) * (axis == 1 ? 1 : mDims[1]);
  }
  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * mDims[1] + j) * mDims[0] + i;
  }
  float& at(int i, int j, int k) { return mValues[index(i, j, k)]; }
  [[nodiscard]] float at(int i, int j, int k) const { return mValues[index(i, j, k)]; }
  [[nodiscard]] Vec3f position(int i, int j, int k) const {
    return {mOrigin[0] + static_cast<float>(i), mOrigin[1] + static_cast<float>(j), mOrigin[2] + static_cast<float>(k)};
  }

  /// Around the nearest position that has nodes on all sides.
  [[nodiscard]] LatticeCorner corner(const Vec3f& p) const {
    Vec3i node;
    Vec3f weight;
    for (int a = 0; a < 3; ++a) {
      const float x = std::clamp(p[a] - mOrigin[a], 0.0f, static_cast<float>(mDims[a] - 1));
      node[a] = std::min(static_cast<int>(x), mDims[a] - 2);
      weight[a] = x - static_cast<float>(node[a]);
    }
    return {index(node[0], node[1], node[2]), weight};
  }
  [[nodiscard]] float interpolate(const LatticeCorner& c) const {
    const std::size_t y = stride(1), z = stride(2);
    const float* v = mValues.data() + c.first;
    const auto row = [&](const float* p) { return p[0] + c.weight[0] * (p[1] - p[0]); };
    const auto plane = [&](const float* p) {
      const float low = row(p);
      return low + c.weight[1] * (row(p + y) - low);
    };
    const float low = plane(v);
    return low + c.weight[2] * (plane(v + z) - low);
  }
  /// Trilinear.
  [[nodiscard]] float sample(const Vec3f& p) const { return interpolate(corner(p)); }

private:
  Vec3i mDims;
  Vec3f mOrigin;
  std::vector<float> mValues;
};

/// Calls body(j, k) for each row of nodes along x; small lattices are not worth the threads.
template <class Body>
void forEachRow(const Vec3i& dims, const RunContext& ctx, const Body& body) {
  constexpr std::int64_t kPiece = 8192; // nodes
  const std::int64_t rows = std::int64_t{dims[1]} * dims[2];
  const auto run = [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t row = begin; row < end; ++row)
      body(static_cast<int>(row % dims[1]), static_cast<int>(row / dims[1]));
  };
  if (rows * dims[0] <= kPiece)
    run(0, rows, 0);
  else
    parallelFor(rows, std::max<std::int64_t>(1, kPiece / dims[0]), ctx, run);
}

} // namespace volcaustic
