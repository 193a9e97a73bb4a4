#include "transport/smooth.h"

#include "core/parallel.h"

namespace volcaustic {

namespace {

constexpr int kBlock = kBrickSize + 2; // a brick and one voxel around it

bool uniformNeighbourhood(const BrickGrid<Vec3f>& field, std::int64_t b) {
  if (!field.isConstant(b)) return false;
  const Vec3i c = field.brickCoord(b), n = field.brickDims();
  for (int x = std::max(c[0] - 1, 0); x <= std::min(c[0] + 1, n[0] - 1); ++x)
    for (int y = std::max(c[1] - 1, 0); y <= std::min(c[1] + 1, n[1] - 1); ++y)
      for (int z = std::max(c[2] - 1, 0); z <= std::min(c[2] + 1, n[2] - 1); ++z) {
        const std::int64_t other = field.brickIndex({x, y, z});
        if (!field.isConstant(other) || field.constant(other) != field.constant(b)) return false;
      }
  return true;
}

Vec3f blend(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  return {0.25f * (a[0] + c[0]) + 0.5f * b[0], 0.25f * (a[1] + c[1]) + 0.5f * b[1],
          0.25f * (a[2] + c[2]) + 0.5f * b[2]};
}

/// The three passes over one brick, each shrinking the block by one voxel on both sides of its axis.
class BrickSmoother {
public:
  void run(const BrickGrid<Vec3f>& field, const Vec3i& brick, std::span<Vec3f> out) {
    gather(field, brick);
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < kBlock; ++y)
        for (int z = 0; z < kBlock; ++z)
          mAfterX[(x * kBlock + y) * kBlock + z] = blend(in(x, y, z), in(x + 1, y, z), in(x + 2, y, z));
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < 8; ++y)
        for (int z = 0; z < kBlock; ++z) {
          const Vec3f* row = &mAfterX[(x * kBlock + y) * kBlock + z];
          mAfterY[(x * 8 + y) * kBlock + z] = blend(row[0], row[kBlock], row[2 * kBlock]);
        }
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < 8; ++y)
        for (int z = 0; z < 8; ++z) {
          const Vec3f* column = &mAfterY[(x * 8 + y) * kBlock + z];
          out[(x * 8 + y) * 8 + z] = blend(column[0], column[1], column[2]);
        }
  }

private:
  void gather(const BrickGrid<Vec3f>& field, const Vec3i& brick) {
    for (int x = 0; x < kBlock; ++x)
      for (int y = 0; y < kBlock; ++y)
        for (int z = 0; z < kBlock; ++z)
          mIn[(x * kBlock + y) * kBlock + z] =
              field.clamped(brick[0] * 8 + x - 1, brick[1] * 8 + y - 1, brick[2] * 8 + z - 1);
  }
  [[nodiscard]] const Vec3f& in(int x, int y, int z) const { return mIn[(x * kBlock + y) * kBlock + z]; }

  std::array<Vec3f, kBlock * kBlock * kBlock> mIn;
  std::array<Vec3f, 8 * kBlock * kBlock> mAfterX;
  std::array<Vec3f, 8 * 8 * kBlock> mAfterY;
};

} // namespace

BrickGrid<Vec3f> smoothed(const BrickGrid<Vec3f>& field, const RunContext& ctx) {
  BrickGrid<Vec3f> result(field.dims(), field.background());
  std::vector<char> varies(field.brickCount());
  parallelFor(field.brickCount(), 512, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t b = begin; b < end; ++b) varies[b] = !uniformNeighbourhood(field, b);
  });
  std::vector<std::int64_t> bricks;
  for (std::int64_t b = 0; b < field.brickCount(); ++b)
    if (varies[b])
      bricks.push_back(b);
    else
      result.setConstant(b, field.constant(b));
  ctx.requireMemory(bricks.size() * kBrickVoxels * sizeof(Vec3f), "photons: smoothing");
  result.activate(bricks);
  parallelFor(static_cast<std::int64_t>(bricks.size()), 16, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    BrickSmoother smoother;
    for (std::int64_t i = begin; i < end; ++i)
      smoother.run(field, field.brickCoord(bricks[i]), result.voxels(bricks[i]));
  });
  return result;
}

} // namespace volcaustic
