// The balance between CPU and another device, with simulated devices: what each costs for a row is known, so what the
// boundary must come to is known too.

#include "transport/balancer.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {

namespace {

constexpr std::int64_t kRows = 1024;

/// Two devices that share a frame. A row at height u in [0, 1) costs `profile(u)` times as much as the mean row.
struct Machine {
  double cpu = 1, other = 1; ///< ms for the whole frame, alone
  double besides = 0;        ///< ms of CPU time for a frame that are neither rows nor waiting
  double noise = 0;          ///< each frame's speeds vary by up to this fraction
  bool peaked = false;       ///< most of the cost lies in the middle rows, as behind a glass ball
  std::mt19937 random = std::mt19937(7);

  FrameTimes run(HybridBalancer& balancer) {
    std::uniform_real_distribution<double> vary(1 - noise, 1 + noise);
    FrameTimes t;
    t.rows = kRows;
    t.cpuRows = balancer.cpuRows(kRows);
    const double part = costBelow(static_cast<double>(t.cpuRows) / kRows);
    t.cpuBusy = cpu * part * vary(random);
    t.otherBusy = other * (1 - part) * vary(random);
    t.frame = std::max(t.cpuBusy + besides, t.otherBusy);
    t.cpuWait = t.frame - t.cpuBusy - besides;
    balancer.frameDone(t);
    return t;
  }

private:
  [[nodiscard]] double costBelow(double u) const {
    return peaked ? u - 0.98 * std::sin(2 * 3.14159265358979 * u) / (2 * 3.14159265358979) : u;
  }
};

double busyShare(const FrameTimes& t) { return t.cpuBusy / t.frame; }
double waitShare(const FrameTimes& t) { return t.cpuWait / t.frame; }

/// Frames until the boundary moves no more, and how often it moved, over `frames` frames.
struct Watched {
  int lastMove = 0, moves = 0;
  FrameTimes last;
};
Watched watch(Machine& machine, HybridBalancer& balancer, int frames) {
  Watched w;
  for (int i = 1; i <= frames; ++i) {
    const double before = balancer.cpuShare();
    w.last = machine.run(balancer);
    if (balancer.cpuShare() != before) {
      ++w.moves;
      w.lastMove = i;
    }
  }
  return w;
}

} // namespace

TEST(HybridBalancer, StaticBalanceNeverMoves) {
  HybridBalancer balancer = HybridBalancer::fixed(0.3);
  Machine machine{1, 100};
  EXPECT_EQ(watch(machine, balancer, 100).moves, 0);
  EXPECT_EQ(balancer.cpuRows(1000), 300);
  EXPECT_EQ(HybridBalancer::fixed(0).cpuRows(7), 0);
  EXPECT_EQ(HybridBalancer::fixed(1).cpuRows(7), 7);
}

TEST(HybridBalancer, ConstantSpeedsSettleInTheBandFromAnyStart) {
  for (const double ratio : {0.05, 0.5, 1.0, 3.0, 40.0})
    for (const double start : {0.0, 0.02, 0.3, 0.6, 0.97, 1.0})
      for (const int every : {1, 4, 10}) {
        SCOPED_TRACE(testing::Message() << "ratio " << ratio << " start " << start << " every " << every);
        // Both sides done together would take cpu*other/(cpu + other); the CPU has 7 % of that to do besides.
        Machine machine{ratio, 1, 0.07 * ratio / (1 + ratio)};
        HybridBalancer balancer = HybridBalancer::dynamic(start, every);
        const Watched w = watch(machine, balancer, 100 * every);
        EXPECT_LE(w.lastMove, 5 * every);
        EXPECT_GE(busyShare(w.last), HybridBalancer::kLeastBusy);
        EXPECT_LE(busyShare(w.last), HybridBalancer::kMostBusy);
        EXPECT_LE(waitShare(w.last), HybridBalancer::kMostWait);
      }
}

// With nothing but rows and waiting, "at most 95 % busy" and "at most 5 % waiting" meet in one point; a row of 1024 is
// then as near as the boundary can come.
TEST(HybridBalancer, WithNothingBesidesItSettlesWhereBothBoundsMeet) {
  for (const double ratio : {0.2, 1.0, 7.0})
    for (const double start : {0.0, 0.5, 1.0}) {
      SCOPED_TRACE(testing::Message() << "ratio " << ratio << " start " << start);
      Machine machine{ratio, 1};
      HybridBalancer balancer = HybridBalancer::dynamic(start);
      const Watched w = watch(machine, balancer, 200);
      EXPECT_LE(w.lastMove, 32);
      EXPECT_NEAR(busyShare(w.last), 0.95, 0.01);
      EXPECT_NEAR(waitShare(w.last), 0.05, 0.01);
    }
}

TEST(HybridBalancer, InsideTheBandNothingMoves) {
  // 90 % busy, 3 % waiting at a third of the rows.
  HybridBalancer balancer = HybridBalancer::dynamic(1 / 3.0, 1);
  for (int i = 0; i < 50; ++i) balancer.frameDone({900, 300, 100, 90, 3, 100});
  EXPECT_EQ(balancer.cpuRows(900), 300);
}

