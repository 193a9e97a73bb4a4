// Sparse bricks: what they say, what they cost, and what several threads may do with them at once.
#include "core/brick_grid.h"

#include "core/brick_set.h"
#include "core/parallel.h"
#include "support/resident_memory.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {
namespace {

constexpr Vec3i kOdd{70, 41, 100}; // no whole number of bricks along any axis

TEST(BrickGrid, IsItsBackgroundUntilSomebodySaysOtherwise) {
  const BrickGrid<float> grid(kOdd, 1.5f);
  EXPECT_EQ(grid.brickDims(), (Vec3i{9, 6, 13}));
  EXPECT_TRUE(grid.occupied().empty());
  EXPECT_EQ(grid.activeBrickCount(), 0);
  for (std::int64_t b = 0; b < grid.brickCount(); ++b) {
    ASSERT_TRUE(grid.isConstant(b));
    ASSERT_EQ(grid.constant(b), 1.5f);
    ASSERT_EQ(grid.brickIndex(grid.brickCoord(b)), b);
  }
  EXPECT_EQ(grid.clamped(-5, 200, 3), 1.5f);
}

TEST(BrickGrid, ConstantsComeAndGo) {
  BrickGrid<Vec3f> grid(kOdd, {1, 2, 3});
  grid.setConstant(17, {4, 5, 6});
  grid.setConstant(18, {0, 0, 0}); // zeros are a value like any other
  grid.setConstant(19, {1, 2, 3});
  EXPECT_EQ(grid.occupied(), (std::vector<std::int64_t>{17, 18}));
  EXPECT_EQ(grid.constant(17), (Vec3f{4, 5, 6}));
  EXPECT_EQ(grid.constant(18), (Vec3f{0, 0, 0}));
  grid.setConstant(17, {1, 2, 3});
  EXPECT_EQ(grid.occupied(), std::vector<std::int64_t>{18});
  EXPECT_EQ(grid.constant(17), (Vec3f{1, 2, 3}));
  EXPECT_EQ(grid.activeBrickCount(), 0);
}

TEST(BrickGrid, NewVoxelsHoldWhatTheirBrickHeld) {
  BrickGrid<float> grid(kOdd, 1);
  grid.setConstant(30, 7);
  const std::vector<std::int64_t> bricks{40, 30, 2};
  grid.activate(bricks);
  for (const std::int64_t b : bricks) {
    ASSERT_FALSE(grid.isConstant(b));
    for (const float v : grid.voxels(b)) ASSERT_EQ(v, b == 30 ? 7.f : 1.f);
  }
  std::ranges::fill(grid.allocate(30), 9.f); // what has voxels keeps them
  const std::vector<std::int64_t> later{41};
  grid.activate(later, Fill::Later);
  std::ranges::fill(grid.voxels(41), 2.f);
  EXPECT_EQ(grid.activeBrickCount(), 4);
  EXPECT_EQ(grid.voxels(30)[511], 9.f);
  EXPECT_EQ(grid.voxels(2)[0], 1.f);
  EXPECT_EQ(grid.occupied(), (std::vector<std::int64_t>{2, 30, 40, 41}));
}

TEST(BrickGrid, CopiesStandAlone) {
  BrickGrid<float> grid({512, 512, 512}, 1); // tables of a megabyte, which come from the system
  grid.setConstant(70000, 3);
  grid.allocate(200000)[5] = 4;
  BrickGrid<float> copy = grid;
  copy.setConstant(70000, 8);
  copy.voxels(200000)[5] = 9;
  EXPECT_EQ(grid.constant(70000), 3);
  EXPECT_EQ(grid.voxels(200000)[5], 4);
  EXPECT_EQ(copy.constant(70000), 8);
  EXPECT_EQ(copy.occupied(), grid.occupied());
  const BrickGrid<float> moved = std::move(copy);
  EXPECT_EQ(moved.voxels(200000)[5], 9);
}

TEST(BrickGrid, ThreadsSetConstantsOfDifferentBricksAtOnce) {
  BrickGrid<Vec3f> grid({1024, 256, 256}, {1, 1, 1});
  RunContext ctx;
  ctx.threads = 4;
  const auto valueOf = [](std::int64_t b) {
    return b % 3 == 0 ? Vec3f{1, 1, 1} : Vec3f{static_cast<float>(b), static_cast<float>(b % 7), 2};
  };
  for (int round = 0; round < 2; ++round) // neighbours in a table are written by different threads
    parallelFor(grid.brickCount(), 3, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t b = begin; b < end; ++b) grid.setConstant(b, round ? valueOf(b) : valueOf(b + 1));
    });
  for (std::int64_t b = 0; b < grid.brickCount(); ++b) ASSERT_EQ(grid.constant(b), valueOf(b)) << b;
  const std::vector<std::int64_t> occupied = grid.occupied();
  EXPECT_TRUE(std::ranges::is_sorted(occupied));
  EXPECT_EQ(static_cast<std::int64_t>(occupied.size()), grid.brickCount() - (grid.brickCount() + 2) / 3);
}

