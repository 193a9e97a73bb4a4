#include "transport/smooth.h"

#include "backends/lanes.h"
#include "core/parallel.h"
#include "kernels/smooth.h"

namespace volcaustic {

namespace {

using kernels::kSmoothBlock;

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

/// A brick and one voxel around it, row by row. Beyond the domain's faces stand the values before them.
class Neighbourhood {
public:
  explicit Neighbourhood(const BrickGrid<Vec3f>& field) : mField(field) {}

  const float* gather(const Vec3i& brick) {
    const Vec3i& dims = mField.dims();
    bool inside = true;
    for (int a = 0; a < 3; ++a) inside = inside && brick[a] > 0 && 8 * brick[a] + 8 < dims[a];
    if (inside)
      gatherInside(brick);
    else
      gatherAtFace(brick);
    return mValues[0].data();
  }

private:
  void gatherInside(const Vec3i& brick) {
    const Vec3f* voxels[3][3][3]; // null: one value
    Vec3f constants[3][3][3];
    for (int i = 0; i < 27; ++i) {
      const int x = i / 9, y = i / 3 % 3, z = i % 3;
      const std::int64_t b = mField.brickIndex({brick[0] + x - 1, brick[1] + y - 1, brick[2] + z - 1});
      voxels[x][y][z] = mField.isConstant(b) ? nullptr : mField.voxels(b).data();
      constants[x][y][z] = mField.isConstant(b) ? mField.constant(b) : Vec3f{};
    }
    for (int x = -1; x <= 8; ++x)
      for (int y = -1; y <= 8; ++y) {
        const int bx = (x + 8) >> 3, by = (y + 8) >> 3, row = brickOffset(x, y, 0);
        Vec3f* out = &mValues[((x + 1) * kSmoothBlock + y + 1) * kSmoothBlock];
        const auto at = [&](int bz, int z) {
          return voxels[bx][by][bz] ? voxels[bx][by][bz][row + z] : constants[bx][by][bz];
        };
        out[0] = at(0, 7);
        if (const Vec3f* middle = voxels[bx][by][1])
          std::copy_n(middle + row, 8, out + 1);
        else
          std::fill_n(out + 1, 8, constants[bx][by][1]);
        out[9] = at(2, 0);
      }
  }

  void gatherAtFace(const Vec3i& brick) {
    for (int x = 0; x < kSmoothBlock; ++x)
      for (int y = 0; y < kSmoothBlock; ++y)
        for (int z = 0; z < kSmoothBlock; ++z)
          mValues[(x * kSmoothBlock + y) * kSmoothBlock + z] =
              mField.clamped(brick[0] * 8 + x - 1, brick[1] * 8 + y - 1, brick[2] * 8 + z - 1);
  }

  const BrickGrid<Vec3f>& mField;
  std::array<Vec3f, kSmoothBlock * kSmoothBlock * kSmoothBlock> mValues;
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
  result.activate(bricks, Fill::Later);
  const LaneSet& lanes = laneSet("");
  parallelFor(static_cast<std::int64_t>(bricks.size()), 16, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    Neighbourhood around(field);
    for (std::int64_t i = begin; i < end; ++i)
      lanes.smoothBrick(around.gather(field.brickCoord(bricks[i])), result.voxels(bricks[i]).data()->data());
  });
  return result;
}

void smoothSome(BrickGrid<Vec3f>& field, std::span<const std::int64_t> bricks, const RunContext& ctx) {
  std::vector<std::int64_t> fresh;
  for (const std::int64_t b : bricks)
    if (field.isConstant(b)) fresh.push_back(b);
  ctx.requireMemory((fresh.size() + bricks.size()) * kBrickVoxels * sizeof(Vec3f), "photons: smoothing");
  field.activate(fresh, Fill::Later);
  parallelFor(static_cast<std::int64_t>(fresh.size()), 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      const auto voxels = field.voxels(fresh[i]);
      std::fill(voxels.begin(), voxels.end(), field.constant(fresh[i]));
    }
  });
  using Brick = std::array<Vec3f, kBrickVoxels>;
  std::vector<Brick, UninitialisedAllocator<Brick>> results(bricks.size());
  const LaneSet& lanes = laneSet("");
  const auto count = static_cast<std::int64_t>(bricks.size());
  parallelFor(count, 16, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    Neighbourhood around(field);
    for (std::int64_t i = begin; i < end; ++i)
      lanes.smoothBrick(around.gather(field.brickCoord(bricks[i])), results[i].data()->data());
  });
  parallelFor(count, 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i)
      std::copy(results[i].begin(), results[i].end(), field.voxels(bricks[i]).begin());
  });
}

} // namespace volcaustic
