#include "polygonise/hierarchy.h"

#include "core/parallel.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

constexpr double kMostCells = 32768;
/// Beyond that many cells from the origin, coordinates of neighbouring points of the lattice are no longer told apart
/// well enough by double precision to find roots between them.
constexpr double kFarthestCell = 1 << 30;
/// Cells around a block that vertices of faces at its edges may lie in.
constexpr int kHalo = 2;
/// What a block costs with its part of the mesh, measured.
constexpr std::uint64_t kBlockBytes = 16 << 10;

/// A cube of blocks, `coord` counted in cubes of its own size.
struct Cube {
  Vec3i coord;
  ShapeProgram program;
};

/// \param cells along the cube's edge; \param halo cells more on every side
Box boxOf(const Vec3i& coord, std::int64_t cells, std::int64_t halo, double cellSize) {
  Box box;
  for (int a = 0; a < 3; ++a) {
    box.min[a] = latticeCoordinate(coord[a] * cells - halo, cellSize);
    box.max[a] = latticeCoordinate((coord[a] + 1) * cells + halo, cellSize);
  }
  return box;
}

bool hasOneSign(const Interval& values) { return values.low >= 0 || values.high < 0; }

/// Eighths of a cube that the surface may pass through.
void divide(const Cube& cube, std::int64_t cells, double cellSize, ShapeScratch& scratch, std::vector<Cube>& into) {
  for (int i = 0; i < 8; ++i) {
    Cube eighth;
    for (int a = 0; a < 3; ++a) eighth.coord[a] = 2 * cube.coord[a] + (i >> a & 1);
    if (hasOneSign(cube.program.prune(boxOf(eighth.coord, cells, kHalo, cellSize), eighth.program, scratch))) continue;
    if (hasOneSign(eighth.program.bound(boxOf(eighth.coord, cells, 0, cellSize), scratch))) continue;
    into.push_back(std::move(eighth));
  }
}

/// Cubes that cover the bounds and two cells around them, at most three along an axis; \param levels that they are
/// above blocks
std::vector<Cube> rootCubes(const ShapeProgram& program, const Box& bounds, double cellSize, int& levels) {
  const auto firstAndLast = [&](int axis, std::int64_t cells) {
    const auto at = [&](double p, int side) {
      return static_cast<std::int64_t>(std::floor((p / cellSize + kHalo * side) / static_cast<double>(cells)));
    };
    return std::array<std::int64_t, 2>{at(bounds.min[axis], -1), at(bounds.max[axis], 1)};
  };
  const auto isWide = [&](int axis) {
    const auto [first, last] = firstAndLast(axis, std::int64_t{kBlockCells} << levels);
    return last - first >= 3;
  };
  for (levels = 0; isWide(0) || isWide(1) || isWide(2);) ++levels;
  const std::int64_t cells = std::int64_t{kBlockCells} << levels;
  std::vector<Cube> cubes;
  const auto [x0, x1] = firstAndLast(0, cells);
  const auto [y0, y1] = firstAndLast(1, cells);
  const auto [z0, z1] = firstAndLast(2, cells);
  for (std::int64_t z = z0; z <= z1; ++z)
    for (std::int64_t y = y0; y <= y1; ++y)
      for (std::int64_t x = x0; x <= x1; ++x)
        cubes.push_back({{static_cast<int>(x), static_cast<int>(y), static_cast<int>(z)}, program});
  return cubes;
}

} // namespace

bool latticeHolds(const Box& bounds, double cellSize) {
  if (!(cellSize > 0) || !std::isfinite(cellSize)) return false;
  for (int a = 0; a < 3; ++a) {
    if (bounds.max[a] - bounds.min[a] > kMostCells * cellSize) return false;
    if (std::max(std::abs(bounds.min[a]), std::abs(bounds.max[a])) > kFarthestCell * cellSize) return false;
  }
  return true;
}

std::vector<SurfaceBlock> surfaceBlocks(const ShapeProgram& program, const Box& bounds, double cellSize,
                                        const RunContext& ctx) {
  if (!latticeHolds(bounds, cellSize))
    throw Error(ErrorKind::Input,
                "polygonise: cells that small are more than 32768 along an axis, or the shape is more "
                "than 2^30 of them from the origin; take larger ones, or move the shape");
  int level = 0;
  std::vector<Cube> cubes = rootCubes(program, bounds, cellSize, level);
  std::vector<ShapeScratch> scratch(threadCount(ctx));
  while (level-- > 0) {
    if (level == 0) ctx.requireMemory(4 * cubes.size() * kBlockBytes, "blocks of a polygonised shape");
    std::vector<std::vector<Cube>> eighths(cubes.size());
    parallelFor(static_cast<std::int64_t>(cubes.size()), 16, ctx, [&](std::int64_t begin, std::int64_t end, int slot) {
      for (std::int64_t i = begin; i < end; ++i)
        divide(cubes[i], std::int64_t{kBlockCells} << level, cellSize, scratch[slot], eighths[i]);
    });
    cubes.clear();
    for (std::vector<Cube>& some : eighths) std::move(some.begin(), some.end(), std::back_inserter(cubes));
  }
  std::vector<SurfaceBlock> blocks;
  blocks.reserve(cubes.size());
  for (Cube& cube : cubes) {
    const std::uint64_t hash = cube.program.hash();
    blocks.push_back({cube.coord, std::move(cube.program), hash});
  }
  std::sort(blocks.begin(), blocks.end(), [](const SurfaceBlock& a, const SurfaceBlock& b) {
    return std::array{a.coord[2], a.coord[1], a.coord[0]} < std::array{b.coord[2], b.coord[1], b.coord[0]};
  });
  return blocks;
}

} // namespace volcaustic
