#include "core/hashed_file.h"

#include "volcaustic/error.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace volcaustic {

namespace {
constexpr std::size_t kBufferBytes = 1 << 16;
} // namespace

HashedFile::HashedFile(const std::filesystem::path& path)
    : mFile(open(path.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC)), mBuffer(kBufferBytes) {
  if (mFile < 0) throw Error(ErrorKind::File, path.string() + ": cannot be written: " + std::strerror(errno));
  setp(mBuffer.data(), mBuffer.data() + mBuffer.size());
}

HashedFile::~HashedFile() { close(mFile); }

bool HashedFile::put(const char* data, std::size_t size) {
  if (mAt == mEnd) {
    mHash.add(data, size);
    mEnd += static_cast<off_type>(size);
  }
  while (size > 0) {
    const ssize_t written = pwrite(mFile, data, size, mAt);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    data += written;
    size -= static_cast<std::size_t>(written);
    mAt += written;
  }
  return true;
}

bool HashedFile::flushBuffer() {
  const auto size = static_cast<std::size_t>(pptr() - pbase());
  setp(mBuffer.data(), mBuffer.data() + mBuffer.size());
  return size == 0 || put(pbase(), size);
}

HashedFile::int_type HashedFile::overflow(int_type c) {
  if (!flushBuffer()) return traits_type::eof();
  if (!traits_type::eq_int_type(c, traits_type::eof())) {
    *pptr() = traits_type::to_char_type(c);
    pbump(1);
  }
  return traits_type::not_eof(c);
}

std::streamsize HashedFile::xsputn(const char* data, std::streamsize size) {
  if (size < epptr() - pptr()) {
    std::memcpy(pptr(), data, static_cast<std::size_t>(size));
    pbump(static_cast<int>(size));
    return size;
  }
  return flushBuffer() && put(data, static_cast<std::size_t>(size)) ? size : 0;
}

HashedFile::pos_type HashedFile::seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode which) {
  const off_type here = mAt + (pptr() - pbase());
  if (from == std::ios::cur && offset == 0) return here;
  const off_type end = std::max(mEnd, here);
  return seekpos(offset + (from == std::ios::beg ? 0 : from == std::ios::cur ? here : end), which);
}

HashedFile::pos_type HashedFile::seekpos(pos_type position, std::ios::openmode) {
  if (!flushBuffer() || position < 0 || position > mEnd) return pos_type(off_type(-1));
  mAt = position;
  return position;
}

int HashedFile::sync() { return flushBuffer() ? 0 : -1; }

} // namespace volcaustic
