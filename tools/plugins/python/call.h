// Long calls into the library: without the interpreter's lock, stopped by Ctrl-C, with callbacks into Python.
#pragma once

#include "common.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <sys/types.h>
#include <thread>
#include <type_traits>
#include <volcaustic/run_context.h>

namespace volcaustic::python {

class Keywords;

/// The context of one call, or of a session's calls one after the other. All but stop() with the interpreter's lock.
class Call {
public:
  /// Takes threads, seed, device, memory_limit, progress and log out of the keywords.
  explicit Call(Keywords& keywords);
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  [[nodiscard]] RunContext& context() { return mContext; }
  /// Whether this thread runs a callback of this call now.
  [[nodiscard]] bool insideCallback() const { return mCallbackThread.load() == std::this_thread::get_id(); }
  /// Ends the call that is running with Error(Cancelled). From any thread.
  void stop() { mCancel = true; }

  /// Runs `work` without the interpreter's lock and returns its result. Rethrows what it throws; an exception of a
  /// callback or a signal handler (KeyboardInterrupt) stops the work and is rethrown in its place.
  template <class Work>
  auto run(Work&& work) -> std::invoke_result_t<Work> {
    using Result = std::invoke_result_t<Work>;
    if constexpr (std::is_void_v<Result>) {
      execute(work);
    } else {
      std::optional<Result> result;
      execute([&] { result.emplace(work()); });
      return std::move(*result);
    }
  }

  /// Calls into Python from a thread of the library. What the function throws stops the call and is kept for run().
  void callback(const std::function<void()>& function);

  py::object progress, log; ///< callables or None

private:
  void execute(const std::function<void()>& work);
  void runPolling(const std::function<void()>& work);
  void keep(std::exception_ptr raised);
  void reportProgress(std::string_view stage, double fraction);
  void reportLine(LogLevel level, std::string_view line);

  RunContext mContext;
  std::atomic<bool> mCancel{false};
  std::atomic<std::thread::id> mCallbackThread{};
  std::exception_ptr mRaised;
  pid_t mProcess = 0; ///< readers of foreign files fork; in the child there is no interpreter to call
  std::mutex mReporting;
  std::string mLastStage;
  std::chrono::steady_clock::time_point mLastReport{};
};

/// The interpreter's lock given up for as long as this lives, on behalf of a call that can be stopped, or of none. The
/// interpreter does not end before the lock is taken back. \throws Error(Cancelled) when it is ending.
class WithoutLock {
public:
  explicit WithoutLock(Call* call = nullptr) : mEntry(call) {}

private:
  class Entry {
  public:
    explicit Entry(Call* call);
    ~Entry();
    Entry(const Entry&) = delete;
    Entry& operator=(const Entry&) = delete;

  private:
    Call* mCall;
  };
  Entry mEntry;
  py::gil_scoped_release mRelease; ///< ends before the entry
};

/// Stops every call that runs and waits for them; calls that come later are refused. For the interpreter's end.
void endCalls();

} // namespace volcaustic::python