TEST(BrickGrid, UniformAroundLooksAtAllNeighboursThereAre) {
  std::mt19937 random(5);
  BrickGrid<float> grid({64, 40, 56}, 1);
  for (std::int64_t b = 0; b < grid.brickCount(); ++b)
    if (random() % 60 == 0) grid.setConstant(b, 2);
  grid.allocate(grid.brickIndex({7, 4, 6}));
  for (std::int64_t b = 0; b < grid.brickCount(); ++b) {
    const Vec3i c = grid.brickCoord(b);
    bool uniform = grid.isConstant(b);
    for (std::int64_t o = 0; o < grid.brickCount(); ++o) {
      const Vec3i d = grid.brickCoord(o);
      const bool near = std::abs(c[0] - d[0]) <= 1 && std::abs(c[1] - d[1]) <= 1 && std::abs(c[2] - d[2]) <= 1;
      if (near && (!grid.isConstant(o) || grid.constant(o) != grid.constant(b))) uniform = false;
    }
    ASSERT_EQ(grid.uniformAround(b), uniform) << b;
  }
}

TEST(BrickGrid, CostsWhatIsActiveWhateverTheDomain) {
  VOLCAUSTIC_NEED_TRUE_MEMORY;
  const std::int64_t before = residentBytes();
  BrickGrid<Vec3f> grid({2048, 2048, 2048}, {0, 0, 0}); // tables of 268 MB
  for (int i = 0; i < 100; ++i) grid.setConstant(i * 160001, {1, 2, 3});
  grid.allocate(99);
  const BrickGrid<Vec3f> copy = grid;
  EXPECT_EQ(copy.occupied().size(), 101u); // looking everywhere costs nothing either
  EXPECT_LT(residentBytes() - before, 4 << 20);
}

TEST(BrickSet, HoldsABrickAndItsNeighbours) {
  const BrickGrid<float> grid(kOdd, 0);
  const std::vector<std::int64_t> seeds{0, grid.brickIndex({4, 3, 7}), grid.brickCount() - 1};
  BrickSet set(grid.brickDims());
  set.insertAround(seeds);
  std::vector<std::int64_t> expected;
  for (std::int64_t b = 0; b < grid.brickCount(); ++b) {
    const Vec3i c = grid.brickCoord(b);
    if (std::ranges::any_of(seeds, [&](std::int64_t s) {
          const Vec3i d = grid.brickCoord(s);
          return std::max({std::abs(c[0] - d[0]), std::abs(c[1] - d[1]), std::abs(c[2] - d[2])}) <= 1;
        }))
      expected.push_back(b);
  }
  EXPECT_EQ(set.sorted(), expected);
  EXPECT_EQ(merged(std::vector<std::int64_t>{1, 3, 5}, std::vector<std::int64_t>{2, 3, 9}),
            (std::vector<std::int64_t>{1, 2, 3, 5, 9}));
}

TEST(ZeroedTable, FindsEveryEntryThatIsNotZero) {
  std::mt19937 random(3);
  for (const std::size_t size : {1u, 7u, 8u, 9u, 1000u, 300001u}) {
    ZeroedTable<std::uint8_t> table(size);
    std::vector<std::size_t> expected;
    for (std::size_t i = 0; i < size; ++i)
      if (random() % 20 == 0) {
        table[i] = 1;
        expected.push_back(i);
      }
    const ZeroedTable<std::uint8_t> copy = table;
    const std::size_t begin = size / 3, end = size - size / 5;
    std::erase_if(expected, [&](std::size_t i) { return i < begin || i >= end; });
    std::vector<std::size_t> found;
    copy.forEachNonZero(begin, end, [&](std::size_t i) { found.push_back(i); });
    EXPECT_EQ(found, expected) << size;
  }
}

} // namespace
} // namespace volcaustic::test
