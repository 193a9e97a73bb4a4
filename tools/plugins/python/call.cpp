#include "call.h"

#include "keywords.h"

#include <limits>
#include <set>
#include <unistd.h>
#include <volcaustic/error.h>

namespace volcaustic::python {

namespace {

constexpr std::chrono::milliseconds kPoll{5};    ///< between looks at signals
constexpr std::chrono::milliseconds kReport{10}; ///< between reports of progress, each of which takes the lock

/// Only there do signal handlers run.
bool onMainThread() {
  const py::module_ threading = py::module_::import("threading");
  const py::object here = threading.attr("get_ident")();
  return here.equal(py::object(threading.attr("main_thread")().attr("ident")));
}

/// The calls that run, null for those that cannot be stopped. When the interpreter ends none may: a thread that comes
/// back for its lock then is killed inside C++, which ends the process.
struct Running {
  std::mutex mutex;
  std::condition_variable none;
  std::multiset<Call*> calls;
  bool closing = false;
};
Running& running() {
  static auto* const calls = new Running; // threads may outlive static objects
  return *calls;
}

py::object callableOr(py::object given, const char* name) {
  if (!given || given.is_none()) return py::none();
  if (!PyCallable_Check(given.ptr()))
    throw py::type_error(std::string(name) + " must be a callable or None, not " +
                         std::string(py::str(py::type::of(given))));
  return given;
}

} // namespace

WithoutLock::Entry::Entry(Call* call) : mCall(call) {
  const std::lock_guard lock(running().mutex);
  if (running().closing) throw Error(ErrorKind::Cancelled, "the interpreter is ending");
  running().calls.insert(mCall);
}

WithoutLock::Entry::~Entry() {
  const std::lock_guard lock(running().mutex);
  running().calls.erase(running().calls.find(mCall));
  running().none.notify_all();
}

Call::Call(Keywords& keywords) {
  ContextFields fields{mContext};
  keywords.into(fields);
  progress = callableOr(keywords.take("progress"), "progress");
  log = callableOr(keywords.take("log"), "log");
  if (log.is_none()) log = py::module_::import("volcaustic._logging").attr("log");
  mContext.cancel = &mCancel;
  mContext.onLog = [this](LogLevel level, std::string_view line) { reportLine(level, line); };
  if (!progress.is_none())
    mContext.onProgress = [this](std::string_view stage, double fraction) { reportProgress(stage, fraction); };
}

void Call::keep(std::exception_ptr raised) {
  if (!mRaised) mRaised = std::move(raised);
  mCancel = true;
}

void Call::callback(const std::function<void()>& function) {
  if (getpid() != mProcess || mCancel) return;
  const py::gil_scoped_acquire lock;
  mCallbackThread = std::this_thread::get_id();
  try {
    function();
  } catch (...) {
    keep(std::current_exception());
  }
  mCallbackThread = std::thread::id();
}

void Call::reportProgress(std::string_view stage, double fraction) {
  {
    const std::unique_lock only(mReporting, std::try_to_lock);
    if (!only) return;
    const auto now = std::chrono::steady_clock::now();
    if (stage == mLastStage && fraction < 1 && now - mLastReport < kReport) return;
    mLastStage = stage;
    mLastReport = now;
  }
  callback([&] { progress(py::str(stage.data(), stage.size()), fraction); });
}

void Call::reportLine(LogLevel level, std::string_view line) {
  constexpr const char* kLevels[] = {"detail", "info", "warning"};
  callback([&] { log(kLevels[static_cast<int>(level)], py::str(line.data(), line.size())); });
}

void Call::runPolling(const std::function<void()>& work) {
  std::mutex mutex;
  std::condition_variable ended;
  bool done = false;
  std::thread worker([&] {
    work();
    const std::lock_guard lock(mutex);
    done = true;
    ended.notify_one();
  });
  for (std::unique_lock lock(mutex); !ended.wait_for(lock, kPoll, [&] { return done; });) {
    lock.unlock();
    {
      const py::gil_scoped_acquire interpreter;
      if (PyErr_CheckSignals() != 0) keep(std::make_exception_ptr(py::error_already_set()));
    }
    lock.lock();
  }
  worker.join();
}

void Call::execute(const std::function<void()>& work) {
  mCancel = false;
  mRaised = nullptr;
  mProcess = getpid();
  mLastStage.clear();
  std::exception_ptr failure;
  const auto guarded = [&] {
    try {
      work();
    } catch (...) {
      failure = std::current_exception();
    }
  };
  const bool polling = onMainThread();
  {
    const WithoutLock release(this);
    if (polling)
      runPolling(guarded);
    else
      guarded();
  }
  if (mRaised) std::rethrow_exception(std::exchange(mRaised, nullptr));
  if (failure) std::rethrow_exception(failure);
}

void endCalls() {
  const py::gil_scoped_release release;
  std::unique_lock lock(running().mutex);
  running().closing = true;
  for (Call* call : running().calls)
    if (call) call->stop();
  running().none.wait_for(lock, std::chrono::seconds(10), [] { return running().calls.empty(); });
}

} // namespace volcaustic::python
