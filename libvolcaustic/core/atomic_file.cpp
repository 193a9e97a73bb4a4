#include "core/atomic_file.h"

#include "volcaustic/error.h"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>

namespace volcaustic {

namespace {
std::atomic<unsigned> gCounter{0}; // distinguishes files of one process; names only, never results
} // namespace

AtomicFile::AtomicFile(std::filesystem::path target) : mTarget(std::move(target)) {
  std::error_code ignored;
  if (std::filesystem::is_directory(mTarget, ignored))
    throw Error(ErrorKind::File, mTarget.string() + ": is a folder; name a file to write");
  mTemporary = mTarget;
  mTemporary.replace_filename("." + mTarget.stem().string() + ".part" + std::to_string(getpid()) + "-" +
                              std::to_string(gCounter++) + mTarget.extension().string());
  const int file = open(mTemporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0)
    throw Error(ErrorKind::File, mTarget.string() + ": cannot write here: " + std::strerror(errno) +
                                     "; check that the folder exists and may be written");
  close(file);
}

AtomicFile::~AtomicFile() {
  std::error_code ignored;
  if (!mTemporary.empty()) std::filesystem::remove(mTemporary, ignored);
}

void AtomicFile::commit() {
  std::error_code error;
  std::filesystem::rename(mTemporary, mTarget, error);
  if (error) throw Error(ErrorKind::File, mTarget.string() + ": cannot rename the finished file: " + error.message());
  mTemporary.clear();
}

} // namespace volcaustic
