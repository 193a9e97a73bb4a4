#include "mesh/source.h"

#include "volcaustic/error.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace volcaustic {

namespace {

class FileDescriptor {
public:
  explicit FileDescriptor(int value) : mValue(value) {}
  ~FileDescriptor() {
    if (mValue >= 0) close(mValue);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  [[nodiscard]] int value() const { return mValue; }

private:
  int mValue;
};

std::string printable(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return result;
}

std::string lowerCase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// Reads to the end, whatever the size was said to be: the file may be a pipe, or grow.
std::string readAll(int file, std::size_t expected, const std::string& name, const RunContext& ctx) {
  std::string content;
  std::size_t size = 0;
  for (std::size_t room = expected + 1;;) {
    ctx.throwIfCancelled();
    ctx.requireMemory(room, name);
    content.resize(room);
    const ssize_t got = read(file, content.data() + size, room - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(ErrorKind::File, name + ": cannot be read: " + std::strerror(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
    if (size == room) room = std::max<std::size_t>(2 * room, 1 << 16);
  }
  content.resize(size);
  return content;
}

} // namespace

void MeshSource::fail(const std::string& what) const { throw Error(ErrorKind::Input, name + ": " + what); }

void MeshSource::failAtLine(std::uint64_t line, const std::string& what) const {
  throw Error(ErrorKind::Input, name + ":" + std::to_string(line) + ": " + what);
}

void MeshSource::failAtByte(std::size_t offset, const std::string& what) const {
  throw Error(ErrorKind::Input, name + ": byte " + std::to_string(offset) + ": " + what);
}

std::string quoted(std::string_view text) {
  constexpr std::size_t kLongest = 32;
  std::string result = printable(text.substr(0, kLongest));
  for (char& c : result)
    if (static_cast<unsigned char>(c) >= 0x80) c = '?';
  return "'" + result + (text.size() > kLongest ? "...'" : "'");
}

MeshSource loadMeshSource(const std::filesystem::path& path, const RunContext& ctx) {
  MeshSource source;
  const bool isStandardInput = path == "-";
  source.name = isStandardInput ? "<stdin>" : printable(path.string());
  source.extension = lowerCase(path.extension().string());
  const FileDescriptor file(isStandardInput ? fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)
                                            : open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status = {};
  if (file.value() < 0 || fstat(file.value(), &status) != 0)
    throw Error(ErrorKind::File, source.name + ": cannot be opened: " + std::strerror(errno));
  if (S_ISDIR(status.st_mode)) throw Error(ErrorKind::File, source.name + ": is a folder; name a mesh file");
  const std::size_t size = S_ISREG(status.st_mode) ? static_cast<std::size_t>(status.st_size) : 0;
  source.content = readAll(file.value(), size, source.name, ctx);
  if (source.content.starts_with("\xEF\xBB\xBF")) source.begin = 3;
  return source;
}

} // namespace volcaustic
