// Hybrid and fallback tracers, over fakes: who traces which rows, what the sums come to, where exceptions go.

#include "transport/fallback.h"
#include "transport/hybrid.h"
#include "volcaustic/error.h"

#include <chrono>
#include <gtest/gtest.h>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>
#include <vector>

namespace volcaustic::test {

namespace {

constexpr int kRows = 60, kColumns = 5;
constexpr int kVoxel = sumsOffset(0, 0, 17); // that the fakes light

kernels::EmissionFrame raster(double depth = 0) {
  kernels::EmissionFrame frame;
  frame.columns = kColumns;
  frame.rows = kRows;
  frame.depth0 = depth;
  return frame;
}
const std::vector<float> kReachBounds(8);
const kernels::RasterReach kReach{1, 8, kReachBounds.data(), kReachBounds.data()};

/// A clock of each thread's own, which only the fakes' work moves: what a busy machine does in between does not count.
thread_local double workedSeconds = 0;
double workClock() { return workedSeconds; }

/// Sums one unit for each cell, into one voxel of one block; a row takes `rowTime`.
class FakeTracer final : public PhotonTracer {
public:
  struct Behaviour {
    std::int64_t block = 0;
    std::chrono::microseconds rowTime{0};
    const char* failAt = ""; ///< "emit", "trace" or "finish"
    ErrorKind kind = ErrorKind::Device;
  };
  explicit FakeTracer(Behaviour behaviour) : mBehaviour(behaviour) {}

  void emit(const kernels::EmissionFrame& frame, const kernels::RasterReach& reach, RowRange rows,
            const RasterCells& cellsOf) override {
    fail("emit");
    EXPECT_EQ(reach.rows, 8);
    EXPECT_EQ(reach.nearest[7], 0);
    work(rows);
    for (int i = rows.begin * kColumns; i < rows.end * kColumns; ++i) {
      cellsOf.entry[i] = static_cast<float>(i + frame.depth0);
      if (cellsOf.stops) stopped += cellsOf.stops[i] == static_cast<float>(i) ? 1 : 0;
    }
    emitted += rows.end - rows.begin;
  }
  void trace(const kernels::EmissionFrame& frame, RowRange rows, const RasterCells& cellsOf) override {
    fail("trace");
    work(rows);
    for (int row = rows.begin; row < rows.end; ++row) {
      traced.insert(row);
      for (int i = row * kColumns; i < (row + 1) * kColumns; ++i, ++cells)
        EXPECT_EQ(cellsOf.entry[i], static_cast<float>(i + frame.depth0));
    }
  }
  void finish() override {
    fail("finish");
    finished = true;
  }
  [[nodiscard]] bool touched(std::int64_t block) const override { return block == mBehaviour.block && cells > 0; }
  void addBlock(std::int64_t block, BlockSums& sums) const override {
    if (!touched(block)) return;
    sums.add(kVoxel, {cells, 0, 0, 0, 0, -cells});
  }
  [[nodiscard]] PhotonTally tally() const override {
    PhotonTally t;
    t.counts[0] = cells;
    t.power[1][2] = 2 * cells;
    return t;
  }
  [[nodiscard]] std::uint64_t peakBytes() const override { return 100; }

  std::multiset<int> traced;
  std::int64_t cells = 0, stopped = 0; ///< stopped: cells whose first receiver was as it should be, their number
  int emitted = 0;
  bool finished = false;

private:
  void work(RowRange rows) const {
    workedSeconds += std::chrono::duration<double>(mBehaviour.rowTime).count() * (rows.end - rows.begin);
  }
  void fail(const std::string& place) const {
    if (place == mBehaviour.failAt) throw Error(mBehaviour.kind, "fake: fails at " + place);
  }

