#include "console.h"

#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

namespace volcaustic::cli {

Console::Console(Loudness loudness, ProgressStyle progress)
    : mLoudness(loudness)
    , mStyle(progress)
    , mShowsProgress(progress == ProgressStyle::Lines || (loudness != Loudness::Quiet && isatty(STDERR_FILENO))) {}

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

void Console::error(std::string_view line) { write(line); }

void Console::startFile(std::size_t index, std::size_t count) {
  const std::lock_guard lock(mMutex);
  if (index == 0) mFilesStart = Clock::now();
  mFile = index;
  mFiles = count;
}

std::string Console::stageText(Clock::time_point now) const {
  std::string text = fmt::format("{} {:3.0f} %", mStage, 100 * mFraction);
  const double seconds = std::chrono::duration<double>(now - mStageStart).count();
  if (seconds > 0.5 && mFraction > 0)
    text +=
        fmt::format("  {:.1f} %/s  {:.0f} s left", 100 * mFraction / seconds, seconds * (1 - mFraction) / mFraction);
  return text;
}

std::string Console::filesText(Clock::time_point now) const {
  std::string text = fmt::format("[{}/{}] {} {:3.0f} %", mFile + 1, mFiles, mStage, 100 * mFraction);
  const double seconds = std::chrono::duration<double>(now - mFilesStart).count();
  const auto done = static_cast<double>(mFile);
  if (mFile > 0 && seconds > 0)
    text += fmt::format("  {:.1f} files/s  {:.0f} s left", done / seconds,
                        seconds * (static_cast<double>(mFiles) - done) / done);
  return text;
}

void Console::progress(std::string_view stage, double fraction) {
  if (!mShowsProgress) return;
  const std::lock_guard lock(mMutex);
  const auto now = Clock::now();
  if (stage != mStage || fraction < mFraction) {
    mStage = stage;
    mStageStart = now;
    if (mFiles == 1 || mStyle == ProgressStyle::Lines) mLastDrawn = {};
  }
  mFraction = fraction;
  if (now - mLastDrawn < std::chrono::milliseconds(100)) return;
  mLastDrawn = now;
  const bool lines = mStyle == ProgressStyle::Lines;
  const std::string text = lines ? fmt::format("progress: {}/{} {} {:.3f}\n", mFile + 1, mFiles, mStage, mFraction)
                                 : "\r\x1b[K" + (mFiles > 1 ? filesText(now) : stageText(now));
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
  mProgressShown = !lines;
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
