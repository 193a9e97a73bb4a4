// Integer sums that are carried to 64 bits before they overflow: whatever the order of deposits, the total is exact.

#include "backends/block_sums.h"
#include "backends/cpu_sink.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <random>
#include <string>

namespace volcaustic::test {
namespace {

using kernels::Int3;

MemoryBudget roomy() { return {std::uint64_t{1} << 30, 0}; }

VoxelSums times(const VoxelSums& s, std::int64_t n) {
  VoxelSums r;
  for (int c = 0; c < kSums; ++c) r[c] = n * s[c];
  return r;
}

/// The number in the block's sums of voxel `offset` of the brick at `corner`.
int inBlock(const Int3& corner, int offset) {
  return sumsOffset(corner.x + (offset >> 6), corner.y + (offset >> 3 & 7), corner.z + (offset & 7));
}

} // namespace

TEST(BlockSums, NumberVoxelsOfTheBlockAndAroundItOnce) {
  std::vector<char> seen(kSumsVoxels);
  for (int x = -1; x <= kBlockEdge; ++x)
    for (int y = -1; y <= kBlockEdge; ++y)
      for (int z = -1; z <= kBlockEdge; ++z) EXPECT_EQ(seen.at(sumsOffset(x, y, z))++, 0);
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), kSumsVoxels);
  const Int3 blocks = blockDims({1, 32, 33});
  EXPECT_EQ(blocks.x, 1);
  EXPECT_EQ(blocks.y, 1);
  EXPECT_EQ(blocks.z, 2);
  const Int3 corner = blockCorner({3, 4, 5}, (2 * 4 + 1) * 5 + 3);
  EXPECT_EQ(corner.x, 64);
  EXPECT_EQ(corner.y, 32);
  EXPECT_EQ(corner.z, 96);
}

// Bricks of a block and around it, voxel by voxel: every voxel that has a place in the sums and is in the domain's
// bricks, once, at that place.
TEST(BlockSums, BricksInAndAroundABlockCoverItOnce) {
  const Int3 bricks(9, 4, 6); // blocks of 4: three, one and two, the last ones in part
  for (const Int3& block : {Int3(0, 0, 0), Int3(1, 0, 1), Int3(2, 0, 0)}) {
    const Int3 corner(block.x * kBlockEdge, block.y * kBlockEdge, block.z * kBlockEdge);
    std::vector<int> seen(kSumsVoxels);
    forBricksInSums(bricks, corner, [&](std::int64_t brick, const Int3& low) {
      const Int3 at(static_cast<int>(brick / 24) * 8, static_cast<int>(brick / 6 % 4) * 8,
                    static_cast<int>(brick % 6) * 8);
      EXPECT_TRUE(at.x == corner.x + low.x && at.y == corner.y + low.y && at.z == corner.z + low.z) << brick;
      forVoxelsInSums(low, [&](int k, int voxel) {
        EXPECT_EQ(voxel, inBlock(low, k));
        ++seen.at(voxel);
      });
    });
    for (int x = -1; x <= kBlockEdge; ++x)
      for (int y = -1; y <= kBlockEdge; ++y)
        for (int z = -1; z <= kBlockEdge; ++z) {
          const auto inside = [](int c, int count) { return c >= 0 && c < 8 * count; };
          const bool in =
              inside(corner.x + x, bricks.x) && inside(corner.y + y, bricks.y) && inside(corner.z + z, bricks.z);
          ASSERT_EQ(seen[sumsOffset(x, y, z)], in) << x << ' ' << y << ' ' << z;
        }
  }
}

TEST(BlockSums, AddUpExactlyAcrossTheEndOfTheRange) {
  std::mt19937_64 random(1);
  BlockSums sums;
  sums.clear();
  std::map<int, VoxelSums> reference;
  // From single units to more than a carried sum holds, of both signs.
  for (int i = 0; i < 20000; ++i) {
    const int voxel = static_cast<int>(random() % 7) * 4681;
    VoxelSums s;
    for (std::int64_t& v : s) v = static_cast<std::int64_t>(random()) >> (20 + random() % 40);
    sums.add(voxel, s);
    for (int c = 0; c < kSums; ++c) reference[voxel][c] += s[c];
  }
  for (const auto& [voxel, s] : reference) EXPECT_EQ(sums.at(voxel), s) << voxel;
  EXPECT_EQ(sums.at(3), VoxelSums{});
  EXPECT_FALSE(sums.carried().empty());
  sums.clear();
  for (const auto& [voxel, s] : reference) EXPECT_EQ(sums.at(voxel), VoxelSums{});
  EXPECT_TRUE(sums.carried().empty());
}

