#include "transport/balancer.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

constexpr double kProbe = 1 / 64.0; // first rows of a side that has had none, to learn its speed
constexpr double kShortest =
    1 / 100.0;                       // of the smaller side's share; shorter moves change nothing that can be measured
constexpr double kSpeedChange = 0.1; // of the ratio of both speeds
constexpr double kMostOtherIdle = 0.05; // of a frame

} // namespace

HybridBalancer::HybridBalancer(double cpuShare, int lookEvery)
    : mShare(std::clamp(cpuShare, 0.0, 1.0)), mLookEvery(lookEvery) {}

std::int64_t HybridBalancer::cpuRows(std::int64_t rows) const {
  return std::clamp<std::int64_t>(std::llround(mShare * static_cast<double>(rows)), 0, rows);
}

void HybridBalancer::frameDone(const FrameTimes& t) {
  if (!mLookEvery || t.rows <= 0 || !(t.frame > 0)) return;
  mWindow.cpuPart += static_cast<double>(t.cpuRows) / static_cast<double>(t.rows);
  mWindow.frame += t.frame;
  mWindow.cpuBusy += t.cpuBusy;
  mWindow.cpuWait += t.cpuWait;
  mWindow.otherBusy += t.otherBusy;
  if (++mWindow.frames < mLookEvery) return;
  look();
  mWindow = {};
}

void HybridBalancer::look() {
  updateCosts();
  if (speedsChanged()) {
    mRestRatio = 0;
    mSpent = false;
    mLongest = 1;
    mLastMove = 0;
  }
  const double busy = mWindow.cpuBusy / mWindow.frame, wait = mWindow.cpuWait / mWindow.frame;
  const double otherIdle = 1 - mWindow.otherBusy / mWindow.frame;
  // What the CPU does besides its rows narrows what it can reach.
  const double besides = std::max(1 - busy - wait, 0.0);
  const double high = std::min(kMostBusy, 1 - besides);
  const double low = std::min(std::max(kLeastBusy, kMostBusy - besides), high);

  if (busy >= std::min(kLeastBusy, high) && busy <= kMostBusy && wait <= kMostWait && otherIdle <= kMostOtherIdle) {
    mRestRatio = mOtherCost > 0 ? mCpuCost / mOtherCost : 0;
    return;
  }
  if (!mSpent) moveTo(wantedShare((low + high) / 2));
}

void HybridBalancer::updateCosts() {
  const double cpuPart = mWindow.cpuPart, otherPart = mWindow.frames - mWindow.cpuPart;
  if (cpuPart > 0 && mWindow.cpuBusy > 0) mCpuCost = mWindow.cpuBusy / cpuPart;
  if (otherPart > 0 && mWindow.otherBusy > 0) mOtherCost = mWindow.otherBusy / otherPart;
}

bool HybridBalancer::speedsChanged() const {
  return mRestRatio > 0 && std::abs(mCpuCost / mOtherCost / mRestRatio - 1) > kSpeedChange;
}

/// The share x at which the CPU's time x*mCpuCost is `wantedBusy` of the other side's (1 - x)*mOtherCost.
double HybridBalancer::wantedShare(double wantedBusy) const {
  if (!(mCpuCost > 0)) return mShare + kProbe;
  if (!(mOtherCost > 0)) return mShare - kProbe;
  return wantedBusy * mOtherCost / (mCpuCost + wantedBusy * mOtherCost);
}

void HybridBalancer::moveTo(double share) {
  double move = std::clamp(share, 0.0, 1.0) - mShare;
  if (move * mLastMove < 0) mLongest = std::abs(mLastMove) / 2;
  move = std::clamp(move, -mLongest, mLongest);
  if (std::abs(move) < kShortest * std::min(mShare, 1 - mShare)) {
    mSpent = true;
    mRestRatio = mOtherCost > 0 ? mCpuCost / mOtherCost : 0;
    return;
  }
  mShare += move;
  mLastMove = move;
}

} // namespace volcaustic
