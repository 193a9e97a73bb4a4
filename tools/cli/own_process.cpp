#include "own_process.h"

#include "common.h"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <fstream>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace volcaustic::cli {

namespace {

struct Pipe {
  int read = -1, write = -1;
  Pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0)
      throw Error(ErrorKind::Internal, "a pipe cannot be made; close other programs and try again");
    read = ends[0];
    write = ends[1];
  }
  ~Pipe() {
    close(read);
    closeWrite();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void closeWrite() {
    if (write >= 0) close(write);
    write = -1;
  }
};

/// Bytes of this process that count towards RLIMIT_DATA now: what the program holds without any work.
rlim_t ownDataBytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmData:")) return std::stoull(line.substr(7)) * 1024;
  return 0;
}

/// The child's side of fork: only calls that are safe beside other threads.
[[noreturn]] void becomeProgram(char* const* arguments, int output, int words, rlim_t dataLimit) {
  const rlimit limit{dataLimit, dataLimit};
  setrlimit(RLIMIT_DATA, &limit);
  dup2(output, STDOUT_FILENO);
  dup2(words, STDERR_FILENO);
  execv("/proc/self/exe", arguments);
  _exit(127);
}

/// Reads both pipes until the child has closed them, and passes an interrupt on to it.
void drain(pid_t child, std::array<pollfd, 2> pipes, const std::array<std::string*, 2>& texts) {
  std::array<char, 4096> buffer{};
  bool told = false;
  while (pipes[0].fd >= 0 || pipes[1].fd >= 0) {
    poll(pipes.data(), pipes.size(), 200);
    if (gInterrupted && !told) {
      kill(child, SIGTERM);
      told = true;
    }
    for (std::size_t i = 0; i < pipes.size(); ++i) {
      if (pipes[i].fd < 0 || pipes[i].revents == 0) continue;
      const ssize_t count = read(pipes[i].fd, buffer.data(), buffer.size());
      if (count > 0) texts[i]->append(buffer.data(), static_cast<std::size_t>(count));
      if (count == 0 || (count < 0 && errno != EINTR)) pipes[i].fd = -1;
    }
  }
}

} // namespace

ChildResult runOwnProgram(const std::vector<std::string>& arguments, std::uint64_t memoryLimit) {
  std::vector<std::string> words{"volcaustic"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);

  const rlim_t dataLimit = memoryLimit > 0 ? ownDataBytes() + memoryLimit : RLIM_INFINITY;
  Pipe out, err;
  const pid_t child = fork();
  if (child < 0) throw Error(ErrorKind::Internal, "a process cannot be started; close other programs and try again");
  if (child == 0) becomeProgram(pointers.data(), out.write, err.write, dataLimit);
  out.closeWrite();
  err.closeWrite();

  ChildResult result;
  drain(child, {{{out.read, POLLIN, 0}, {err.read, POLLIN, 0}}}, {&result.output, &result.words});
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (gInterrupted) throw Error(ErrorKind::Cancelled, "interrupted");
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

} // namespace volcaustic::cli
