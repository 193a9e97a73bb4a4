// Words for people, on stderr: lines, warnings, and progress, drawn in place on a terminal or in lines for a program.
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

enum class ProgressStyle {
  OnTerminal, ///< redrawn in place, on a terminal only
  Lines       ///< "progress: 3/48 photons 0.420", for the program that has started this one
};

/// Safe to call from several threads.
class Console {
public:
  explicit Console(Loudness loudness, ProgressStyle progress = ProgressStyle::OnTerminal);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  /// A line for people; not when quiet.
  void say(std::string_view line);
  void log(LogLevel level, std::string_view line);
  /// A line that is never left out.
  void error(std::string_view line);
  [[nodiscard]] bool isVerbose() const { return mLoudness == Loudness::Verbose; }
  /// Ten times a second: "photons  45 %  12 %/s  4 s left"; between startFile and the last file
  /// "[3/100] medium  45 %  2.1 files/s  46 s left".
  void progress(std::string_view stage, double fraction);
  /// File `index` of `count` begins; one file alone is not counted.
  void startFile(std::size_t index, std::size_t count);

private:
  using Clock = std::chrono::steady_clock;

  void write(std::string_view line);
  [[nodiscard]] std::string stageText(Clock::time_point now) const;
  [[nodiscard]] std::string filesText(Clock::time_point now) const;
  void clearProgress();

  const Loudness mLoudness;
  const ProgressStyle mStyle;
  const bool mShowsProgress;
  std::mutex mMutex;
  std::string mStage;
  double mFraction = 0;
  std::size_t mFile = 0, mFiles = 1;
  Clock::time_point mStageStart, mFilesStart, mLastDrawn;
  bool mProgressShown = false;
};

} // namespace volcaustic::cli
