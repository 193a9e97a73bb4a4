// The sink of bodies that run on the CPU, over a worker's sums.
#pragma once

#include "backends/lanes.h"

namespace volcaustic {

class CpuSink {
public:
  VOLCAUSTIC_HD CpuSink(CpuSums& sums, const FixedPoint& scale) : mSums(&sums), mScale(scale) {}

  void deposit(std::int32_t brick, std::int32_t offset, const kernels::Float3& powerLength,
               const kernels::Float3& direction) {
    std::int32_t(&s)[8] = mSums->bricks.touch(brick)[offset].s;
    const auto scale = static_cast<float>(mScale.deposit);
    bool full = false;
    const auto add = [&](int i, float v) {
      s[i] += static_cast<std::int32_t>(std::lrint(v * scale));
      full = full || s[i] >= LightBricks::kCarryAt || s[i] < -LightBricks::kCarryAt;
    };
    add(0, powerLength.x);
    add(1, powerLength.y);
    add(2, powerLength.z);
    add(4, direction.x);
    add(5, direction.y);
    add(6, direction.z);
    if (full) mSums->bricks.carry(brick, offset);
  }
  VOLCAUSTIC_HD void tally(kernels::Outcome outcome, const kernels::Double3& power) {
    std::int64_t* t = mSums->tally.power.data()[static_cast<int>(outcome)].data();
    t[0] += static_cast<std::int64_t>(power.x * mScale.tally);
    t[1] += static_cast<std::int64_t>(power.y * mScale.tally);
    t[2] += static_cast<std::int64_t>(power.z * mScale.tally);
  }
  VOLCAUSTIC_HD void count(kernels::Counter counter, std::int64_t n) {
    mSums->tally.counts.data()[static_cast<int>(counter)] += n;
  }

private:
  CpuSums* mSums;
  FixedPoint mScale;
};

} // namespace volcaustic