TEST(HybridBalancer, AboveTheBandTheZoneShrinksBelowItGrows) {
  HybridBalancer above = HybridBalancer::dynamic(0.5, 1), below = above, waiting = above;
  above.frameDone({1000, 500, 100, 98, 0, 70});
  EXPECT_LT(above.cpuShare(), 0.5);
  below.frameDone({1000, 500, 100, 60, 40, 100});
  EXPECT_GT(below.cpuShare(), 0.5);
  waiting.frameDone({1000, 500, 100, 88, 9, 100});
  EXPECT_GT(waiting.cpuShare(), 0.5);
}

TEST(HybridBalancer, LooksAtEveryNthFrameOnly) {
  HybridBalancer balancer = HybridBalancer::dynamic(0.5, 10);
  Machine machine{10, 1};
  for (int i = 0; i < 9; ++i) machine.run(balancer);
  EXPECT_EQ(balancer.cpuShare(), 0.5);
  machine.run(balancer);
  EXPECT_LT(balancer.cpuShare(), 0.5);
}

TEST(HybridBalancer, AChangeOfSpeedIsFollowed) {
  for (const double factor : {0.1, 0.5, 0.8, 1.3, 2.0, 10.0}) {
    SCOPED_TRACE(factor);
    HybridBalancer balancer = HybridBalancer::dynamic();
    Machine machine{4, 1, 0.07 * 4 / 5};
    watch(machine, balancer, 100);
    machine.other *= factor;
    machine.besides = 0.07 * 4 * factor / (4 + factor);
    const Watched w = watch(machine, balancer, 100);
    EXPECT_LE(w.lastMove, 24);
    EXPECT_GE(busyShare(w.last), HybridBalancer::kLeastBusy);
    EXPECT_LE(busyShare(w.last), HybridBalancer::kMostBusy);
    EXPECT_LE(waitShare(w.last), HybridBalancer::kMostWait);
  }
}

TEST(HybridBalancer, UnevenRowsSettleToo) {
  for (const double ratio : {0.3, 1.0, 10.0, 100.0})
    for (const double start : {0.0, 0.125, 0.9}) {
      SCOPED_TRACE(testing::Message() << "ratio " << ratio << " start " << start);
      Machine machine{ratio, 1, 0.07 * ratio / (1 + ratio), 0, true};
      HybridBalancer balancer = HybridBalancer::dynamic(start);
      const Watched w = watch(machine, balancer, 400);
      EXPECT_LE(w.lastMove, 120);
      EXPECT_GE(busyShare(w.last), HybridBalancer::kLeastBusy);
      EXPECT_LE(busyShare(w.last), HybridBalancer::kMostBusy);
      EXPECT_LE(waitShare(w.last), HybridBalancer::kMostWait);
    }
}

TEST(HybridBalancer, NoiseDoesNotMakeItOscillate) {
  for (const double besides : {0.0, 0.03, 0.07})
    for (unsigned seed = 0; seed < 20; ++seed) {
      SCOPED_TRACE(testing::Message() << "besides " << besides << " seed " << seed);
      Machine machine{3, 1, besides * 0.75, 0.03};
      machine.random.seed(seed);
      HybridBalancer balancer = HybridBalancer::dynamic();
      watch(machine, balancer, 100);
      const Watched w = watch(machine, balancer, 2000);
      EXPECT_LE(w.moves, 4); // of 500 looks
      machine.noise = 0;
      const FrameTimes t = machine.run(balancer);
      EXPECT_GE(busyShare(t), HybridBalancer::kLeastBusy);
      EXPECT_LE(busyShare(t), 0.98);
      EXPECT_LE(waitShare(t), 0.08);
    }
}

TEST(HybridBalancer, ExtremeRatiosLeaveNearlyEverythingToTheFasterSide) {
  for (const double start : {0.0, 0.5, 1.0}) {
    HybridBalancer slowCpu = HybridBalancer::dynamic(start), fastCpu = HybridBalancer::dynamic(start);
    Machine slow{1000, 1}, fast{1, 1000};
    const Watched a = watch(slow, slowCpu, 200), b = watch(fast, fastCpu, 200);
    EXPECT_LE(slowCpu.cpuRows(kRows), 1);
    EXPECT_GE(fastCpu.cpuRows(kRows), kRows - 1);
    EXPECT_LE(std::max(a.lastMove, b.lastMove), 60);
    // No frame is slower than the faster side alone by more than the one row.
    EXPECT_LE(a.last.frame, 1.0);
    EXPECT_LE(b.last.frame, 1.0);
  }
  // Where one row is too much already, none is given.
  HybridBalancer few = HybridBalancer::dynamic(0.5);
  Machine slow{1000, 1};
  watch(slow, few, 200);
  EXPECT_EQ(few.cpuRows(64), 0);
}

TEST(HybridBalancer, FramesWithoutRowsOrTimeAreIgnored) {
  HybridBalancer balancer = HybridBalancer::dynamic(0.5, 1);
  balancer.frameDone({});
  balancer.frameDone({10, 5, 0, 0, 0, 0});
  EXPECT_EQ(balancer.cpuShare(), 0.5);
}

} // namespace volcaustic::test
