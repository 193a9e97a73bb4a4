#include "transport/hybrid.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <thread>

namespace volcaustic {

namespace {

double steadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// One side's part of a call.
struct Side {
  double busy = 0;
  std::exception_ptr error;

  template <class Work>
  void run(const Work& work, double (*now)()) noexcept {
    const double start = now();
    try {
      work();
    } catch (...) {
      error = std::current_exception();
    }
    busy = now() - start;
  }
};

class HybridTracer final : public PhotonTracer {
public:
  HybridTracer(std::unique_ptr<PhotonTracer> cpu, std::unique_ptr<PhotonTracer> other,
               std::shared_ptr<HybridBalancer> balancer, double (*now)())
      : mCpu(std::move(cpu))
      , mOther(std::move(other))
      , mBalancer(std::move(balancer))
      , mNow(now ? now : steadySeconds) {}

  void emit(const kernels::EmissionFrame& frame, const kernels::RasterReach& reach, RowRange rows,
            const RasterCells& cells) override {
    split(rows, [&](PhotonTracer& tracer, RowRange part) { tracer.emit(frame, reach, part, cells); });
  }

  void trace(const kernels::EmissionFrame& frame, RowRange rows, const RasterCells& cells) override {
    split(rows, [&](PhotonTracer& tracer, RowRange part) { tracer.trace(frame, part, cells); });
    mTimes.rows = rows.end - rows.begin;
    mTimes.cpuRows = mBalancer->cpuRows(mTimes.rows);
    mBalancer->frameDone(mTimes);
    mTimes = {};
  }

  void finish() override {
    mCpu->finish();
    mOther->finish();
  }

  [[nodiscard]] bool touched(std::int64_t block) const override {
    return mCpu->touched(block) || mOther->touched(block);
  }
  void addBlock(std::int64_t block, BlockSums& sums) const override {
    mCpu->addBlock(block, sums);
    mOther->addBlock(block, sums);
  }
  [[nodiscard]] PhotonTally tally() const override {
    PhotonTally sum = mCpu->tally();
    return sum += mOther->tally();
  }
  [[nodiscard]] std::uint64_t peakBytes() const override { return mCpu->peakBytes() + mOther->peakBytes(); }

private:
  /// Calls work(tracer, its rows) for both sides at once, and adds what it took to mTimes.
  template <class Work>
  void split(RowRange rows, const Work& work) {
    const auto boundary = static_cast<std::int32_t>(rows.begin + mBalancer->cpuRows(rows.end - rows.begin));
    const RowRange cpuRows{rows.begin, boundary}, otherRows{boundary, rows.end};
    Side cpu, other;
    std::thread helper;
    if (otherRows.begin < otherRows.end)
      helper = std::thread([&] {
        other.run(
            [&] {
              work(*mOther, otherRows);
              mOther->wait();
            },
            mNow);
      });
    if (cpuRows.begin < cpuRows.end) cpu.run([&] { work(*mCpu, cpuRows); }, mNow);
    if (helper.joinable()) helper.join();
    for (const Side* side : {&cpu, &other})
      if (side->error) std::rethrow_exception(side->error);
    mTimes.frame += std::max(cpu.busy, other.busy); // both start at once
    mTimes.cpuBusy += cpu.busy;
    mTimes.cpuWait += std::max(other.busy - cpu.busy, 0.0);
    mTimes.otherBusy += other.busy;
  }

  std::unique_ptr<PhotonTracer> mCpu, mOther;
  std::shared_ptr<HybridBalancer> mBalancer;
  double (*mNow)();
  FrameTimes mTimes; ///< since the balancer last heard
};

} // namespace

std::unique_ptr<PhotonTracer> makeHybridTracer(std::unique_ptr<PhotonTracer> cpu, std::unique_ptr<PhotonTracer> other,
                                               std::shared_ptr<HybridBalancer> balancer, double (*now)()) {
  return std::make_unique<HybridTracer>(std::move(cpu), std::move(other), std::move(balancer), now);
}

} // namespace volcaustic
