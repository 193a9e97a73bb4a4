#include "console.h"

#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

namespace volcaustic::cli {

Console::Console(Loudness loudness)
    : mLoudness(loudness), mDrawsProgress(loudness != Loudness::Quiet && isatty(STDERR_FILENO)) {}

Console::~Console() { clearProgress(); }

void Console::say(std::string_view line) {
  if (mLoudness != Loudness::Quiet) write(line);
}

void Console::log(LogLevel level, std::string_view line) {
  if (level == LogLevel::Warning && mLoudness != Loudness::Quiet)
    write(fmt::format("warning: {}", line));
  else if (level != LogLevel::Warning && mLoudness == Loudness::Verbose)
    write(line);
}

void Console::progress(std::string_view stage, double fraction) {
  if (!mDrawsProgress) return;
  const std::lock_guard lock(mMutex);
  const auto now = Clock::now();
  if (stage != mStage || fraction < mFraction) {
    mStage = stage;
    mStageStart = now;
    mLastDrawn = {};
  }
  mFraction = fraction;
  if (now - mLastDrawn < std::chrono::milliseconds(100)) return;
  mLastDrawn = now;
  std::string text = fmt::format("\r\x1b[K{} {:3.0f} %", mStage, 100 * fraction);
  const double seconds = std::chrono::duration<double>(now - mStageStart).count();
  if (seconds > 0.5 && fraction > 0)
    text += fmt::format("  {:.1f} %/s  {:.0f} s left", 100 * fraction / seconds, seconds * (1 - fraction) / fraction);
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
  mProgressShown = true;
}

void Console::write(std::string_view line) {
  const std::lock_guard lock(mMutex);
  clearProgress();
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fputc('\n', stderr);
}

void Console::clearProgress() {
  if (!mProgressShown) return;
  std::fputs("\r\x1b[K", stderr);
  std::fflush(stderr);
  mProgressShown = false;
}

} // namespace volcaustic::cli
