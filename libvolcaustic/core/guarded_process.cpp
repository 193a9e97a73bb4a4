#include "core/guarded_process.h"

#include "volcaustic/error.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <climits>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <new>
#include <optional>
#include <ostream>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <time.h>
#include <unistd.h>
#include <utility>
#include <vector>

namespace volcaustic {

namespace {

constexpr std::chrono::seconds kStallLimit{15}; // no processor time used for this long: stuck, not slow

/// What the child says besides its bytes; lives in memory that both processes share.
struct Verdict {
  enum State : int { Running, Done, Failed, OutOfMemory };
  State state = Running;
  ErrorKind kind = ErrorKind::Input;
  bool isError = false; // an Error of ours, to be passed on as it is
  char message[2048] = {};

  void fail(const char* text) {
    std::strncpy(message, text, sizeof message - 1);
    state = Failed;
  }
};

class SharedVerdict {
public:
  SharedVerdict() : mMemory(mmap(nullptr, sizeof(Verdict), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (mMemory == MAP_FAILED)
      throw Error(ErrorKind::Internal, "guard: no shared memory: " + std::string(strerror(errno)));
    new (mMemory) Verdict;
  }
  ~SharedVerdict() { munmap(mMemory, sizeof(Verdict)); }
  SharedVerdict(const SharedVerdict&) = delete;
  SharedVerdict& operator=(const SharedVerdict&) = delete;
  [[nodiscard]] Verdict& operator*() const { return *static_cast<Verdict*>(mMemory); }

private:
  void* mMemory;
};

/// A file without a name that lives in memory.
class MemoryFile {
public:
  MemoryFile() : mDescriptor(memfd_create("volcaustic", MFD_CLOEXEC)) {
    if (mDescriptor < 0) throw Error(ErrorKind::Internal, "guard: no memory file: " + std::string(strerror(errno)));
  }
  ~MemoryFile() { close(mDescriptor); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  [[nodiscard]] int descriptor() const { return mDescriptor; }

private:
  int mDescriptor;
};

class DescriptorBuffer : public std::streambuf {
public:
  explicit DescriptorBuffer(int descriptor) : mDescriptor(descriptor), mBuffer(1 << 20) {
    setp(mBuffer.data(), mBuffer.data() + mBuffer.size());
  }

protected:
  int_type overflow(int_type c) override {
    if (sync() != 0) return traits_type::eof();
    if (!traits_type::eq_int_type(c, traits_type::eof())) sputc(traits_type::to_char_type(c));
    return traits_type::not_eof(c);
  }
  int sync() override {
    for (const char* p = pbase(); p < pptr();) {
      const ssize_t written = write(mDescriptor, p, static_cast<std::size_t>(pptr() - p));
      if (written < 0 && errno != EINTR) return -1;
      p += std::max<ssize_t>(written, 0);
    }
    setp(mBuffer.data(), mBuffer.data() + mBuffer.size());
    return 0;
  }

private:
  int mDescriptor;
  std::vector<char> mBuffer;
};

std::uint64_t addressSpaceInUse() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t pages = 0;
  statm >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
}

void limitResource(decltype(RLIMIT_AS) resource, std::uint64_t value) {
  rlimit limit{};
  getrlimit(resource, &limit);
  limit.rlim_cur = limit.rlim_max = std::min<rlim_t>(limit.rlim_max, value);
  setrlimit(resource, &limit);
}

/// Signals, limits and standard streams of the child.
void enterGuard(const GuardLimits& limits, std::uint64_t addressSpace, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  // Handlers of the host program (crash reporters, its Ctrl-C) are not for this process.
  for (int s = 1; s < NSIG; ++s) signal(s, SIG_DFL);
  signal(SIGINT, SIG_IGN); // the parent sees it and ends the child
  signal(SIGXFSZ, SIG_IGN);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  limitResource(RLIMIT_CORE, 0);
  limitResource(RLIMIT_AS, addressSpace + limits.memoryBytes);
  limitResource(RLIMIT_FSIZE, limits.memoryBytes);
  limitResource(RLIMIT_CPU, static_cast<std::uint64_t>(std::ceil(limits.cpuSeconds)));
  if (const int null = open("/dev/null", O_RDWR | O_CLOEXEC); null >= 0) {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(null, stream);
    close(null);
  }
}

void parseInto(int descriptor, Verdict& verdict, const std::function<void(std::ostream&)>& parse) {
  try {
    DescriptorBuffer buffer(descriptor);
    std::ostream out(&buffer);
    parse(out);
    if (out.flush())
      verdict.state = Verdict::Done;
    else
      verdict.state = Verdict::OutOfMemory; // beyond RLIMIT_FSIZE
  } catch (const Error& error) {
    verdict.kind = error.kind();
    verdict.isError = true;
    verdict.fail(error.what());
  } catch (const std::bad_alloc&) {
    verdict.state = Verdict::OutOfMemory;
  } catch (const std::length_error&) { // a container was asked for an absurd size
    verdict.state = Verdict::OutOfMemory;
  } catch (const std::exception& error) {
    verdict.fail(error.what());
  } catch (...) {
    verdict.fail("unknown exception");
  }
}

/// A child process that is ended and reaped at the latest when its owner goes.
class Child {
public:
  explicit Child(pid_t pid) : mPid(pid) {}
  ~Child() {
    if (mPid <= 0) return;
    kill(mPid, SIGKILL);
    while (waitpid(mPid, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// True once the child has ended. `signal` is what ended it; 0 also when the host program reaps children by itself.
  bool ended(int& signal) {
    int status = 0;
    const pid_t result = waitpid(mPid, &status, WNOHANG);
    if (result == 0 || (result < 0 && errno == EINTR)) return false;
    mPid = 0;
    signal = result > 0 && WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    return true;
  }

  [[nodiscard]] double cpuSeconds() const {
    clockid_t clock{};
    timespec time{};
    if (clock_getcpuclockid(mPid, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }

private:
  pid_t mPid;
};

/// Waits until the child ends and returns its signal, or nothing when it was stuck.
std::optional<int> waitFor(Child& child, const RunContext& ctx) {
  using Clock = std::chrono::steady_clock;
  auto pause = std::chrono::microseconds(100);
  auto progressAt = Clock::now();
  double cpu = 0;
  int signal = 0;
  while (!child.ended(signal)) {
    ctx.throwIfCancelled();
    if (const double now = child.cpuSeconds(); now > cpu + 1e-3) {
      cpu = now;
      progressAt = Clock::now();
    } else if (Clock::now() - progressAt > kStallLimit) {
      return std::nullopt;
    }
    std::this_thread::sleep_for(pause);
    pause = std::min(pause * 5 / 4, std::chrono::microseconds(20000));
  }
  return signal;
}

std::string oneLine(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = ' ';
  const auto end = text.find_last_not_of(" ;.");
  return text.substr(0, std::min<std::size_t>(end == std::string::npos ? 0 : end + 1, 1000));
}

/// What went wrong and what to try.
std::string describe(const Verdict& verdict, int signal, const GuardLimits& limits) {
  const std::string remedy = "; write it again with the program that made it";
  if (signal == SIGXCPU || signal == SIGKILL)
    return "reading it took more than " + std::to_string(static_cast<int>(std::ceil(limits.cpuSeconds))) + " s" +
           remedy;
  if (signal) return std::string("reading it ended in a crash (") + strsignal(signal) + ")" + remedy;
  if (verdict.state == Verdict::OutOfMemory)
    return "it asks for more than " + std::to_string(limits.memoryBytes >> 20) + " MiB of memory" + remedy +
           ", or raise --memory-limit";
  if (verdict.state == Verdict::Failed) return oneLine(verdict.message) + remedy;
  return "reading it ended without a result" + remedy;
}

} // namespace

GuardLimits GuardLimits::forFile(std::uint64_t fileBytes, const RunContext& ctx) {
  constexpr std::uint64_t kBase = std::uint64_t{512} << 20, kExpansion = 1024;
  const std::uint64_t room =
      fileBytes > (UINT64_MAX - kBase) / kExpansion ? UINT64_MAX : kBase + kExpansion * fileBytes;
  return {std::min(ctx.effectiveMemoryLimit(), room), 8 + static_cast<double>(fileBytes) / (4 << 20)};
}

GuardedBytes::GuardedBytes(int descriptor) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0) throw Error(ErrorKind::Internal, "guard: " + std::string(strerror(errno)));
  if (status.st_size == 0) return;
  void* memory = mmap(nullptr, static_cast<std::size_t>(status.st_size), PROT_READ, MAP_PRIVATE, descriptor, 0);
  if (memory == MAP_FAILED) throw Error(ErrorKind::Internal, "guard: cannot map: " + std::string(strerror(errno)));
  mData = static_cast<const char*>(memory);
  mSize = static_cast<std::size_t>(status.st_size);
}

GuardedBytes::~GuardedBytes() {
  if (mData) munmap(const_cast<char*>(mData), mSize);
}

GuardedBytes::GuardedBytes(GuardedBytes&& other) noexcept
    : mData(std::exchange(other.mData, nullptr)), mSize(std::exchange(other.mSize, 0)) {}

GuardedBytes& GuardedBytes::operator=(GuardedBytes&& other) noexcept {
  std::swap(mData, other.mData);
  std::swap(mSize, other.mSize);
  return *this;
}

MemoryBuffer::MemoryBuffer(std::span<const char> bytes) {
  char* begin = const_cast<char*>(bytes.data()); // streambuf's interface; a get area is never written
  setg(begin, begin, begin + bytes.size());
}

MemoryBuffer::pos_type MemoryBuffer::seekoff(off_type offset, std::ios_base::seekdir origin, std::ios_base::openmode) {
  const off_type base = origin == std::ios_base::beg   ? 0
                        : origin == std::ios_base::cur ? gptr() - eback()
                                                       : egptr() - eback();
  if (base + offset < 0 || base + offset > egptr() - eback()) return pos_type(off_type(-1));
  setg(eback(), eback() + base + offset, egptr());
  return pos_type(base + offset);
}

MemoryBuffer::pos_type MemoryBuffer::seekpos(pos_type position, std::ios_base::openmode which) {
  return seekoff(off_type(position), std::ios_base::beg, which);
}

std::uint64_t readableFileSize(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0 || access(path.c_str(), R_OK) != 0)
    throw Error(ErrorKind::File,
                path + ": cannot be opened: " + strerror(errno) + "; check the name and the permissions");
  if (!S_ISREG(status.st_mode)) throw Error(ErrorKind::File, path + ": is not a regular file; name a file to read");
  return static_cast<std::uint64_t>(status.st_size);
}

GuardedBytes runGuarded(const std::string& place, const GuardLimits& limits, const RunContext& ctx,
                        const std::function<void(std::ostream&)>& parse) {
  constexpr int kAttempts = 2;
  const std::uint64_t addressSpace = addressSpaceInUse();
  const pid_t parent = getpid();
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const MemoryFile file;
    const SharedVerdict verdict;
    const pid_t pid = fork();
    if (pid < 0) throw Error(ErrorKind::Internal, "guard: cannot start a process: " + std::string(strerror(errno)));
    if (pid == 0) {
      enterGuard(limits, addressSpace, parent);
      parseInto(file.descriptor(), *verdict, parse);
      _exit(0);
    }
    Child child(pid);
    const std::optional<int> signal = waitFor(child, ctx);
    if (!signal) continue;
    // A lock that nobody will open is waited for by standing still, or by spinning.
    if ((*signal == SIGXCPU || *signal == SIGKILL) && attempt + 1 < kAttempts) continue;
    if (*signal == 0 && (*verdict).state == Verdict::Done) return GuardedBytes(file.descriptor());
    if (*signal == 0 && (*verdict).isError) throw Error((*verdict).kind, oneLine((*verdict).message));
    throw Error(ErrorKind::Input, place + ": damaged: " + describe(*verdict, *signal, limits));
  }
  throw Error(ErrorKind::Input, place + ": cannot be read: no progress for " + std::to_string(kStallLimit.count()) +
                                    " s; check the disk it lies on");
}

} // namespace volcaustic
