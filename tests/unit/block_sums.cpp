// Integer sums that are carried to 64 bits before they overflow: whatever the order of deposits, the total is exact.

#include "backends/block_sums.h"
#include "backends/cpu_sink.h"
#include "volcaustic/error.h"

#include <array>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <random>
#include <string>

namespace volcaustic::test {
namespace {

MemoryBudget roomy() { return {std::uint64_t{1} << 30, 0}; }

VoxelSums times(const VoxelSums& s, std::int64_t n) {
  VoxelSums r;
  for (int c = 0; c < kSums; ++c) r[c] = n * s[c];
  return r;
}

/// The block's voxel that holds voxel `offset` of its brick at `corner`.
int inBlock(int corner, int offset) { return corner + blockOffset(offset >> 6, offset >> 3 & 7, offset & 7); }

} // namespace

TEST(BlockSums, NumbersVoxelsOfTheBlockOnce) {
  std::vector<char> seen(kBlockVoxels);
  for (int x = 0; x < kBlockEdge; ++x)
    for (int y = 0; y < kBlockEdge; ++y)
      for (int z = 0; z < kBlockEdge; ++z) {
        EXPECT_EQ(blockOffset(x + 64, y + 32, z + 96), blockOffset(x, y, z));
        EXPECT_EQ(seen[blockOffset(x, y, z)]++, 0);
      }
  const kernels::Int3 blocks = blockDims({1, 32, 33});
  EXPECT_EQ(blocks.x, 1);
  EXPECT_EQ(blocks.y, 1);
  EXPECT_EQ(blocks.z, 2);
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
  EXPECT_EQ(sums.lowOnly(), nullptr);
  sums.clear();
  for (const auto& [voxel, s] : reference) EXPECT_EQ(sums.at(voxel), VoxelSums{});
  EXPECT_NE(sums.lowOnly(), nullptr);
}

TEST(BlockSums, LowSumsAloneServeWhileTheyAreAllThereIs) {
  BlockSums sums;
  sums.clear();
  sums.add(100, {1, -2, 3, -4, 5, (1 << 29) - 1});
  const std::int32_t* low = sums.lowOnly();
  ASSERT_NE(low, nullptr);
  const std::array<std::int32_t, 8> expected{1, -2, 3, 0, -4, 5, (1 << 29) - 1, 0};
  for (int i = 0; i < 8; ++i) EXPECT_EQ(low[800 + i], expected[i]) << i;
  sums.add(100, {0, 0, 0, 0, 0, 1});
  EXPECT_EQ(sums.lowOnly(), nullptr);
  EXPECT_EQ(sums.at(100), (VoxelSums{1, -2, 3, -4, 5, 1 << 29}));
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
  const int corner = blockOffset(8, 16, 24);
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
  sums.bricks.addTo(0, block, 0);
  EXPECT_EQ(block.at(0), (VoxelSums{1, -1, 0, 0, 3, 0}));
}

// Bricks to a block and back, with sums inside the range, at its end and beyond it.
TEST(LightBricks, GoToBlocksAndBackWithoutLoss) {
  std::mt19937_64 random(2);
  MemoryBudget budget = roomy();
  const int corner = blockOffset(16, 0, 8);
  BlockSums once;
  once.clear();
  std::vector<VoxelSums> reference(512);
  for (int k = 0; k < 512; k += 3) {
    for (std::int64_t& s : reference[k]) s = static_cast<std::int64_t>(random()) >> (25 + random() % 40);
    once.add(inBlock(corner, k), reference[k]);
  }
  once.add(inBlock(blockOffset(8, 0, 8), 3), {1000, 1000, 1000, 0, 0, 0}); // another brick's

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
    EXPECT_EQ(back.at(inBlock(blockOffset(8, 0, 8), 3)), VoxelSums{});
  }
}

TEST(LightBricks, AddingNothingTouchesNothing) {
  MemoryBudget budget = roomy();
  LightBricks bricks(2, budget);
  BlockSums empty;
  empty.clear();
  bricks.add(1, empty, 0);
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
    bricks.addTo(brick, block, 0);
    for (const int offset : {0, 1, 511})
      EXPECT_EQ(block.at(inBlock(0, offset)), (VoxelSums{5 * (1000 * brick + offset), 0, 0, 0, 0, -25}));
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