TEST(BlockSums, KeepLowSumsTogetherAndCarriedOnesInOrder) {
  BlockSums sums;
  sums.clear();
  sums.add(100, {1, -2, 3, -4, 5, (1 << 29) - 1});
  const std::array<std::int32_t, 8> expected{1, -2, 3, 0, -4, 5, (1 << 29) - 1, 0};
  for (int i = 0; i < 8; ++i) EXPECT_EQ(sums.low()[800 + i], expected[i]) << i;
  EXPECT_TRUE(sums.carried().empty());
  sums.add(100, {0, 0, 0, 0, 0, 1}); // beyond half of the range
  sums.add(7, {std::int64_t{1} << 40, 0, 3, -(std::int64_t{1} << 41), 0, 0});
  sums.add(200, {std::int64_t{1} << 30, 0, 0, 0, 0, 0});
  EXPECT_EQ(sums.at(100), (VoxelSums{1, -2, 3, -4, 5, 1 << 29}));
  const std::vector<kernels::CarriedSums> carried = sums.carried();
  ASSERT_EQ(carried.size(), 3u);
  for (const auto& [voxel, c] : std::map<int, int>{{7, 0}, {100, 1}, {200, 2}}) {
    EXPECT_EQ(carried[c].voxel, voxel);
    const VoxelSums all = sums.at(voxel);
    const std::int32_t* low = sums.low() + std::ptrdiff_t{8} * voxel;
    for (int i = 0; i < 8; ++i) {
      const double whole = i % 4 == 3 ? 0 : static_cast<double>(all[i < 3 ? i : i - 1]);
      EXPECT_EQ(double(carried[c].sums[i]) + low[i], whole) << "voxel " << voxel << " sum " << i;
    }
  }
}

// What whoever adds through low() relies on: after carry(), half of the range is free again, in both directions.
TEST(BlockSums, CarryMakesRoomForHalfTheRange) {
  constexpr std::int32_t kHalf = 1 << 29;
  BlockSums sums;
  sums.clear();
  constexpr int kVoxel = 12345, kBeside = 12346;
  VoxelSums total{};
  for (int i = 0; i < 50; ++i) {
    sums.carry();
    std::int32_t* low = sums.low() + std::ptrdiff_t{8} * kVoxel;
    const std::array<std::int32_t, kSums> added{kHalf, -kHalf, i % 2 ? kHalf : -kHalf, 1, -kHalf, kHalf - 1};
    for (int c = 0; c < kSums; ++c) {
      std::int32_t& at = low[c < 3 ? c : c + 1];
      const std::int64_t sum = std::int64_t{at} + added[c];
      ASSERT_LE(std::abs(sum), std::numeric_limits<std::int32_t>::max()) << "round " << i << " sum " << c;
      at += added[c];
      total[c] += added[c];
    }
    low[8] += 7; // the next voxel's
    ASSERT_EQ(sums.at(kVoxel), total) << "round " << i;
  }
  sums.carry();
  EXPECT_EQ(sums.at(kVoxel), total);
  EXPECT_EQ(sums.at(kBeside), (VoxelSums{350, 0, 0, 0, 0, 0}));
}

TEST(LightBricks, StrongDepositsIntoOneVoxelAddUpExactly) {
  MemoryBudget budget = roomy();
  CpuSums sums{LightBricks(20, budget), {}};
  const double scale = 1 << 17;
  CpuSink sink(sums, {scale, 1});
  constexpr int kDeposits = 100000;
  // 2^17 times these are whole numbers.
  const kernels::Float3 power(1, 0.75f, 0), direction(-1, 0.5f, 0.25f);
  for (int i = 0; i < kDeposits; ++i) {
    sink.deposit(11, 77, power, direction);
    if (i % 3 == 0) sink.deposit(11, 78, {0, 0, -power.x}, {0, 0, 0});
  }
  BlockSums block;
  block.clear();
  const Int3 corner(8, 16, 24);
  sums.bricks.addTo(11, block, corner);
  const std::int64_t unit = 1 << 17;
  EXPECT_EQ(block.at(inBlock(corner, 77)), times({unit, unit * 3 / 4, 0, -unit, unit / 2, unit / 4}, kDeposits));
  EXPECT_EQ(block.at(inBlock(corner, 78)), times({0, 0, -unit, 0, 0, 0}, (kDeposits + 2) / 3));
  EXPECT_EQ(block.at(inBlock(corner, 79)), VoxelSums{});
}

TEST(LightBricks, DepositsAreRoundedToTheNearestUnit) {
  MemoryBudget budget = roomy();
  CpuSums sums{LightBricks(1, budget), {}};
  CpuSink sink(sums, {16, 1});
  sink.deposit(0, 0, {0.6f / 16, -0.6f / 16, 0.4f / 16}, {-0.4f / 16, 2.6f / 16, 0});
  BlockSums block;
  block.clear();
  sums.bricks.addTo(0, block, {0, 0, 0});
  EXPECT_EQ(block.at(sumsOffset(0, 0, 0)), (VoxelSums{1, -1, 0, 0, 3, 0}));
}

