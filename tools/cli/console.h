// Words for people, on stderr: lines, warnings, and a progress line that is only drawn on a terminal.
#pragma once

#include <volcaustic/run_context.h>

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>

namespace volcaustic::cli {

enum class Loudness {
  Quiet,  ///< errors only
  Normal, ///< and warnings, progress, results
  Verbose ///< and what the library tells on the way
};

/// Safe to call from several threads.
class Console {
public:
  explicit Console(Loudness loudness);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  /// A line for people; not when quiet.
  void say(std::string_view line);
  void log(LogLevel level, std::string_view line);
  [[nodiscard]] bool isVerbose() const { return mLoudness == Loudness::Verbose; }
  /// "photons  45 %  12 %/s  4 s left", redrawn ten times a second.
  void progress(std::string_view stage, double fraction);

private:
  using Clock = std::chrono::steady_clock;

  void write(std::string_view line);
  void clearProgress();

  const Loudness mLoudness;
  const bool mDrawsProgress;
  std::mutex mMutex;
  std::string mStage;
  double mFraction = 0;
  Clock::time_point mStageStart, mLastDrawn;
  bool mProgressShown = false;
};

} // namespace volcaustic::cli