  Behaviour mBehaviour;
};

std::int64_t sumOf(const PhotonTracer& tracer, std::int64_t block) {
  BlockSums sums;
  sums.clear();
  tracer.addBlock(block, sums);
  const VoxelSums voxel = sums.at(kVoxel);
  EXPECT_EQ(voxel[5], -voxel[0]);
  return voxel[0];
}

/// A hybrid of two fakes that stay in sight.
struct Pair {
  FakeTracer *cpu, *other;
  std::shared_ptr<HybridBalancer> balancer;
  std::unique_ptr<PhotonTracer> hybrid;

  Pair(FakeTracer::Behaviour a, FakeTracer::Behaviour b, HybridBalancer balance)
      : cpu(new FakeTracer(a)), other(new FakeTracer(b)), balancer(std::make_shared<HybridBalancer>(balance)) {
    hybrid =
        makeHybridTracer(std::unique_ptr<PhotonTracer>(cpu), std::unique_ptr<PhotonTracer>(other), balancer, workClock);
  }
  void runRaster() {
    const kernels::EmissionFrame frame = raster();
    std::vector<float> entry(kRows * kColumns, -1);
    hybrid->emit(frame, kReach, {0, kRows}, entry.data());
    hybrid->trace(frame, {0, kRows}, entry.data());
  }
};

} // namespace

TEST(HybridTracer, EveryRowIsTracedOnceAndSumsAddUp) {
  for (const double share : {0.0, 0.1, 0.5, 0.99, 1.0}) {
    SCOPED_TRACE(share);
    Pair pair({.block = 3}, {.block = 3}, HybridBalancer::fixed(share));
    pair.runRaster();
    pair.hybrid->finish();
    EXPECT_TRUE(pair.cpu->finished && pair.other->finished);
    EXPECT_EQ(pair.cpu->emitted + pair.other->emitted, kRows);
    EXPECT_EQ(static_cast<double>(pair.cpu->traced.size()), std::round(share * kRows));
    std::multiset<int> all = pair.cpu->traced;
    all.insert(pair.other->traced.begin(), pair.other->traced.end());
    ASSERT_EQ(all.size(), std::size_t{kRows});
    int next = 0;
    for (const int row : all) EXPECT_EQ(row, next++);
    EXPECT_EQ(sumOf(*pair.hybrid, 3), kRows * kColumns);
    EXPECT_EQ(sumOf(*pair.hybrid, 4), 0);
    EXPECT_TRUE(pair.hybrid->touched(3));
    EXPECT_FALSE(pair.hybrid->touched(4));
    EXPECT_EQ(pair.hybrid->tally().counts[0], kRows * kColumns);
    EXPECT_EQ(pair.hybrid->tally().power[1][2], 2 * kRows * kColumns);
    EXPECT_EQ(pair.hybrid->peakBytes(), 200u);
  }
}

TEST(HybridTracer, RowsInTheMiddleOfTheRasterAreSplitToo) {
  Pair pair({}, {}, HybridBalancer::fixed(0.5));
  std::vector<float> entry(kRows * kColumns, -1);
  pair.hybrid->emit(raster(), kReach, {20, 41}, entry.data());
  pair.hybrid->trace(raster(), {20, 41}, entry.data());
  EXPECT_EQ(*pair.cpu->traced.begin(), 20);
  EXPECT_EQ(*pair.other->traced.rbegin(), 40);
  EXPECT_EQ(pair.cpu->traced.size() + pair.other->traced.size(), 21u);
  EXPECT_EQ(entry[20 * kColumns - 1], -1);
  EXPECT_EQ(entry[41 * kColumns], -1);
}

TEST(HybridTracer, TheBalancerMovesRowsToTheFasterSide) {
  using std::chrono::microseconds;
  Pair pair({.rowTime = microseconds(400)}, {.rowTime = microseconds(50)}, HybridBalancer::dynamic(0.8, 1));
  for (int i = 0; i < 6; ++i) pair.runRaster();
  // Both would take the same time with 50/(400 + 50) of the rows; the CPU is wanted busy for 0.85 to 0.95 of the
  // other's.
  EXPECT_NEAR(pair.balancer->cpuShare(), 0.9 * 50 / (400 + 0.9 * 50), 1.0 / kRows);
}

TEST(HybridTracer, AnErrorOfEitherSideReachesTheCallerWhenBothHaveStopped) {
  for (const bool cpuFails : {true, false})
    for (const char* place : {"emit", "trace", "finish"}) {
      SCOPED_TRACE(testing::Message() << cpuFails << place);
      const FakeTracer::Behaviour fails{.failAt = place}, slow{.rowTime = std::chrono::microseconds(200)};
      Pair pair(cpuFails ? fails : slow, cpuFails ? slow : fails, HybridBalancer::fixed(0.5));
      std::vector<float> entry(kRows * kColumns);
      try {
        pair.runRaster();
        pair.hybrid->finish();
        FAIL() << "no error";
      } catch (const Error& e) {
        EXPECT_EQ(e.kind(), ErrorKind::Device);
        EXPECT_NE(std::string(e.what()).find(place), std::string::npos);
      }
      const FakeTracer& other = cpuFails ? *pair.other : *pair.cpu;
      EXPECT_EQ(other.emitted, kRows / 2);
    }
}

TEST(FallbackTracer, TheSecondDoesEverythingAgainWhereverTheFirstFails) {
  for (const char* place : {"emit", "trace", "finish"}) {
    SCOPED_TRACE(place);
    FakeTracer* second = nullptr;
    std::vector<std::string> errors;
    auto tracer = makeFallbackTracer(std::make_unique<FakeTracer>(FakeTracer::Behaviour{.failAt = place}),
                                     [&](const std::string& error) {
                                       errors.push_back(error);
                                       second = new FakeTracer({});
                                       return std::unique_ptr<PhotonTracer>(second);
                                     });
    for (const double depth : {0.0, 1000.0}) { // two lights, whose first bends differ and are gone at the end
      std::vector<float> entry(kRows * kColumns, -1), bounds(8);
      const kernels::RasterReach reach{1, 8, bounds.data(), bounds.data()};
      std::vector<float> stops(entry.size());
      std::iota(stops.begin(), stops.end(), 0.f);
      tracer->emit(raster(depth), reach, {0, 40}, {entry.data(), stops.data()});
      tracer->emit(raster(depth), reach, {40, kRows}, {entry.data(), stops.data()});
      EXPECT_EQ(entry.back(), static_cast<float>(kRows * kColumns - 1 + depth));
      tracer->trace(raster(depth), {0, kRows}, entry.data());
    }
    tracer->finish();
    ASSERT_EQ(errors.size(), 1u);
    EXPECT_EQ(second->cells, 2 * kRows * kColumns);
    EXPECT_EQ(second->emitted, 2 * kRows);
    EXPECT_EQ(second->stopped, 2 * kRows * kColumns);
    EXPECT_EQ(sumOf(*tracer, 0), 2 * kRows * kColumns);
    EXPECT_TRUE(second->finished);
  }
}

TEST(FallbackTracer, OnlyDeviceErrorsAndOnlyOnce) {
  std::vector<float> entry(kRows * kColumns);
  auto cancelled = makeFallbackTracer(
      std::make_unique<FakeTracer>(FakeTracer::Behaviour{.failAt = "emit", .kind = ErrorKind::Cancelled}),
      [](const std::string&) -> std::unique_ptr<PhotonTracer> {
        ADD_FAILURE() << "fell back";
        return nullptr;
      });
  EXPECT_THROW(cancelled->emit(raster(), kReach, {0, kRows}, entry.data()), Error);

  int made = 0;
  auto both = makeFallbackTracer(std::make_unique<FakeTracer>(FakeTracer::Behaviour{.failAt = "emit"}),
                                 [&](const std::string&) {
                                   ++made;
                                   return std::make_unique<FakeTracer>(FakeTracer::Behaviour{.failAt = "finish"});
                                 });
  both->emit(raster(), kReach, {0, kRows}, entry.data());
  EXPECT_THROW(both->finish(), Error);
  EXPECT_EQ(made, 1);
}

} // namespace volcaustic::test