// Bricks to a block and back, with sums inside the range, at its end and beyond it.
TEST(LightBricks, GoToBlocksAndBackWithoutLoss) {
  std::mt19937_64 random(2);
  MemoryBudget budget = roomy();
  const Int3 corner(16, 0, 8);
  BlockSums once;
  once.clear();
  std::vector<VoxelSums> reference(512);
  for (int k = 0; k < 512; k += 3) {
    for (std::int64_t& s : reference[k]) s = static_cast<std::int64_t>(random()) >> (25 + random() % 40);
    once.add(inBlock(corner, k), reference[k]);
  }
  once.add(inBlock(Int3(8, 0, 8), 3), {1000, 1000, 1000, 0, 0, 0}); // another brick's

  LightBricks bricks(5, budget);
  for (int i = 1; i <= 9; ++i) {
    bricks.add(4, once, corner);
    EXPECT_TRUE(bricks.touched(4));
    EXPECT_FALSE(bricks.touched(3));
    BlockSums back;
    back.clear();
    bricks.addTo(4, back, corner);
    bricks.addTo(3, back, corner); // nothing there
    for (int k = 0; k < 512; ++k) ASSERT_EQ(back.at(inBlock(corner, k)), times(reference[k], i)) << k << " round " << i;
    EXPECT_EQ(back.at(inBlock(Int3(8, 0, 8), 3)), VoxelSums{});
  }
}

// A brick beside a block gives it the voxels that touch it, and no others.
TEST(LightBricks, BesideABlockGiveItsOutermostVoxels) {
  MemoryBudget budget = roomy();
  LightBricks bricks(1, budget);
  for (int k = 0; k < 512; ++k) bricks.touch(0)[k].s[1] = k + 1;
  for (const Int3& corner : {Int3(-8, 0, 24), Int3(32, 8, -8), Int3(16, 32, 32), Int3(-8, -8, -8), Int3(32, 32, 32)}) {
    SCOPED_TRACE(testing::Message() << corner.x << ' ' << corner.y << ' ' << corner.z);
    BlockSums block;
    block.clear();
    bricks.addTo(0, block, corner);
    std::int64_t expected = 0, found = 0;
    const auto place = [](int c) { return c >= -1 && c <= kBlockEdge; };
    for (int k = 0; k < 512; ++k) {
      const Int3 v(corner.x + (k >> 6), corner.y + (k >> 3 & 7), corner.z + (k & 7));
      if (!place(v.x) || !place(v.y) || !place(v.z)) continue;
      expected += k + 1;
      EXPECT_EQ(block.at(sumsOffset(v.x, v.y, v.z))[1], k + 1);
    }
    for (int v = 0; v < kSumsVoxels; ++v) found += block.at(v)[1];
    EXPECT_EQ(found, expected);
    EXPECT_GT(found, 0);
  }
}

TEST(LightBricks, AddingNothingTouchesNothing) {
  MemoryBudget budget = roomy();
  LightBricks bricks(2, budget);
  BlockSums empty;
  empty.clear();
  bricks.add(1, empty, {0, 0, 0});
  EXPECT_FALSE(bricks.touched(1));
  EXPECT_EQ(budget.used, 0u);
}

// Sums that were carried, were added to and carried again stay apart by voxel.
TEST(LightBricks, CarriedSumsKeepTheirVoxel) {
  MemoryBudget budget = roomy();
  LightBricks bricks(300, budget);
  for (int round = 0; round < 5; ++round)
    for (const std::int64_t brick : {0, 1, 299})
      for (const int offset : {0, 1, 511}) {
        bricks.touch(brick)[offset].s[0] += static_cast<std::int32_t>(1000 * brick + offset);
        bricks.touch(brick)[offset].s[6] -= 5;
        bricks.carry(brick, offset);
      }
  for (const std::int64_t brick : {0, 1, 299}) {
    BlockSums block;
    block.clear();
    bricks.addTo(brick, block, {0, 0, 0});
    for (const int offset : {0, 1, 511})
      EXPECT_EQ(block.at(inBlock({0, 0, 0}, offset)), (VoxelSums{5 * (1000 * brick + offset), 0, 0, 0, 0, -25}));
  }
}

TEST(LightBricks, StopAtTheMemoryLimitThatWorkersShare) {
  MemoryBudget budget{10 * sizeof(LightBricks::Brick), 0};
  LightBricks one(100, budget), two(100, budget);
  int made = 0;
  try {
    for (int i = 0; i < 100; ++i, ++made) (void)(i % 2 ? one : two).touch(i);
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    const std::string line = e.what();
    EXPECT_TRUE(line.starts_with("photons: ")) << line;
    EXPECT_NE(line.find("--memory-limit"), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
  EXPECT_EQ(made, 10);
}

} // namespace volcaustic::test
