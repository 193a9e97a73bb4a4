// Where the rows of a frame are split between the CPU and another device (VD, results; docs/algorithms/cuda.md).
#pragma once

#include <cstdint>

namespace volcaustic {

/// What one frame took, in any unit of time.
struct FrameTimes {
  std::int64_t rows = 0;    ///< of the frame
  std::int64_t cpuRows = 0; ///< of these, the CPU's
  double frame = 0;         ///< from the start of both sides to the end of the later one
  double cpuBusy = 0;       ///< the CPU worked on its rows
  double cpuWait = 0;       ///< the CPU stood still until the other device was done
  double otherBusy = 0;     ///< the other device worked on its rows
};

/// Static balance keeps the CPU's share of the rows. Dynamic balance looks at every N-th frame, at the sums since the
/// last look: the CPU's busy share of a frame is wanted between 85 % and 95 % and its waiting at most 5 %; above, its
/// zone shrinks, below (or when it waits longer) it grows, inside nothing moves.
///
/// A move goes where both sides' speeds say the middle of what is wanted lies. A move back is at most half as long as
/// the one before, so that the boundary comes to rest even where noise is wider than what is wanted (a CPU that does
/// nothing but its rows and wait meets both conditions at 95 % exactly). At rest it stays until the ratio of the speeds
/// has changed by a tenth, the width of the band.
///
/// Plain arithmetic: the caller holds the clock. Not safe from several threads at once.
class HybridBalancer {
public:
  static constexpr double kLeastBusy = 0.85, kMostBusy = 0.95, kMostWait = 0.05;
  static constexpr double kFirstShare = 0.125;
  static constexpr int kLookEvery = 4;

  /// The same share in every frame.
  static HybridBalancer fixed(double cpuShare) { return HybridBalancer(cpuShare, 0); }
  /// Dynamic balance that starts at `cpuShare` and looks at every `lookEvery`-th frame.
  static HybridBalancer dynamic(double cpuShare = kFirstShare, int lookEvery = kLookEvery) {
    return HybridBalancer(cpuShare, lookEvery);
  }

  /// The CPU's part of `rows` rows: the first ones.
  [[nodiscard]] std::int64_t cpuRows(std::int64_t rows) const;
  [[nodiscard]] double cpuShare() const { return mShare; }

  /// Books a frame; every N-th time the boundary may move.
  void frameDone(const FrameTimes& times);

private:
  HybridBalancer(double cpuShare, int lookEvery);

  /// Sums since the last look.
  struct Window {
    int frames = 0;
    double cpuPart = 0; ///< sum of cpuRows/rows
    double frame = 0, cpuBusy = 0, cpuWait = 0, otherBusy = 0;
  };

  void look();
  void updateCosts();
  [[nodiscard]] bool speedsChanged() const;
  [[nodiscard]] double wantedShare(double wantedBusy) const;
  void moveTo(double share);

  double mShare;
  int mLookEvery; ///< 0: static
  Window mWindow;
  double mCpuCost = 0, mOtherCost = 0; ///< time for all rows at the latest speeds; 0: not known yet
  double mRestRatio = 0;               ///< mCpuCost/mOtherCost when the boundary came to rest; 0: not at rest
  bool mSpent = false;                 ///< at rest outside of what is wanted: moves have become too short
  double mLongest = 1;                 ///< the next move's greatest length
  double mLastMove = 0;
};

} // namespace volcaustic
