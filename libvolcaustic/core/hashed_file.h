// A file that is hashed while it is written, so that nobody has to read it again for that.
#pragma once

#include "core/xxhash64.h"

#include <filesystem>
#include <streambuf>
#include <vector>

namespace volcaustic {

/// For an std::ostream. Going back to patch bytes already written is possible, up to where they end; the hash is that
/// of the bytes as they were written first. A write that fails makes the stream bad and leaves the reason in errno.
class HashedFile : public std::streambuf {
public:
  /// Opens an existing file and empties it. \throws Error(File)
  explicit HashedFile(const std::filesystem::path& path);
  ~HashedFile() override;
  HashedFile(const HashedFile&) = delete;
  HashedFile& operator=(const HashedFile&) = delete;

  /// Of what has been flushed.
  [[nodiscard]] std::uint64_t digest() const { return mHash.digest(); }

protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* data, std::streamsize size) override;
  pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode which) override;
  pos_type seekpos(pos_type position, std::ios::openmode which) override;
  int sync() override;

private:
  bool put(const char* data, std::size_t size);
  bool flushBuffer();

  int mFile;
  std::vector<char> mBuffer;
  off_type mAt = 0;  ///< where the buffer goes
  off_type mEnd = 0; ///< of what has been flushed
  XxHash64 mHash;
};

} // namespace volcaustic
